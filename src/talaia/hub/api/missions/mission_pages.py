"""Missions: listed, saved, begun, paused and ended, and as files."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated

import msgspec
from fastapi import APIRouter, Query, Request

from talaia.hub.api.access import address_of, live_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.missions.mission_schemas import (
    MissionAsk,
    MissionList,
    MissionReading,
    MissionRow,
    MissionRunList,
    MissionRunShape,
    MissionSaved,
    MissionScheduleShape,
    MissionShape,
    MissionStartAsk,
    MissionStepRow,
    MissionStepShape,
    MissionText,
    RunActAsk,
)
from talaia.hub.api.problems import ApiProblem
from talaia.hub.live.missions.mission_service import NotStarted
from talaia.hub.live.missions.start_check import start_problem
from talaia.hub.store.missions.mission_store import MOST_MISSIONS
from talaia.model.errors import DescriptionError
from talaia.model.missions.mission_checks import site_findings, with_units
from talaia.model.missions.mission_file import convert_mission, dump_mission, load_mission

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.missions.mission_service import MissionService
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.missions.mission_store import KeptMission, MissionStore, RunRecord
    from talaia.model.missions.mission import Mission

__all__ = ["MissionPages"]

_UNKNOWN = "there is no such mission"


class MissionPages:
    """The routes of missions."""

    def __init__(
        self, *, store: MissionStore, service: MissionService, audit: Audit, clock: Clock
    ) -> None:
        """Keep them in ``store``, run them by ``service``."""
        self._store = store
        self._service = service
        self._audit = audit
        self._clock = clock

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        at = "/api/sites/{site}/missions"
        router.get(at)(self.list_missions)
        router.post(at)(self.add_mission)
        router.post(at + "/reading")(self.read_text)
        router.put(at + "/{mission}", status_code=204)(self.change_mission)
        router.delete(at + "/{mission}", status_code=204)(self.remove_mission)
        router.get(at + "/{mission}/text")(self.write_text)
        router.post(at + "/{mission}/start")(self.start_mission)
        router.get("/api/sites/{site}/mission-runs")(self.list_runs)
        router.post("/api/sites/{site}/mission-runs/act", status_code=204)(self.act_on_run)
        return router

    async def list_missions(self, request: Request, site: str) -> MissionList:
        """List the missions of a site, and the run that goes on there."""
        live, who = live_of(request), who_of(request)
        now = self._clock.monotonic_ns()
        run = self._service.run_of(live.name)
        return MissionList(
            missions=[
                MissionRow(
                    id=str(kept.id),
                    mission=_shape_of(kept.mission),
                    owner=kept.owner,
                    due_us=kept.due_us,
                    changed_us=kept.changed_us,
                    problem=start_problem(live, kept.mission, who, now),
                )
                for kept in await self._store.list_missions(site)
            ],
            run=None if run is None else _run_shape(run),
        )

    async def add_mission(self, request: Request, site: str, ask: MissionAsk) -> MissionSaved:
        """Keep a new mission."""
        live = _by_a_person(request)
        mission = _mission_of(ask.mission, live)
        number = await self._store.add_mission(
            site, mission, who_of(request).user, self._service.due_us(live, mission)
        )
        if number is None:
            raise ApiProblem(409, "full", f"a site has at most {MOST_MISSIONS} missions")
        self._append_record(request, "mission saved", _words(mission, number))
        return MissionSaved(id=str(number))

    async def change_mission(
        self, request: Request, site: str, mission: str, ask: MissionAsk
    ) -> None:
        """Save another version; its schedule has your rights from now on."""
        live = _by_a_person(request)
        number = number_of(mission, "mission")
        changed = _mission_of(ask.mission, live)
        found = await self._store.change_mission(
            site,
            number,
            mission=changed,
            owner=who_of(request).user,
            due_us=self._service.due_us(live, changed),
        )
        if not found:
            raise ApiProblem(404, "unknown", _UNKNOWN)
        self._append_record(request, "mission saved", _words(changed, number))

    async def remove_mission(self, request: Request, site: str, mission: str) -> None:
        """Remove a mission; a run that goes on is not ended by it, and runs stay listed."""
        _by_a_person(request)
        kept = await self._find(site, mission)
        await self._store.remove_mission(site, kept.id)
        self._append_record(request, "mission removed", _words(kept.mission, kept.id))

    async def write_text(self, site: str, mission: str) -> MissionText:
        """Give a mission as the text of a file."""
        return MissionText(text=dump_mission((await self._find(site, mission)).mission))

    async def read_text(self, request: Request, site: str, ask: MissionText) -> MissionReading:
        """Read the text of a file; nothing is kept by it."""
        live = live_of(request)
        try:
            # In a thread: a large file takes its time.
            mission = await asyncio.to_thread(load_mission, ask.text)
        except DescriptionError as error:
            return MissionReading(
                mission=None, where=error.where, problem=error.problem, remedy=error.remedy
            )
        for where, problem, remedy in site_findings(mission, live.description):
            return MissionReading(mission=None, where=where, problem=problem, remedy=remedy)
        return MissionReading(mission=_shape_of(mission), where="", problem="", remedy="")

    async def start_mission(
        self, request: Request, site: str, mission: str, ask: MissionStartAsk
    ) -> MissionRunShape:
        """Begin a mission now, with your rights; 409 says why it is not begun."""
        live = _by_a_person(request)
        kept = await self._find(site, mission)
        who = who_of(request)
        if ask.first >= len(kept.mission.steps):
            raise ApiProblem(422, "invalid", f"it has {len(kept.mission.steps)} steps")
        try:
            run = await self._service.start(
                live, kept, user=who.user, begun_by=who.name, first=ask.first
            )
        except NotStarted as error:
            self._append_record(
                request, "mission not started", f"{kept.mission.name}: {error.why}", good=False
            )
            raise ApiProblem(409, "not_started", error.why) from error
        return _run_shape(run)

    async def list_runs(
        self, site: str, limit: Annotated[int, Query(ge=1, le=200)] = 50
    ) -> MissionRunList:
        """List the runs of a site, the newest first."""
        runs = await self._store.list_runs(site, limit)
        now = self._service.run_of(site)
        # The one that goes on as it is now, not as it was written down last.
        return MissionRunList(
            runs=[_run_shape(now if now is not None and now.id == one.id else one) for one in runs]
        )

    async def act_on_run(self, request: Request, site: str, ask: RunActAsk) -> None:
        """Pause, resume or cancel the run that goes on at a site."""
        live, who = live_of(request), who_of(request).name
        try:
            match ask.act:
                case "pause":
                    await self._service.pause(live, who)
                case "resume":
                    _by_a_person(request)
                    await self._service.resume(live, who)
                case "cancel":
                    self._service.cancel(live, who)
        except NotStarted as error:
            raise ApiProblem(409, "not_started", error.why) from error
        self._append_record(request, f"mission {ask.act} asked", "")

    async def _find(self, site: str, number: str) -> KeptMission:
        kept = await self._store.find_mission(site, number_of(number, "mission"))
        if kept is None:
            raise ApiProblem(404, "unknown", _UNKNOWN)
        return kept

    def _append_record(
        self, request: Request, kind: str, message: str, *, good: bool = True
    ) -> None:
        self._audit.append_record(
            kind,
            who=who_of(request).name,
            address=address_of(request),
            site=live_of(request).name,
            message=message,
            good=good,
        )


def _by_a_person(request: Request) -> LiveSite:
    """Refuse scripts: a run has all rights of its account, a token has only some of them.

    Raises:
        ApiProblem: 403, a token asks.

    """
    if who_of(request).script:
        raise ApiProblem(403, "forbidden", "a token may not do this; sign in yourself")
    return live_of(request)


def _mission_of(shape: MissionShape, live: LiveSite) -> Mission:
    """Make a mission of what was sent.

    Raises:
        ApiProblem: 422, it does not fit together, or not to the site.

    """
    try:
        mission = convert_mission(shape.model_dump(mode="json"))
    except DescriptionError as error:
        raise ApiProblem(422, "invalid", str(error)) from error
    for finding in site_findings(mission, live.description):
        raise ApiProblem(422, "invalid", str(finding))
    return with_units(mission, live.description)


def _words(mission: Mission, number: int) -> str:
    at = "" if mission.schedule is None else f", at {mission.schedule.at}"
    return f"{mission.name} ({number}), {len(mission.steps)} steps{at}"


def _shape_of(mission: Mission) -> MissionShape:
    schedule = mission.schedule
    return MissionShape(
        name=mission.name,
        note=mission.note,
        steps=[MissionStepShape(**msgspec.structs.asdict(step)) for step in mission.steps],
        schedule=None
        if schedule is None
        else MissionScheduleShape(at=schedule.at, days=list(schedule.days), date=schedule.date),
    )


def _run_shape(run: RunRecord) -> MissionRunShape:
    return MissionRunShape(
        id=str(run.id),
        mission=str(run.mission_id),
        name=run.name,
        who=run.who,
        begun_by=run.begun_by,
        state=run.state,
        why=run.why,
        began_us=run.began_us,
        ended_us=run.ended_us,
        steps=[
            MissionStepRow(
                name=step.name,
                state=step.state,
                message=step.message,
                began_us=step.began_us,
                ended_us=step.ended_us,
            )
            for step in run.steps
        ],
    )
