"""Several signals of a machine that runs in several ways: each has its own notion of usual.

A charging robot is not unusual, though nothing of it is as when it drives. The way of running is
told by a state, or found among the rows of the learning stretch.

Long, because modes that are told and modes that are found share how rows come and are judged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import Floats  # noqa: TC001 - msgspec reads the annotations
from talaia.hub.anomaly.groups.group import (
    FEWEST_LEARNED,
    GroupDetector,
    most_learned,
)
from talaia.hub.anomaly.groups.held_values import NEVER, HeldValues, bounded_values
from talaia.hub.anomaly.groups.mode_search import (
    assign_modes,
    find_modes,
    likeliest_modes,
    mode_widths,
    scale_levels,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.groups.whitening import SignalShare

__all__ = ["MOST_MODES", "ModalGroup"]

MOST_MODES = 16
# A row is judged once the machine has stayed in its mode for so many rows after it, and not within
# so many after a change: a state and the signals never change in the same moment.
_SETTLING = 5
# So many rows of what modes were found in are passed on with each new one, not all at once.
_PASSED_ON = 50
_UNKNOWN = -1


class ModalGroup(msgspec.Struct, kw_only=True):
    """A `GroupDetector` for each mode; with one mode it is that detector and nothing else.

    Give it either samples as they come (`see`) or whole rows (`see_row`), not both.

    Attributes:
        signals: their names.
        learn_rows: from so many first steps of each mode it learns what is usual in it.
        step_us: so long is a step (µs); 0: as long as the rows of the learning stretch lie apart.
        by_state: modes are told with the rows; otherwise they are found.
        most_modes: at most so many are found; 1: it runs in one way.
        mode: the one that is judged by now; -1: none is known.

    """

    signals: list[str]
    learn_rows: int = 600
    step_us: int = 1_000_000
    by_state: bool = False
    most_modes: int = 1
    mode: int = _UNKNOWN
    members: dict[int, GroupDetector] = msgspec.field(default_factory=dict)
    held: HeldValues = msgspec.field(default_factory=lambda: HeldValues(count=0))
    # So many rows came, and the state that was told last.
    heard: int = 0
    state: int = _UNKNOWN
    # Rows since the mode changed, and those that wait until it is certain that it stays.
    settled: int = 0
    waiting: list[tuple[int, Floats]] = msgspec.field(default_factory=list)
    # Of modes that are found: the rows of the learning stretch with their times, how many there
    # are, and how many were passed on to their modes.
    rows: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    times: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    counted: int = 0
    passed: int = 0
    # What levels are compared by, and the modes' middles and widths, row after row. Versions before
    # kept no widths.
    center: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    scale: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    middles: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    widths: Floats = msgspec.field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Make room; ``ValueError`` where a bound is broken."""
        count = len(self.signals)
        if self.held.count == count:
            return
        if not 1 <= self.most_modes <= MOST_MODES:
            raise ValueError(f"expected 1 to {MOST_MODES} modes, found {self.most_modes}")
        # It refuses too many signals and rows, too.
        self.members = {0: self._new_member(self.learn_rows)} if self._is_plain() else {}
        GroupDetector(signals=self.signals, learn_rows=self.learn_rows)
        self.held = HeldValues(count=count)
        if not self.by_state and self.most_modes > 1:
            self.rows, self.times = np.empty(self.learn_rows * count), np.empty(self.learn_rows)
        if self._is_plain():
            self.mode = 0

    def _is_plain(self) -> bool:
        return not self.by_state and self.most_modes == 1

    def _has_one_mode(self) -> bool:
        """Nothing changes in it, so no row has to wait until it is certain."""
        return not self.by_state and len(self.members) == 1

    def _new_member(self, learn_rows: int) -> GroupDetector:
        return GroupDetector(
            signals=self.signals,
            learn_rows=min(max(learn_rows, FEWEST_LEARNED), most_learned(len(self.signals))),
            step_us=self.step_us,
        )

    # ── what comes in ───────────────────────────────────────────────────────────────────────

    def see(self, time_us: int, signal: int, value: float) -> bool:
        """Take a sample of one signal; a step is judged once a sample of a later one comes.

        Args:
            time_us: µs since the epoch; of an earlier step than the newest: passed over.
            signal: its place among the signals; -1: it is the state.
            value: in the signal's unit; of several in a step the last one counts.

        Returns:
            False where it was passed over.

        """
        held, step = self.held, time_us // self.step_us
        if step < held.gathering:
            return False
        if step > held.gathering:
            if held.gathering != NEVER:
                self.see_row(held.gathering * self.step_us, held.gathered, self.state)
            held.begin_step(step)
        if signal >= 0:
            held.gathered[signal] = value
        elif 0.0 <= value < MOST_MODES:
            self.state = int(value)
        return True

    def see_row(
        self, time_us: int, values: Sequence[float] | Floats, state: int = _UNKNOWN
    ) -> float:
        """Take a value of each signal, NaN where there is none, and judge them.

        Args:
            time_us: µs since the epoch; not newer than the row before: passed over.
            values: one for each signal, in its unit.
            state: the machine's mode; nothing is judged where it is not known.

        Returns:
            The score, 0 to 1, of the newest row that is judged.

        """
        if self._is_plain():
            self.heard += 1
            return self.members[0].see_row(time_us, values)
        newest_us = self.held.newest_us
        if time_us <= newest_us:
            return self.score
        steps = 1
        if newest_us != NEVER and self.step_us:
            steps = max(1, round((time_us - newest_us) / self.step_us))
        row = self.held.hold_row(time_us, steps, np.array(values, dtype=np.float64))
        self.heard += 1
        if self.heard == self.learn_rows:
            self.held.learn_holds(self.heard, np.zeros(len(self.signals), bool))
        if self.by_state:
            return self._judge_settled(time_us, row, state)
        if not self.middles.size:
            self._gather_row(time_us, row)
        elif self.counted:
            # Rows of before come first: what is live meanwhile is not looked at.
            self.pass_rows_on()
        elif self._has_one_mode():
            self.mode = 0
            self.members[0].see_row(time_us, row)
        else:
            return self._judge_settled(time_us, row, self._mode_of(row))
        return self.score

    def see_rows(
        self, times: NDArray[np.int64], rows: Floats, states: Sequence[int]
    ) -> tuple[list[float], list[float]]:
        """Take rows (n, signals) in their order as `see_row` does one by one, faster.

        Returns:
            The score after each, and the squared distance in limits that it stands on; 0: none.

        """
        # Modes that were found are told of all rows at once, if nothing has to be held.
        found = bool(self.middles.size) and not self.counted and bool(np.isfinite(rows).all())
        modes: list[int] = []
        if found and len(rows):
            self.held.hold_row(int(times[-1]), len(rows), rows[-1])
            self.held.came += len(rows) - 1
            self.heard += len(rows)
            rows = bounded_values(rows)
            modes = self._modes_of(rows).tolist()
        scores, distances = [], []
        for at, time_us in enumerate(times.tolist()):
            if not found:
                self.see_row(time_us, rows[at], states[at])
            elif self._has_one_mode():
                self.mode = 0
                self.members[0].see_row(time_us, rows[at])
            else:
                self._judge_settled(time_us, rows[at], modes[at])
            score, current = self.score, self.current
            scores.append(score)
            distances.append(current.distance if current is not None and score > 0.0 else 0.0)
        return scores, distances

    def _judge_settled(self, time_us: int, row: Floats, mode: int) -> float:
        """Judge the row of some rows ago, if the machine is in the mode of then still."""
        if mode != self.mode:
            self.mode, self.settled = mode, 0
            self.waiting.clear()
            if mode in self.members:
                self.members[mode].resume()
        self.settled += 1
        if mode == _UNKNOWN or self.settled <= _SETTLING:
            return self.score
        self.waiting.append((time_us, row))
        if len(self.waiting) > _SETTLING:
            if mode not in self.members:
                self.members[mode] = self._new_member(self.learn_rows)
            self.members[mode].see_row(*self.waiting.pop(0))
        return self.score

    # ── modes that are found ────────────────────────────────────────────────────────────────

    def _gather_row(self, time_us: int, row: Floats) -> None:
        count = len(self.signals)
        self.rows[self.counted * count : (self.counted + 1) * count] = row
        self.times[self.counted] = time_us
        self.counted += 1
        if self.counted == self.learn_rows:
            self._find_modes()

    def _find_modes(self) -> None:
        rows = self.rows.reshape(self.learn_rows, len(self.signals))
        if not self.step_us:
            self.step_us = max(1, int(np.median(np.diff(self.times))))
        self.center, self.scale = scale_levels(rows)
        levels = self._levels_of(rows)
        middles = find_modes(levels, self.most_modes, FEWEST_LEARNED)
        self.middles = middles.ravel()
        self.widths = mode_widths(levels, assign_modes(levels, middles), len(middles)).ravel()
        counts = np.bincount(self._modes_of(rows), minlength=len(middles))
        self.members = {at: self._new_member(int(count)) for at, count in enumerate(counts)}

    def _levels_of(self, rows: Floats) -> Floats:
        levels = (rows - self.center) / self.scale
        # A value that is not there lies in the middle of all.
        levels[np.isnan(levels)] = 0.0
        return levels

    def _modes_of(self, rows: Floats) -> NDArray[np.intp]:
        """Give the number of the mode of each row (rows, signals)."""
        middles, widths = (
            one.reshape(-1, len(self.signals)) for one in (self.middles, self.widths)
        )
        return likeliest_modes(self._levels_of(rows), middles, widths)

    def _mode_of(self, row: Floats) -> int:
        return int(self._modes_of(row[np.newaxis])[0])

    # ── what is said ────────────────────────────────────────────────────────────────────────

    @property
    def current(self) -> GroupDetector | None:
        """What judges now; None while the mode is not known or new."""
        return self.members.get(self.mode)

    @property
    def score(self) -> float:
        """The newest row's, 0 to 1; 0 while the mode is new or has just changed."""
        settling = self.settled <= _SETTLING and not self._has_one_mode()
        return 0.0 if self.current is None or settling else self.current.score

    @property
    def learning(self) -> int:
        """So many rows until it has learned of the mode that it is in; 0: it judges."""
        if self.current is not None:
            return self.current.learning
        if self.middles.size and self.counted:
            # So many rows pass until the modes have what they were found in.
            return -(-(self.counted - self.passed) // _PASSED_ON)
        return self.learn_rows - self.counted

    @property
    def anomalous(self) -> bool:
        """An anomaly is on."""
        return self.score > 0.0 and self.current is not None and self.current.anomalous

    def list_shares(self) -> list[SignalShare]:
        """List all signals with their shares of the newest distance; see `GroupDetector`."""
        return [] if self.current is None else self.current.list_shares()

    def why(self) -> str:
        """Say in words what the newest score stands on, and which signals made it so."""
        if self.current is None:
            return f"it learns for {self.learning} more rows"
        return self.current.why()

    def forgive(self) -> bool:
        """Learn that the newest peak was usual in the mode that it is in."""
        return self.current is not None and self.current.forgive()

    def rename_signals(self, names: Sequence[str]) -> None:
        """Call the signals otherwise from now on."""
        self.signals = list(names)
        for member in self.members.values():
            member.signals = list(names)

    # ── learning from a stretch that is all there ───────────────────────────────────────────

    def expect_states(self, states: Sequence[int]) -> None:
        """Get ready to learn from rows that are all there, in these states, row by row.

        States of which there are too few rows are learned as they come.
        """
        counts: dict[int, int] = {}
        before, stayed = _UNKNOWN, 0
        for state in states:
            stayed = stayed + 1 if state == before else 1
            before = state
            # As `_judge_settled`: some rows after a change and some before the next are left out.
            if state != _UNKNOWN and stayed > 2 * _SETTLING:
                counts[state] = counts.get(state, 0) + 1
        for state, count in counts.items():
            if count >= FEWEST_LEARNED:
                self.members[state] = self._new_member(count)

    def pass_rows_on(self, many: int = _PASSED_ON) -> bool:
        """Let modes that were found learn from so many of the rows they were found in.

        Returns:
            False once there is nothing more to pass on.

        """
        if not self.middles.size or not self.counted:
            return False
        count = len(self.signals)
        until = min(self.counted, self.passed + many)
        for at in range(self.passed, until):
            row = self.rows[at * count : (at + 1) * count].copy()
            member = self.members[self._mode_of(row)]
            # One that has learned already judges nothing of before.
            if member.learning:
                member.see_row(int(self.times[at]), row)
        self.passed = until
        if until == self.counted:
            self.rows, self.times, self.counted = np.empty(0), np.empty(0), 0
        return self.counted > 0
