"""How the planner's process answers. Pure; imported in that process alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.night.planning.planner_question import PlannerAnswer
from talaia.model.observing.states import RequestState
from talaia.planner.from_requests import make_night
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.night.planning.planner_question import PlannerQuestion, PlannerSetup
    from talaia.model.observing.requests import RequestGroup

__all__ = ["PlannerAnswers"]


class PlannerAnswers:
    """Answers questions with a `PlanningSession`, made anew for each night and each set."""

    def __init__(self) -> None:
        """Know nothing yet."""
        self._setup: PlannerSetup | None = None
        self._session: PlanningSession | None = None
        self._ends = 0.0
        # What the session knows to be done, held and ended.
        self._done: dict[str, tuple[int, ...]] = {}
        self._held: dict[str, float] = {}
        self._ended: set[str] = set()

    def take_setup(self, setup: PlannerSetup) -> None:
        """Plan this from here on."""
        self._setup, self._session = setup, None

    def answer_question(self, question: PlannerQuestion) -> PlannerAnswer:
        """Give the next request, the plan, and why the others wait."""
        session = self._session_for(question)
        if session is None:
            return PlannerAnswer(number=question.number, reason="nothing has been asked")
        session.set_conditions(seeing=question.seeing, clouds=question.clouds)
        decision = session.decide(question.time)
        return PlannerAnswer(
            number=question.number,
            request=decision.request,
            wait_until=decision.wait_until,
            reason=decision.reason,
            plan=session.plan(question.time),
            why_not=tuple(session.why_not(question.time))[:10_000],
        )

    def _session_for(self, question: PlannerQuestion) -> PlanningSession | None:
        setup = self._setup
        if setup is None or not setup.groups:
            return None
        if self._session is None or question.time >= self._ends:
            return self._begin_session(setup, question)
        session = self._session
        for request in sorted(set(question.ended) - self._ended):
            if request in self._known(setup):
                session.complete_request(request)
            self._ended.add(request)
        for request, until in question.held.items():
            if until > question.time and self._held.get(request) != until:
                session.hold_request(request, question.time, until - question.time)
                self._held[request] = until
        changed = {
            request
            for request, frames in question.done.items()
            if self._done.get(request) != frames and request not in self._ended
        }
        # What was interrupted is another block than the one that was planned.
        return self._begin_session(setup, question) if changed else session

    def _begin_session(self, setup: PlannerSetup, question: PlannerQuestion) -> PlanningSession:
        self._done, self._held = dict(question.done), dict(question.held)
        self._ended = set(question.ended)
        place = TelescopePlace(setup.latitude, setup.longitude, setup.elevation)
        problem = make_night(
            place,
            question.time,
            instrument=setup.instrument,
            proposals=setup.proposals,
            groups=[self._group_now(group) for group in setup.groups],
        )
        session = self._session = PlanningSession(problem)
        self._ends = problem.unix(problem.length_s)
        for request, until in question.held.items():
            if until > question.time and request in self._known(setup):
                session.hold_request(request, question.time, until - question.time)
        return session

    def _group_now(self, group: RequestGroup) -> RequestGroup:
        def now(request_id: str, state: RequestState) -> RequestState:
            return RequestState.COMPLETED if request_id in self._ended else state

        requests = tuple(
            replace(
                request,
                state=now(request.id, request.state),
                frames_done=self._done.get(request.id, request.frames_done),
            )
            for request in group.requests
        )
        return replace(group, requests=requests)

    def _known(self, setup: PlannerSetup) -> frozenset[str]:
        return frozenset(_pending_ids(setup.groups))


def _pending_ids(groups: Iterable[RequestGroup]) -> Iterable[str]:
    for group in groups:
        for request in group.requests:
            if request.state is RequestState.PENDING:
                yield request.id
