"""Alarms: listed, acknowledged, assigned, put aside, made and tried out."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated

import msgspec
from fastapi import APIRouter, Query, Request

from talaia.hub.alarms.conditions import AlarmCondition
from talaia.hub.alarms.preview import Track, preview_alarm
from talaia.hub.alarms.state_machine import (
    Acknowledge,
    Assign,
    Comment,
    Event,
    NotNow,
    Shelve,
    Unshelve,
)
from talaia.hub.api.access import address_of, known_live_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.schemas.alarm_schemas import (
    ActAsk,
    AlarmDefinition,
    AlarmList,
    AlarmPast,
    AlarmPastList,
    AlarmShape,
    PreviewAsk,
    PreviewShape,
)
from talaia.hub.auth.permissions import ANY, Right, sees_device
from talaia.hub.store.alarms.alarm_states import MadeAlarm
from talaia.model.alarms.alarm import Alarm, AlarmKind
from talaia.model.checks.alarm_checks import Addresses, alarm_findings

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.live.alarms.alarm_state import LiveAlarm
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.ports import History
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.alarms.alarm_states import AlarmStore
    from talaia.hub.store.audit import Audit

__all__ = ["AlarmPages"]

# ``\Z``, since ``$`` would let a new line at the end pass.
_ID = re.compile(r"[a-z][a-z0-9_]{0,62}\Z")
# An alarm that nobody wants to hear for longer should be changed (µs).
_LONGEST_SHELF_US = 30 * 86_400 * 1_000_000
_WIDTH = 1500
# Each is judged all the time.
_MOST_MADE = 500


class AlarmPages:
    """The routes of alarms."""

    def __init__(
        self,
        *,
        alarms: AlarmEngine,
        store: AlarmStore,
        people: People,
        history: History,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Answer from ``alarms``; what has been is in ``store`` and ``history``."""
        self._alarms = alarms
        self._store = store
        self._people = people
        self._history = history
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/alarms"
        router.get(at)(self.overview)
        router.get(at + "/{alarm}/history")(self.past)
        router.post(at + "/{alarm}/act", status_code=204)(self.act)
        router.put(at + "/{alarm}", status_code=204)(self.define)
        router.delete(at + "/{alarm}", status_code=204)(self.remove)
        router.post("/api/sites/{site}/alarm-preview")(self.preview)
        return router

    async def overview(self, site: str, request: Request) -> AlarmList:
        """List the alarms that are open to you; how they stand is told over the socket."""
        grants = who_of(request).grants
        return AlarmList(
            may_manage=grants.has_right(Right.ADMIN, site),
            alarms=[
                AlarmShape(
                    alarm=live_alarm.about.alarm,
                    device=live_alarm.about.device,
                    definition=_alarm_schema(live_alarm.alarm),
                    made=live_alarm.made,
                    problem=live_alarm.problem,
                    may_use=grants.has_right(Right.USE, site, live_alarm.about.device or ANY),
                )
                for live_alarm in self._alarms.alarms_of(site)
                if live_alarm.alarm is not None
                and grants.has_right(Right.VIEW, site, live_alarm.about.device or ANY)
            ],
        )

    async def past(
        self,
        *,
        site: str,
        alarm: str,
        request: Request,
        limit: Annotated[int, Query(ge=1, le=500)] = 50,
        before: Annotated[int, Query(ge=0, le=2**53)] = 2**53,
    ) -> AlarmPastList:
        """List what has happened to an alarm, newest first."""
        self._find_alarm(request, site, alarm, Right.VIEW)
        found = await self._store.alarm_history(site, alarm, limit + 1, before)
        return AlarmPastList(
            more=len(found) > limit,
            past=[
                AlarmPast(
                    id=str(record.id),
                    what=record.happened.what.value,
                    episode=record.happened.episode,
                    time_us=record.happened.time_us,
                    who=record.happened.who,
                    message=record.happened.message,
                )
                for record in found[:limit]
            ],
        )

    async def act(self, site: str, alarm: str, asked: ActAsk, request: Request) -> None:
        """Acknowledge, assign, comment, shelve or unshelve an alarm."""
        found = self._find_alarm(request, site, alarm, Right.USE)
        event = await self._make_event(asked, who_of(request).name)
        try:
            await self._alarms.apply_action(found, event)
        except NotNow as error:
            raise ApiProblem(409, "not_now", str(error)) from error

    async def define(self, site: str, alarm: str, asked: AlarmDefinition, request: Request) -> None:
        """Make an alarm, or change one that was made here."""
        live = known_live_of(request)
        if not _ID.match(alarm):
            raise ApiProblem(
                422, "invalid", "the short name takes small letters, digits and _, 63 at most"
            )
        # Two of one name could not be told apart; the description is the one that counts.
        if alarm in live.description.alarms:
            raise ApiProblem(409, "described", "the site description has it; change it there")
        known = self._alarms.find_alarm(site, alarm)
        if (
            known is None
            and sum(live_alarm.made for live_alarm in self._alarms.alarms_of(site)) >= _MOST_MADE
        ):
            raise ApiProblem(409, "too_many", f"a site has at most {_MOST_MADE} alarms made here")
        definition = _read_alarm(asked)
        # The same rules as for an alarm in the description; the first thing that is wrong will do.
        finding = next(iter(alarm_findings(Addresses(live.description), "$", definition)), None)
        if finding is not None:
            raise ApiProblem(422, "invalid", str(finding).removeprefix("$."))
        text = msgspec.json.encode(definition).decode()
        who = who_of(request).name
        await self._alarms.define_alarm(live, MadeAlarm(site, alarm, text, who, self._now_us()))
        self._append_record(
            request, "alarm changed" if known else "alarm made", live, definition.name
        )

    async def remove(self, site: str, alarm: str, request: Request) -> None:
        """Remove an alarm that was made here."""
        live = known_live_of(request)
        known = self._alarms.find_alarm(site, alarm)
        if known is not None and not known.made:
            raise ApiProblem(409, "described", "the site description has it; remove it there")
        if not await self._alarms.forget_alarm(live, alarm):
            raise ApiProblem(404, "unknown", "there is no such alarm")
        self._append_record(request, "alarm removed", live, known.about.name if known else alarm)

    async def preview(self, site: str, asked: PreviewAsk, request: Request) -> PreviewShape:
        """Try an alarm on what has been."""
        described, alarm = (
            Addresses(known_live_of(request).description),
            _read_alarm(asked.definition),
        )
        finding = next(iter(alarm_findings(described, "$", alarm)), None)
        if finding is not None:
            where = finding.where.removeprefix("$").removeprefix(".")
            return PreviewShape(
                where=where, problem=f"{finding.problem}; {finding.remedy}".rstrip("; ")
            )
        if alarm.kind in {AlarmKind.ANOMALY, AlarmKind.DETECTION}:
            return PreviewShape(
                problem="what detectors say is not in the history of signals: no preview"
            )
        if alarm.kind in {AlarmKind.ENCLOSURE, AlarmKind.GATEWAY}:
            return PreviewShape(
                problem="enclosures and links are not in the history of signals: no preview"
            )
        condition = AlarmCondition(described, alarm)
        to_us = self._now_us()
        from_us = to_us - round(asked.hours * 3600 * 1e6)
        found = await self._history.read_series(
            site, condition.channels, from_us, to_us, width=_WIDTH
        )
        step = (to_us - from_us) // _WIDTH
        # A point of one pixel and the next one's lie at most two pixels apart.
        tracks = {
            series.address: Track(
                series.time_us, series.value, series.texts, 0 if series.exact else 2 * step
            )
            for series in found
        }
        said = preview_alarm(condition, tracks, from_us, to_us)
        return PreviewShape(
            from_us=from_us,
            to_us=to_us,
            count=said.times,
            unknown_us=said.unknown_us,
            spans=list(said.spans),
            signals=list(condition.channels),
        )

    async def _make_event(self, asked: ActAsk, who: str) -> Event:
        now = self._now_us()
        match asked.act:
            case "acknowledge":
                return Acknowledge(now, who, asked.text)
            case "comment":
                if not asked.text:
                    raise ApiProblem(422, "invalid", "the comment is empty")
                return Comment(now, who, asked.text)
            case "assign":
                # Nobody: it is taken from whom it was assigned to.
                if asked.to and await self._people.find_by_name(asked.to) is None:
                    raise ApiProblem(422, "invalid", f"there is nobody called {asked.to!r}")
                return Assign(now, who, asked.to)
            case "shelve":
                if asked.until_us > now + _LONGEST_SHELF_US:
                    raise ApiProblem(422, "invalid", "an alarm is shelved for 30 days at most")
                return Shelve(now, who, asked.until_us, asked.text)
            case "unshelve":
                return Unshelve(now, who)

    def _find_alarm(self, request: Request, site: str, alarm: str, right: Right) -> LiveAlarm:
        """Find an alarm that somebody has a right on.

        Raises:
            ApiProblem: 404 there is none, or they may not know of its device; 403 they may know of
                it, and no more.

        """
        grants = who_of(request).grants
        found = self._alarms.find_alarm(site, alarm)
        # An alarm of no device is about the whole site.
        device = (found.about.device or ANY) if found else ANY
        described = known_live_of(request).description
        if found is not None and grants.has_right(right, site, device):
            return found
        if found is None or not (
            grants.has_right(Right.VIEW, site, device)
            or sees_device(grants, described, found.about.device)
        ):
            raise ApiProblem(404, "unknown", "there is no such alarm")
        raise ApiProblem(403, "forbidden", "you do not have the right to do this")

    def _append_record(self, request: Request, kind: str, live: LiveSite, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, site=live.name, message=message)

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


def _read_alarm(asked: AlarmDefinition) -> Alarm:
    said = asked.model_dump(mode="json")
    # The description's own word is a keyword of Python.
    said["is"] = said.pop("is_one_of")
    return msgspec.convert(said, Alarm)


def _alarm_schema(alarm: Alarm) -> AlarmDefinition:
    said = msgspec.to_builtins(alarm)
    if "is" in said:
        said["is_one_of"] = said.pop("is")
    return AlarmDefinition(**said)
