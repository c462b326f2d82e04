"""How a night stands: what is done, what it was charged, where the telescope points."""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from msgspec import structs

from talaia.planner.between.overheads import PARKED, TelescopePointing
from talaia.planner.between.pauses import UNFOCUSED, FocusState
from talaia.planner.feasibility import Feasibility
from talaia.planner.night_problem import NO_VISIT_BEFORE, ProposalLimit

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence, Set

    from numpy.typing import NDArray

    from talaia.planner.night_problem import Ints, NightProblem, Visit

__all__ = ["NightProgress"]

# By less the time to the next focus run is no other (s): a tube's thermometer trembles.
_FOCUS_PLAY_S = 300.0


class NightProgress:
    """The part of a night that changes while it goes on.

    Attributes:
        problem: what is asked.
        feasibility: when each visit may be observed.
        done: visits that need nothing more, ended ones among them.
        complete: of these, those that were observed.
        held_until: second from which a visit may be tried again.
        used_s: block time that each proposal was charged in this night.
        shutter_s: open shutter that each proposal got in this night.
        pointing: where the telescope points; none: parked.
        open: whether the roof is.
        closed_why: why it is not, in words.
        seeing: as measured last (″); none: nobody knows.
        clouds: as measured last (%); none: nobody knows.
        unread: of ``seeing`` and ``clouds``, what should be measured and says nothing.
        focus: the last focus run, as the planner was told.
        focus_again: why the next one comes, where the filter stays, in words.

    """

    def __init__(self, problem: NightProblem) -> None:
        """Begin a night with everything still to be done."""
        self.problem = problem
        self.feasibility = Feasibility(problem)
        count = len(problem.table)
        self.done: NDArray[np.bool_] = np.zeros(count, np.bool_)
        self.complete: NDArray[np.bool_] = np.zeros(count, np.bool_)
        self.held_until: Ints = np.zeros(count, np.int64)
        self.used_s = np.zeros(len(problem.proposals))
        self.shutter_s = np.zeros(len(problem.proposals))
        self.pointing: TelescopePointing | None = PARKED
        self.open = True
        self.closed_why = ""
        self.seeing: float | None = None
        self.clouds: float | None = None
        self.unread: Set[str] = frozenset()
        self.focus: FocusState = UNFOCUSED
        self.focus_again = "some time has passed since the last one"
        self._limits = self._visit_limits()

    def set_limits(self, limits: Sequence[ProposalLimit]) -> bool:
        """Take what proposals have left from now on; tells whether that is another than before."""
        named = {limit.id: limit for limit in limits}
        known = self.problem.proposals
        now: list[ProposalLimit] = []
        for limit in known:
            share, left = named.pop(limit.id, limit._replace(share=0.0, seconds_left=0.0))[1:]
            # What was charged since the beginning is taken off again.
            charged = float(self.used_s[len(now)])
            now.append(ProposalLimit(limit.id, share, left + charged))
        now += named.values()
        changed = len(now) > len(known) or any(
            one.share != other.share or abs(one.seconds_left - other.seconds_left) > 1.0
            for one, other in zip(now, known, strict=False)
        )
        self.problem.proposals[:] = now
        more = np.zeros(len(now) - len(self.used_s))
        self.used_s = np.concatenate([self.used_s, more])
        self.shutter_s = np.concatenate([self.shutter_s, more])
        return changed

    def add_visits(self, visits: tuple[Visit, ...]) -> list[int]:
        """Add visits; gives the rows of those that are new."""
        blocks = self.problem.table.block_s
        rows = self.problem.add_visits(visits)
        # A proposal may have come with them.
        more_limits = np.zeros(len(self.problem.proposals) - len(self.used_s))
        self.used_s = np.concatenate([self.used_s, more_limits])
        self.shutter_s = np.concatenate([self.shutter_s, more_limits])
        if rows:
            # What was shortened stays so.
            self.problem.table.block_s[: len(blocks)] = blocks
            self.feasibility.add_rows()
            more = len(rows)
            self.done = np.concatenate([self.done, np.zeros(more, np.bool_)])
            self.complete = np.concatenate([self.complete, np.zeros(more, np.bool_)])
            self.held_until = np.concatenate([self.held_until, np.zeros(more, np.int64)])
            self._limits = self._visit_limits()
        return rows

    def candidates(self, second: int) -> Ints:
        """Give the rows of visits that may still be observed under the open sky in this night."""
        table = self.problem.table
        rows = ~self.done & table.needs_sky & (table.block_s > 0)
        rows &= self.held_until <= second
        left = np.array([limit.seconds_left for limit in self.problem.proposals]) - self.used_s
        rows &= table.block_s <= left[table.proposal] + 1e-6
        return np.flatnonzero(rows & self._let_by_conditions())

    def released(self, rows: Ints) -> Ints:
        """Leave out those whose predecessor in a sequence is not complete."""
        return rows[self.are_released(rows)]

    def are_released(self, rows: Ints) -> NDArray[np.bool_]:
        """Tell of which visits no predecessor is missing; one that nobody knows always is."""
        before = self.problem.table.after[rows]
        complete = (before >= 0) & self.complete[np.maximum(before, 0)]
        return np.asarray(complete | (before == NO_VISIT_BEFORE), np.bool_)

    def pointing_at(self, row: int) -> TelescopePointing:
        """Give where the telescope points after a visit, and its filter."""
        table = self.problem.table
        last, angle = int(table.filter_last[row]), float(table.angle[row])
        # What it does not ask for stays as it was before it.
        if self.pointing is not None:
            last = self.pointing.filter if last < 0 else last
            angle = self.pointing.angle if math.isnan(angle) else angle
        return TelescopePointing(float(table.ra[row]), float(table.dec[row]), last, angle)

    def complete_visit(self, row: int) -> None:
        """Count a visit as observed, and charge it."""
        if self.done[row]:
            return
        table = self.problem.table
        self.done[row] = self.complete[row] = True
        self.used_s[table.proposal[row]] += table.block_s[row]
        self.shutter_s[table.proposal[row]] += table.shutter_s[row]
        if table.needs_sky[row]:
            self.pointing = self.pointing_at(row)

    @contextmanager
    def assume_observed(self, row: int) -> Iterator[None]:
        """Let it stand meanwhile as it will when a visit has been observed."""
        done, complete = bool(self.done[row]), bool(self.complete[row])
        used_s, shutter_s, pointing = self.used_s.copy(), self.shutter_s.copy(), self.pointing
        self.complete_visit(row)
        try:
            yield
        finally:
            self.done[row], self.complete[row] = done, complete
            self.used_s, self.shutter_s, self.pointing = used_s, shutter_s, pointing

    def set_conditions(
        self, *, seeing: float | None, clouds: float | None, unread: Set[str] = frozenset()
    ) -> bool:
        """Keep what was measured last; tells whether it lets other visits be observed."""
        before = self._let_by_conditions()
        self.seeing, self.clouds, self.unread = seeing, clouds, unread
        return not np.array_equal(before, self._let_by_conditions())

    def _let_by_conditions(self) -> NDArray[np.bool_]:
        seeing, clouds, failed = self._limits
        rows = ~failed
        for name, value, limit in (
            ("seeing", self.seeing, seeing),
            ("clouds", self.clouds, clouds),
        ):
            if value is not None:
                rows &= value <= limit
            elif name in self.unread:
                # A limit on what nobody knows is not passed in silence.
                rows &= np.isinf(limit)
        return rows

    def set_focus(self, focus: FocusState, *, every: float | None, again: str) -> bool:
        """Keep how it is focused; tells whether plans are others by it. See `PlanningSession`."""
        rules = self.problem.pauses
        changed = focus != self.focus
        if every is not None and abs(every - rules.focus_every) > _FOCUS_PLAY_S:
            self.problem.pauses = structs.replace(rules, focus_every=every)
            changed = True
        self.focus, self.focus_again = focus, again or self.focus_again
        return changed

    def shorten_visit(self, row: int, seconds_left: int) -> None:
        """Leave a visit only the block that it still needs (s)."""
        self.problem.table.block_s[row] = max(1, seconds_left)
        self.feasibility.update_block(row)

    def keep_frames(self, row: int, frames_done: tuple[int, ...]) -> None:
        """Leave a visit only the frames that are not done, by configuration."""
        visit = self.problem.table.visits[row]
        kept = [*frames_done, *([0] * (len(visit.runs) - len(frames_done)))]
        if all(done >= run.frames for run, done in zip(visit.runs, kept, strict=False)):
            # Nothing is left to be planned; that it is complete is said by `complete_visit`.
            self.problem.table.block_s[row] = 0
            return
        runs = tuple(
            run._replace(
                frames=max(0, run.frames - done), before_s=run.before_s * (run.frames > done)
            )
            for run, done in zip(visit.runs, kept, strict=False)
        )
        self.shorten_visit(row, replace(visit, runs=runs).block_s())

    def _visit_limits(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        visits = self.problem.table.visits
        return (
            np.array([visit.max_seeing for visit in visits]),
            np.array([visit.max_clouds for visit in visits]),
            np.array([visit.failures_reached for visit in visits], np.bool_),
        )
