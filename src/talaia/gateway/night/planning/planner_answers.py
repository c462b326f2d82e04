"""How the planner's process answers. Pure; imported in that process alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from talaia.gateway.night.planning.planner_question import PlannerAnswer
from talaia.model.observing.states import RequestState
from talaia.planner.from_requests import make_night
from talaia.planner.night_problem import ParkPlace
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from talaia.gateway.night.planning.planner_question import (
        FocusNews,
        PlannerQuestion,
        PlannerSetup,
    )
    from talaia.model.observing.requests import Proposal, RequestGroup

__all__ = ["PlannerAnswers"]


class PlannerAnswers:
    """Answers questions with a `PlanningSession`, and improves its plan between them.

    One session lasts a night: what is asked, done and paid for changes in it. Where that cannot be
    (a request is another by the same name) a new one begins from the former one's plan.

    Attributes:
        sessions: so many were begun.

    """

    def __init__(self) -> None:
        """Know nothing yet."""
        self.sessions = 0
        self._setup: PlannerSetup | None = None
        self._session: PlanningSession | None = None
        # Whose plan the next one begins from.
        self._former: PlanningSession | None = None
        self._ends = 0.0
        # Requests that the session knows, without what changes; those that it planned once; and
        # the frames that there were of each when it was told.
        self._known: dict[str, RequestGroup] = {}
        self._gone: set[str] = set()
        self._base: dict[str, tuple[int, ...]] = {}
        # What the session knows to be done, held and ended.
        self._done: dict[str, tuple[int, ...]] = {}
        self._held: dict[str, float] = {}
        self._ended: set[str] = set()

    def take_setup(self, setup: PlannerSetup) -> None:
        """Plan this from here on."""
        before, self._setup = self._setup, setup
        if self._session is None or before is None:
            return
        same = replace(before, groups=setup.groups, proposals=setup.proposals)
        if same != setup or not self._follow_requests(self._session, setup):
            self._former, self._session = self._session, None

    def answer_question(self, question: PlannerQuestion) -> PlannerAnswer:
        """Give the next request, the plan, and why the others wait."""
        session = self._session_for(question)
        if session is None:
            return PlannerAnswer(number=question.number, reason="nothing has been asked")
        session.set_conditions(
            seeing=question.seeing, clouds=question.clouds, unread=question.unread
        )
        _tell_focus(session, question.focus)
        decision = session.decide(question.time)
        return PlannerAnswer(
            number=question.number,
            request=decision.request,
            wait_until=decision.wait_until,
            reason=decision.reason,
            plan=session.plan(question.time),
            why_not=tuple(session.why_not(question.time))[:10_000],
        )

    def improve_plan(self, stopped: Callable[[], bool]) -> bool:
        """Look for a better plan, until ``stopped`` says so; tells whether more may be found."""
        return self._session is not None and self._session.improve_idle(stopped)

    def _session_for(self, question: PlannerQuestion) -> PlanningSession | None:
        setup = self._setup
        if setup is None or not setup.groups:
            return None
        if self._session is None or question.time >= self._ends:
            return self._begin_session(setup, question)
        session = self._session
        for request in sorted(set(question.ended) - self._ended):
            if request in self._known:
                session.complete_request(request)
            self._ended.add(request)
        for request, until in question.held.items():
            if until > question.time and self._held.get(request) != until:
                self._held[request] = until
                if request in self._known:
                    session.hold_request(request, question.time, until - question.time)
        for request, frames in question.done.items():
            base = self._base.get(request)
            if base is None or request in self._ended or frames == self._done.get(request, base):
                continue
            self._done[request] = frames
            # What was interrupted is a shorter block than the one that was planned.
            padded = [*base, *([0] * (len(frames) - len(base)))]
            since = (now - then for now, then in zip(frames, padded, strict=False))
            session.suspend_request(request, tuple(max(0, count) for count in since))
        # Behind what is done now: what is left is told, not reckoned here.
        session.set_proposals(_proposals_now(setup, question))
        _tell_park(session, question)
        return session

    def _begin_session(self, setup: PlannerSetup, question: PlannerQuestion) -> PlanningSession:
        self._done, self._held = dict(question.done), dict(question.held)
        self._ended = set(question.ended)
        self._known, self._base, self._gone = {}, {}, set()
        place = TelescopePlace(setup.latitude, setup.longitude, setup.elevation)
        problem = make_night(
            place,
            question.time,
            instrument=setup.instrument,
            pauses=setup.pauses,
            proposals=_proposals_now(setup, question),
            groups=self._groups_now(setup),
        )
        session = PlanningSession(problem)
        self.sessions += 1
        if self._former is not None:
            session.begin_from(self._former)
            self._former = None
        self._session, self._ends = session, problem.unix(problem.length_s)
        self._note_known(setup)
        _tell_park(session, question)
        for request, until in question.held.items():
            if until > question.time and request in self._known:
                session.hold_request(request, question.time, until - question.time)
        return session

    def _follow_requests(self, session: PlanningSession, setup: PlannerSetup) -> bool:
        """Let the session go on with what is asked now; tells whether it can."""
        now = dict(_pending(setup.groups))
        # Another one by the same name, or one that was planned no more.
        if any(
            name in self._gone or self._known.get(name, one) != one for name, one in now.items()
        ):
            return False
        completed = {
            request.id
            for group in setup.groups
            for request in group.requests
            if request.state is RequestState.COMPLETED
        }
        for name in sorted(set(self._known) - set(now)):
            if name in completed:
                # Charged here as well; what the hub says of hours left comes behind it.
                session.complete_request(name)
            else:
                session.remove_requests([name])
            del self._known[name]
            self._gone.add(name)
        # Known ones are passed over: what is new has rows of its own.
        session.set_proposals(setup.proposals)
        session.add_requests(self._groups_now(setup))
        self._note_known(setup)
        return True

    def _note_known(self, setup: PlannerSetup) -> None:
        kept = {one.id: one.frames_done for group in setup.groups for one in group.requests}
        for name, lasting in _pending(setup.groups):
            if name not in self._known:
                self._known[name] = lasting
                self._base[name] = self._done.get(name, kept[name])

    def _groups_now(self, setup: PlannerSetup) -> list[RequestGroup]:
        return [self._group_now(group) for group in setup.groups]

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


def _tell_park(session: PlanningSession, question: PlannerQuestion) -> None:
    """Let the next block begin with unparking, where rain or the morning has ended the last one."""
    if question.parked:
        session.park_telescope(ParkPlace(*question.park) if question.park is not None else None)


def _tell_focus(session: PlanningSession, focus: FocusNews | None) -> None:
    if focus is None:
        session.set_focus(filter_name="", time=None, every=None)
    else:
        session.set_focus(
            filter_name=focus.filter, time=focus.at, every=focus.every, again=focus.again
        )


def _proposals_now(setup: PlannerSetup, question: PlannerQuestion) -> list[Proposal]:
    """Give who pays, with what the gateway has charged since the hub told the hours used."""
    return [
        replace(one, hours_used=one.hours_used + question.charged.get(one.id, 0.0) / 3600.0)
        for one in setup.proposals
    ]


def _pending(groups: Iterable[RequestGroup]) -> Iterable[tuple[str, RequestGroup]]:
    """Give the ids of what is to be planned, and all that does not change while it waits."""
    for group in groups:
        for request in group.requests:
            if request.state is RequestState.PENDING:
                lasting = replace(request, frames_done=(), failures=0)
                yield request.id, replace(group, requests=(lasting,))
