"""What a block has in it, or before it, beside exposures: the mount's turn at the meridian, focus.

The executor does both between two frames (`talaia.gateway.night.block_run`); here they are counted
by the same rules. How long a block takes so depends on when it begins, and on what was focused on
before it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.observing.plan import PauseKind, PlannedPause
from talaia.planner.between.overheads import overheads_from

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.planner.night_problem import Ints, NightProblem
    from talaia.planner.progress import NightProgress
    from talaia.planner.sky import Floats

__all__ = ["UNFOCUSED", "BlockPauses", "FocusState", "leads_from", "planned_pauses"]

_TURN = 2.0 * math.pi
_SIDEREAL_DAY_S = 86_164.1
# No filter has this index; -1 is one that is not named.
_NO_FILTER = -2
_LONG_AGO = -(1 << 28)


class FocusState(NamedTuple):
    """The last focus run: through which filter (an index), and when (s of the night)."""

    filter: int
    second: int


UNFOCUSED = FocusState(_NO_FILTER, _LONG_AGO)


class BlockPauses:
    """Reckons the pauses of some visits; all arguments are broadcast against each other.

    Attributes:
        none: there is nothing to reckon: no mount turns over and nobody focuses.

    """

    def __init__(self, problem: NightProblem, rows: Ints) -> None:
        """Take the visits; ``index`` below counts in ``rows``."""
        rules = self._rules = problem.pauses
        self.none = rules.flip <= 0.0 and rules.focus <= 0.0
        if self.none:
            return
        table, sky = problem.table, problem.sky
        self._readout = problem.instrument.readout
        self.first, self.last = table.filter_first[rows], table.filter_last[rows]
        self._blocks = table.block_s[rows]
        # What stands while the sky goes by is neither focused on nor followed over the meridian.
        self._tracked = table.tracked[rows]
        self._frame = table.frame_s[rows]
        # When each passes the meridian (s of the night); a long night has it twice.
        directions = sky.star_directions(table.ra[rows], table.dec[rows])
        # Of date, as sidereal time is.
        right = np.arctan2(directions[:, 1], directions[:, 0])
        angle = (right - float(sky.sidereal[0]) + math.pi) % _TURN - math.pi
        transit = angle / _TURN * _SIDEREAL_DAY_S
        self._transit = np.where(transit + self._blocks < 0.0, transit + _SIDEREAL_DAY_S, transit)

    def focus_due(
        self, index: Ints, begin: Ints, filters: Ints, focused: Ints
    ) -> NDArray[np.bool_]:
        """Tell whether a run comes before a block that could begin at a second.

        Args:
            index: of the visits.
            begin: when the first frame could be taken (s of the night).
            filters: through which the last run was.
            focused: when that was (s of the night).

        """
        if self._rules.focus <= 0.0:
            return np.zeros(np.broadcast_shapes(index.shape, begin.shape), np.bool_)
        due = (self.first[index] != filters) | (begin - focused >= self._rules.focus_every)
        return np.asarray(due & self._tracked[index])

    def inner_runs(self, index: Ints, start: Ints, focused: Ints) -> Ints:
        """Give how many focus runs come between the frames of a block, for the time alone."""
        rules = self._rules
        if rules.focus <= 0.0:
            return np.zeros(np.broadcast_shapes(index.shape, start.shape), np.int64)
        # A run just behind the last frame is that of the next block.
        since = np.maximum(start - focused, 0) + self._blocks[index] - 1
        count = np.floor(since / max(rules.focus_every, rules.focus, 1.0)).astype(np.int64)
        return np.where(self._tracked[index], count, 0)

    def flip_at(self, index: Ints, start: Ints) -> tuple[Floats, Floats]:
        """Give when the mount's turn begins in a block, and how long frames pause for it (s).

        A frame that would end too far beyond the meridian is not begun: the mount waits for the
        meridian, and turns. NaN and 0 where it does not turn.
        """
        rules = self._rules
        transit, frame = self._transit[index], self._frame[index]
        # Behind this a frame may no longer end: the mount would run into its pier.
        limit = transit + rules.flip_after
        # A last frame that ends before it needs no turn, whatever its readout takes.
        last = start + self._blocks[index] - self._readout
        turns = (start < transit) & (last > limit) & self._tracked[index] & (rules.flip > 0.0)
        # How many whole frames end by then; none, where already the first would end too late.
        exposure = np.maximum(frame - self._readout, 0.0)
        frames = np.floor((limit - start - exposure) / np.maximum(frame, 1.0)) + 1.0
        begin = start + np.maximum(frames, 0.0) * frame
        # East of the meridian a mount that is sent to the same place does not turn.
        waits = np.maximum(transit - begin, 0.0)
        return np.where(turns, begin, np.nan), np.where(turns, waits + rules.flip, 0.0)

    def block_seconds(self, index: Ints, start: Ints, focused: Ints) -> Ints:
        """Give what pauses make of blocks that begin at a second: so much longer (s)."""
        _, flip = self.flip_at(index, start)
        focus = self.inner_runs(index, start, focused) * self._rules.focus
        return np.asarray(np.ceil(flip + focus).astype(np.int64))

    def focused_after(self, index: Ints, start: Ints, finish: Ints, focused: Ints) -> Ints:
        """Give when the last focus run will have been, behind a block."""
        count = self.inner_runs(index, start, focused)
        # Without a run in the block this is the former one.
        within = focused + count * (self._rules.focus_every + self._rules.focus)
        return np.asarray(np.minimum(within, finish).astype(np.int64))

    @property
    def focus_s(self) -> int:
        """How long a focus run takes (s)."""
        return 0 if self.none else math.ceil(self._rules.focus)


def leads_from(progress: NightProgress, second: int, rows: Ints) -> Ints:
    """Give what leads from now to the first frame of each visit, a focus run among it (s)."""
    lead = overheads_from(progress.problem, progress.pointing, rows, second)
    pauses = BlockPauses(progress.problem, rows)
    if pauses.none:
        return lead
    filters, focused = progress.focus
    due = pauses.focus_due(
        np.arange(len(rows)), second + lead, np.array(filters), np.array(focused)
    )
    return np.asarray(lead + pauses.focus_s * due)


def planned_pauses(
    progress: NightProgress, row: int, start: int, focus: FocusState
) -> tuple[tuple[PlannedPause, ...], FocusState, int]:
    """Give the pauses before and in a planned block, with reasons.

    Args:
        progress: of the night.
        row: of the visit.
        start: of its first frame (s of the night).
        focus: how it was focused before.

    Returns:
        The pauses, how it is focused behind the block, and how long the run before it took (s).

    """
    problem = progress.problem
    pauses = BlockPauses(problem, np.array([row]))
    if pauses.none:
        return (), focus, 0
    only = np.array([0])
    rules = problem.pauses
    # A run that was due when the block was timed ends as its first frame begins.
    begin = np.array([start - pauses.focus_s])
    due = bool(pauses.focus_due(only, begin, np.array(focus.filter), np.array(focus.second))[0])
    found: list[PlannedPause] = []

    def add(kind: PauseKind, at: float, seconds: float, reason: str) -> None:
        unix = problem.unix(at)
        found.append(PlannedPause(kind=kind, start=unix, end=unix + seconds, reason=reason))

    since = focus.second
    if due:
        add(PauseKind.FOCUS, float(begin[0]), rules.focus, _focus_reason(progress, row, focus))
        since = start
    at = np.array([start])
    for number in range(1, 1 + int(pauses.inner_runs(only, at, np.array([since]))[0])):
        when = since + number * rules.focus_every + (number - 1) * rules.focus
        add(PauseKind.FOCUS, max(when, start), rules.focus, progress.focus_again)
    turn, seconds = pauses.flip_at(only, at)
    if seconds[0] > 0.0:
        add(PauseKind.FLIP, float(turn[0]), float(seconds[0]), "its target passes the meridian")
    found.sort(key=lambda pause: pause.start)
    # Runs in the block belong to its end, whatever the turn adds.
    end = np.array([start + int(problem.table.block_s[row])])
    after = int(pauses.focused_after(only, at, end, np.array([since]))[0])
    changed = due or int(pauses.last[0]) != int(pauses.first[0])
    last = int(pauses.last[0]) if changed else focus.filter
    return tuple(found), FocusState(last, after), pauses.focus_s if due else 0


def _focus_reason(progress: NightProgress, row: int, focus: FocusState) -> str:
    problem = progress.problem
    wanted = int(problem.table.filter_first[row])
    if focus.filter == _NO_FILTER:
        return "not focused yet in this night"
    if wanted != focus.filter:
        name = problem.filters[wanted] if wanted >= 0 else ""
        return f"another filter: {name}" if name else "another filter"
    return progress.focus_again
