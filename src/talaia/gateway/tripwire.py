"""One condition of an interlock over time: where it trips, where it lets go, how long it must hold.

Pure. What a value says by itself is `interlocks.judged`'s; here is what it says after what was
before: a limit with a second one to let go (a Schmitt trigger), and a limit that must be passed
for a while.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.gateway.latch import Verdict

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.interlock import Condition

__all__ = ["Tripwire"]


class Tripwire:
    """The memory of one condition."""

    def __init__(self, condition: Condition) -> None:
        """Start as not tripped: the interlock itself begins locked."""
        self._condition = condition
        self._lasting_ns = round(condition.lasting * SECOND)
        # Once tripped it is judged by the limits at which it lets go.
        self._tripped = msgspec.structs.replace(
            condition,
            above=condition.above if condition.until_below is None else condition.until_below,
            below=condition.below if condition.until_above is None else condition.until_above,
        )
        self._on = False
        self._since_ns: int | None = None

    def look(self, judge: Callable[[Condition], Verdict], now_ns: int) -> Verdict:
        """Say how it stands.

        Args:
            judge: what the newest value says of a condition with some limits.
            now_ns: monotonic.

        """
        verdict = judge(self._tripped if self._on else self._condition)
        if not verdict.why:
            self._on, self._since_ns = False, None
            return verdict
        if verdict.unknown:
            # The dwell time of a limit is for what was measured beyond it, not for a silence.
            return verdict
        if self._since_ns is None:
            self._since_ns = now_ns
        if not self._on and now_ns - self._since_ns < self._lasting_ns:
            return Verdict()
        self._on = True
        return verdict._replace(dwell=self._condition.dwell)
