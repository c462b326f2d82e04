"""A night played against its judge: one JSON object in, one out."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from talaia.planner.errors import NotANight
from talaia.planner.fairness import INDIFFERENT, FairnessRule
from talaia.planner.night_file import (
    NightFile,
    NightRequest,
    make_problem,
    make_visits,
    what_is_wrong,
)
from talaia.planner.session import PlanningSession

__all__ = ["DrivenNight"]


# Of the night; beyond any that the format has, planning would have no end.
_Moment = Annotated[int, Meta(ge=-86_400, le=3 * 86_400)]


class _Event(msgspec.Struct, frozen=True, kw_only=True):
    type: Literal["arrived", "released", "aborted", "refused"]
    t: _Moment
    requests: list[NightRequest] = []
    request: str = ""
    block_s: Annotated[int, Meta(ge=0, le=2**31)] = 0


class _NightLine(msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="night"):
    night: NightFile


class _DecideLine(msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="decide"):
    t: _Moment
    events: list[_Event] = []
    completed: list[str] = []


class _InterruptLine(msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="interrupt"):
    t: _Moment
    events: list[_Event] = []
    request: str
    current: str


class DrivenNight:
    """Answers the lines of a judge, in order."""

    def __init__(self, fairness: FairnessRule = INDIFFERENT) -> None:
        """Wait for the line that brings the night."""
        self._fairness = fairness
        self._session: PlanningSession | None = None
        self._lines = msgspec.json.Decoder(_NightLine | _DecideLine | _InterruptLine)

    def answer_line(self, line: bytes) -> dict[str, object]:
        """Answer one line.

        Raises:
            NotANight: it is none of the three kinds, or comes before the night.
            UnknownRequest: it names a request that was never given.

        """
        try:
            asked = self._lines.decode(line)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            problem = what_is_wrong(line, error)
            raise NotANight("line", problem, "expected night, decide or interrupt") from error
        if isinstance(asked, _NightLine):
            self._problem = make_problem(asked.night)
            self._session = PlanningSession(self._problem, fairness=self._fairness)
            self._session.improve(self._problem.start)
            return {}
        if self._session is None:
            raise NotANight("line", "no night was given", "send a line of type night first")
        session, start = self._session, self._problem.start
        if isinstance(asked, _InterruptLine):
            self._apply_events(session, asked.events)
            answer = session.interrupt(start + asked.t, asked.request, asked.current)
            return {"interrupt": answer}
        # Before what came after it: a closing parks the telescope.
        for name in asked.completed:
            session.complete_request(name)
        self._apply_events(session, asked.events)
        decision = session.decide(start + asked.t)
        if decision.request:
            return {
                "observe": decision.request,
                "not_before": self._problem.second(decision.not_before),
                "reason": decision.reason,
            }
        return {"wait": self._problem.second(decision.wait_until), "reason": decision.reason}

    def _apply_events(self, session: PlanningSession, events: list[_Event]) -> None:
        for event in events:
            match event.type:
                case "arrived":
                    session.add_visits(make_visits(self._problem, event.requests))
                case "released":
                    session.open_roof()
                case "aborted":
                    session.suspend_request(event.request, seconds_left=event.block_s)
                case "refused":
                    session.hold_request(event.request, self._problem.unix(event.t))
