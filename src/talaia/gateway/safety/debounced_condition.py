"""One condition of an interlock over time: where it trips, where it lets go, how long it must hold.

Pure. What a value says by itself is `condition_judge.judge_reading`'s; here is what it says after
what was before: a limit with a second one to let go (a Schmitt trigger), and a limit that must be
passed for a while.

A while is counted over a window of twice `lasting`: it trips when it was bad for `lasting` of that
in all, half of the time. What stays bad trips after `lasting`; a wind that comes and goes trips,
too, and one good sample does not begin the count anew.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.gateway.safety.interlock_state import InterlockVerdict

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.interlocks.interlock import Condition

__all__ = ["DebouncedCondition"]


class BadTimeWindow:
    """For how long something was bad within a window of time. Bounded in memory."""

    # Resolution: a hundredth of the window, so that memory does not grow with the rate of values.
    PARTS = 100

    def __init__(self, window_ns: int) -> None:
        """Have seen nothing yet."""
        self._window_ns = window_ns  # Twice `lasting`, ns.
        # At least 1 ns, for `lasting: 0` makes an empty window.
        self._part_ns = max(1, window_ns // self.PARTS)
        # Stretches of time by number, oldest first, and how long each was bad (ns).
        self._parts: deque[tuple[int, int]] = deque()
        self._total_ns = 0  # Sum over `_parts`, so that no look has to add a hundred numbers.
        # Up to when time has been counted; None before the first look.
        self._seen_ns: int | None = None
        self._bad = False  # How it was at `_seen_ns`, and so until now.

    def add_reading(self, now_ns: int, *, bad: bool) -> int:
        """Take in how it is from now on; give for how long it was bad within the window (ns)."""
        if self._seen_ns is not None and self._bad:
            # After a long standstill only what lies within the window counts.
            self._count_span(max(self._seen_ns, now_ns - self._window_ns), now_ns)
        self._seen_ns, self._bad = now_ns, bad
        oldest = (now_ns - self._window_ns) // self._part_ns
        while self._parts and self._parts[0][0] < oldest:
            self._total_ns -= self._parts.popleft()[1]
        return self._total_ns

    def _count_span(self, from_ns: int, to_ns: int) -> None:
        while from_ns < to_ns:
            number = from_ns // self._part_ns
            end_ns = min(to_ns, (number + 1) * self._part_ns)
            # The newest stretch is opened again, for looks come more often than stretches end.
            was = self._parts.pop()[1] if self._parts and self._parts[-1][0] == number else 0
            self._parts.append((number, was + end_ns - from_ns))
            self._total_ns += end_ns - from_ns
            from_ns = end_ns


class DebouncedCondition:
    """The memory of one condition.

    Attributes:
        condition: its description.

    """

    def __init__(self, condition: Condition) -> None:
        """Start as not tripped: the interlock itself begins locked."""
        self.condition = condition
        self._lasting_ns = round(condition.lasting * SECOND)  # 0 trips at once.
        # Once tripped it is judged by the limits at which it lets go.
        self._tripped = msgspec.structs.replace(
            condition,
            above=condition.above if condition.until_below is None else condition.until_below,
            below=condition.below if condition.until_above is None else condition.until_above,
        )
        # It has tripped, and has not let go since.
        self._on = False
        self._bad_time = BadTimeWindow(2 * self._lasting_ns)

    def judge_condition(
        self, judge: Callable[[Condition], InterlockVerdict], now_ns: int
    ) -> InterlockVerdict:
        """Say how it stands.

        Args:
            judge: what the newest value says of a condition with some limits.
            now_ns: monotonic.

        """
        verdict = judge(self._tripped if self._on else self.condition)
        # Unknown counts as bad time: what turns out bad afterwards has been bad since nobody knew.
        bad_ns = (
            self._bad_time.add_reading(now_ns, bad=bool(verdict.why)) if self._lasting_ns else 0
        )
        if not verdict.why:
            self._on = False
            return verdict
        if verdict.unknown:
            # The dwell time of a limit is for what was measured beyond it, not for a silence.
            return verdict
        if not self._on and bad_ns < self._lasting_ns:
            return InterlockVerdict()
        self._on = True
        return verdict._replace(dwell=self.condition.dwell)
