"""One night's planning, from the evening to the morning: what happened in, what is next out.

Long, because all events of a night meet here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.observing.plan import Plan, PlannedBlock, WhyNot
from talaia.planner.beam_search import OrderedVisit
from talaia.planner.between.overheads import overheads_from
from talaia.planner.between.pauses import UNFOCUSED, FocusState, leads_from, planned_pauses
from talaia.planner.bound import RestBound
from talaia.planner.dispatch import rank_now, soonest_start
from talaia.planner.errors import UnknownRequest
from talaia.planner.fairness import INDIFFERENT, FairnessRule
from talaia.planner.feasibility import NEVER
from talaia.planner.from_requests import limits_of, visits_of
from talaia.planner.idle_rounds import IdleRounds
from talaia.planner.night_problem import RAPID
from talaia.planner.outlook import WeatherOutlook
from talaia.planner.progress import NightProgress
from talaia.planner.search import PROMPT, THOROUGH, Effort, NightSearch
from talaia.planner.sky import MARK_S
from talaia.planner.why_not import clock_words, explain_visits

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence, Set

    from talaia.model.observing.requests import Proposal, RequestGroup
    from talaia.planner.night_problem import NightProblem, ParkPlace, Visit
    from talaia.planner.prices import TimePrices

__all__ = ["Decision", "PlanningSession"]

# After something went wrong a visit is not tried again at once (s).
_HOLD_S = 120
# Rather than to stand idle at a field for longer, wait where something new may come first (s).
_LONGEST_IDLE_S = 30
_USUAL_OUTLOOK = WeatherOutlook()


class Decision(NamedTuple):
    """What to do next (times: s since the epoch, UTC).

    Attributes:
        request: to observe now; empty: wait.
        not_before: its first exposure; set out so that it can begin then.
        wait_until: ask again then, or at the next event.
        reason: in words.

    """

    request: str
    not_before: float
    wait_until: float
    reason: str


class PlanningSession:
    """Plans one night. Times are seconds since the epoch (UTC); nothing here knows a clock.

    Events are handed over as they happen; `decide` then says what is next.
    """

    def __init__(
        self,
        problem: NightProblem,
        *,
        outlook: WeatherOutlook = _USUAL_OUTLOOK,
        fairness: FairnessRule = INDIFFERENT,
        effort: Effort = PROMPT,
    ) -> None:
        """Begin a night: the roof counts as open, the telescope as parked."""
        # What is done, what points where and whether the roof is open: shared with what follows.
        self._progress = NightProgress(problem)
        self._problem = problem
        # Keeps its best plan from one question to the next, and begins with it.
        self._search = NightSearch(self._progress, outlook, fairness)
        # How much a decision may search; `improve` has its own measure.
        self._effort = effort
        # Solved when a plan is first asked for, not with each decision.
        self._bound = RestBound(self._progress)
        # Whether something has happened since the last search.
        self._changed = True
        self._idle = IdleRounds(self._progress, self._search)

    def begin_from(self, former: PlanningSession) -> None:
        """Take the order of another session's plan for a beginning."""
        names = [former._problem.table.visits[step.row].id for step in former._search.plan]
        index = self._problem.table.index
        self._search.plan_first([index[name] for name in names if name in index])

    def add_requests(self, groups: Sequence[RequestGroup]) -> None:
        """Take in requests that are new, or again those that are pending."""
        self.add_visits(visits_of(self._problem, groups))

    def add_visits(self, visits: tuple[Visit, ...]) -> None:
        """Take in visits that are new."""
        self._changed = True
        self._progress.add_visits(visits)

    def remove_requests(self, requests: Sequence[str]) -> None:
        """Plan these no more: cancelled, expired or failed too often."""
        self._changed = True
        for request in requests:
            self._progress.done[self._row(request)] = True

    def complete_request(self, request: str) -> None:
        """Count a request as observed; the telescope points at it."""
        self._changed = True
        self._progress.complete_visit(self._row(request))

    def suspend_request(
        self,
        request: str,
        frames_done: tuple[int, ...] | None = None,
        *,
        seconds_left: int | None = None,
    ) -> None:
        """Count a request as interrupted: what was read out is kept, the rest is planned again.

        Args:
            request: its id.
            frames_done: of each configuration, since the problem was made.
            seconds_left: of its block, where that is known instead.

        """
        self._changed = True
        row = self._row(request)
        if seconds_left is not None:
            self._progress.shorten_visit(row, seconds_left)
        elif frames_done is not None:
            self._progress.keep_frames(row, frames_done)
        # The telescope still points there: going on at once costs no slew.
        self._progress.pointing = self._progress.pointing_at(row)

    def hold_request(self, request: str, time: float, seconds: float = _HOLD_S) -> None:
        """Leave a request out for a while: it was refused, or it failed."""
        self._changed = True
        self._progress.held_until[self._row(request)] = self._problem.second(time + seconds)

    def close_roof(self, why: str = "") -> None:
        """Plan nothing that needs the sky until `open_roof`; the telescope parks."""
        self._changed = True
        self._progress.open, self._progress.closed_why = False, why
        self._progress.pointing = None

    def park_telescope(self, place: ParkPlace | None = None) -> None:
        """Count the telescope as parked; ``place``: where it points, if that is known."""
        self._changed |= self._progress.pointing is not None
        self._progress.pointing = None
        # A reading trembles, and one that is missing for a moment says nothing else.
        before = self._problem.park
        if place is not None and (before is None or before.is_far_from(place)):
            self._changed, self._problem.park = True, place

    def open_roof(self) -> None:
        """Plan with an open roof again; the telescope is parked still."""
        self._changed = True
        self._progress.open, self._progress.closed_why = True, ""
        self._progress.pointing = None

    def set_conditions(
        self, *, seeing: float | None, clouds: float | None, unread: Set[str] = frozenset()
    ) -> None:
        """Keep what was measured last: FWHM (″) and clouds (%); none: nobody knows.

        What is ``unread`` (``seeing``, ``clouds``) should be measured and says nothing: what is
        held to a limit of it waits.
        """
        self._changed |= self._progress.set_conditions(seeing=seeing, clouds=clouds, unread=unread)

    def set_focus(
        self, *, filter_name: str, time: float | None, every: float | None, again: str = ""
    ) -> None:
        """Take when a focus run was last, through which filter, and when the next one is due.

        Args:
            filter_name: empty: one without a name.
            time: s since the epoch (UTC); none: there was none in this night.
            every: so long after the last one (s), as the tube cools just now; none: as ever.
            again: why then, in words.

        """
        focus = UNFOCUSED
        if time is not None:
            index = self._problem.filter_index(filter_name)
            focus = FocusState(index, self._problem.second(time))
        self._changed |= self._progress.set_focus(focus, every=every, again=again)

    def set_proposals(self, proposals: Sequence[Proposal]) -> None:
        """Take what proposals are due and have left now; one that is not named has nothing."""
        self._changed |= self._progress.set_limits(limits_of(proposals))

    def decide(self, time: float) -> Decision:
        """Say what to do next, and why."""
        second = self._problem.second(time)
        end = self._problem.unix(self._problem.length_s)
        self._idle.note_decision(second, changed=self._changed)
        if not self._progress.open:
            return Decision("", time, end, f"the roof is closed: {self._progress.closed_why}")
        # Before any search: seconds count, and nothing else may come first.
        rapid = self._rapid_choice(second)
        if rapid is not None:
            return rapid
        # A plan stands until something happens, or one that is worth more is found.
        plan = self._search.search(second, self._effort, steady=not self._changed)
        self._changed = False
        if not plan:
            start = soonest_start(self._progress, second)
            # Asked again a mark later at the soonest: constraints are known for whole marks.
            until = end if start >= NEVER else self._problem.unix(max(start, second + MARK_S))
            return Decision("", time, until, "nothing may be observed now")
        first = plan[0]
        lead = int(leads_from(self._progress, second, np.array([first.row]))[0])
        name = self._problem.table.visits[first.row].id
        # Set out only when it may begin: meanwhile something better may come.
        if first.start - lead > second + _LONGEST_IDLE_S:
            until = self._problem.unix(first.start - lead)
            return Decision("", time, until, f"{name} is next, and may not begin yet")
        self._idle.note_visit(first)
        reason = self._reason(first, second)
        if len(plan) > 1:
            follower = self._problem.table.visits[plan[1].row].id
            reason += f"; {follower} follows at {clock_words(self._problem.unix(plan[1].start))}"
        return Decision(name, self._problem.unix(first.start), time, reason)

    def _reason(self, step: OrderedVisit, since: int) -> str:
        """Say what a visit is worth beside the time that it takes from a second on."""
        minutes = max(step.end - since, 1) / 60.0
        rate = float(self._problem.table.value[step.row]) / minutes
        price = self._search.price_of(since, step.end)
        words = f"worth {rate:.1f} a minute, where the night's time costs {price:.1f}"
        limit = self._problem.table.visits[step.row].max_seeing
        if self._progress.seeing is None and limit < math.inf:
            # Told, for it may end as soon as it is measured.
            words += f"; whether the seeing is within {limit:.1f}″ is seen in its field"
        return words

    def _rapid_choice(self, second: int) -> Decision | None:
        """Give the rapid request that can begin at once, if there is one."""
        rows = self._progress.released(self._progress.candidates(second))
        rows = rows[self._problem.table.urgency[rows] == RAPID]
        if not rows.size:
            return None
        start, rate, overhead = rank_now(self._progress, second, rows)
        # One that has to wait for its sky is planned as any other, or the telescope would idle.
        rate = np.where(start - second - overhead <= MARK_S, rate, -1.0)
        best = int(np.argmax(rate))
        if rate[best] <= 0.0:
            return None
        row, begin = int(rows[best]), int(start[best])
        name = self._problem.table.visits[row].id
        block = int(self._problem.table.block_s[row])
        self._idle.note_visit(OrderedVisit(row, begin, begin + block))
        unix = self._problem.unix
        return Decision(name, unix(begin), unix(second), "a rapid request")

    def improve(self, time: float) -> None:
        """Search the whole rest of the night, more widely than a decision has time for."""
        self._search.search(self._problem.second(time), THOROUGH)
        self._changed = False

    def improve_idle(self, stopped: Callable[[], bool]) -> bool:
        """Search once more, and more widely, what follows on the newest decision.

        Args:
            stopped: asked often; once it says so, the plan stays as it was.

        Returns:
            Whether another round may find more.

        """
        return self._idle.search_once(stopped)

    def interrupt(self, time: float, rapid: str, current: str) -> bool:
        """Tell whether a request that has just come interrupts the one that is observed."""
        row, under_way = self._row(rapid), self._row(current)
        urgency = self._problem.table.urgency
        # Of two rapid ones the first goes on: they would interrupt each other for ever.
        if urgency[row] != RAPID or urgency[under_way] == RAPID or not self._progress.open:
            return False
        second = self._problem.second(time)
        pointing = self._progress.pointing_at(under_way)
        lead = int(overheads_from(self._problem, pointing, np.array([row]), second)[0])
        if row not in self._progress.released(self._progress.candidates(second)):
            return False
        start = self._progress.feasibility.next_start(row, second + lead)
        return start <= second + lead + MARK_S

    def plan(self, time: float) -> Plan:
        """Give the plan of the rest of the night; searched anew where something has happened.

        With a closed roof it is what would be done if it opened now.
        """
        problem = self._problem
        second, table = problem.second(time), problem.table
        if self._changed or not self._search.plan:
            self.improve(time)
        blocks, before, pointing = [], second, self._progress.pointing
        focus = self._progress.focus
        for step in self._search.plan:
            # What was done since the search, or is over: the rest of its plan still holds.
            if self._progress.done[step.row] or step.end <= second:
                continue
            lead = overheads_from(problem, pointing, np.array([step.row]), second)[0]
            pauses, focus, run_s = planned_pauses(self._progress, step.row, step.start, focus)
            reason = self._reason(step, min(before, step.start))
            blocks.append(
                PlannedBlock(
                    request=table.visits[step.row].id,
                    start=problem.unix(step.start),
                    end=problem.unix(step.end),
                    overhead=float(lead) + run_s,
                    reason=reason,
                    pauses=pauses,
                )
            )
            before, pointing = step.end, self._progress.pointing_at(step.row)
        planned = [table.index[block.request] for block in blocks]
        return Plan(
            made_at=time,
            night_start=problem.start,
            night_end=problem.unix(problem.length_s),
            blocks=tuple(blocks),
            method=self._search.method,
            value=float(table.value[planned].sum()),
            bound=self._bound.value(second),
        )

    @property
    def time_prices(self) -> TimePrices | None:
        """What the night's time costs, as priced last; None: nothing could be planned."""
        return self._search.prices

    def why_not(self, time: float, requests: Sequence[str] = ()) -> tuple[WhyNot, ...]:
        """Say of requests (none named: of all that wait) why they are not observed now."""
        rows = [self._row(name) for name in requests] or [
            row for row, done in enumerate(self._progress.done) if not done
        ]
        second = self._problem.second(time)
        planned = {step.row: step.start for step in self._search.plan if step.end > second}
        return explain_visits(self._progress, second, rows, planned=planned)

    def _row(self, request: str) -> int:
        row = self._problem.table.index.get(request)
        if row is None:
            raise UnknownRequest(request)
        return row
