"""Missions of all sites: begun by people or by their schedules, one at a time at each site.

Long, because all ways in which a run begins and ends meet here: people, schedules, the hub's end.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.errors import TalaiaError
from talaia.hub.errors import StoreDown
from talaia.hub.live.missions.mission_line import MissionLine
from talaia.hub.live.missions.mission_run import MissionRun, RunEnd, step_name
from talaia.hub.live.missions.start_check import start_problem
from talaia.hub.store.missions.mission_store import RunRecord, StepRecord
from talaia.model.missions.mission_schedule import next_due_us

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pages.page_service import PageService
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.accounts.mission_accounts import MissionAccounts
    from talaia.hub.store.missions.mission_store import KeptMission, MissionStore
    from talaia.model.missions.mission import Mission

__all__ = ["SCHEDULE", "MissionService", "NotStarted"]

_LOG = logging.getLogger(__name__)
# Stands where a person's name is, for runs that nobody pressed start for.
SCHEDULE = "schedule"
# The schedules are looked at so often (s).
_LOOK_S = 1.0
# A schedule that is later than this is missed: what was meant for then is not done now (µs).
_LATEST_US = 30_000_000
# Between two tries to write down how a run ended (s).
_RETRY_S = 2.0
_NO_ACCOUNT = "its account is disabled or gone"
# What people are told of, beside the logbook.
_BAD = frozenset({"failed", "interrupted", "missed"})


class NotStarted(TalaiaError):
    """A mission was not begun, or does not go on."""

    def __init__(self, why: str) -> None:
        """Say why, in words for people."""
        super().__init__(why)
        self.why = why


class _Going(NamedTuple):
    """A run that goes on, and the task that does it."""

    run: MissionRun
    mission: Mission
    user: int
    task: asyncio.Task[None]


class MissionService:
    """Starts, watches and ends runs."""

    def __init__(
        self,
        *,
        sites: Sites,
        store: MissionStore,
        accounts: MissionAccounts,
        service: PageService,
        reporting: RobotEvents,
        notify: Callable[[LiveSite, RunRecord], Awaitable[None]],
        clock: Clock,
    ) -> None:
        """Ask robots by ``service``, as pages do; ``notify`` tells people of what went wrong."""
        self._sites = sites
        self._store = store
        self._accounts = accounts
        self._service = service
        self._reporting = reporting
        self._notify = notify
        self._clock = clock
        # By site: a robot does one thing after the other.
        self._going: dict[str, _Going] = {}
        # Sites where one is about to begin: two that press at once are one.
        self._starting: set[str] = set()

    async def open(self) -> None:
        """End what a former run of the hub left, and tell of what was missed meanwhile.

        Nothing goes on by itself: what the robot did meanwhile, nobody here knows.
        """
        for record in await self._store.unfinished_runs():
            for step in record.steps:
                if step.state == "running":
                    step.state = "unknown" if step.command else "cancelled"
                    step.message = "the hub ended meanwhile; look at the device"
                    step.ended_us = self._now_us()
            await self._end_record(record, RunEnd("interrupted", "the hub ended meanwhile"))

    async def close(self) -> None:
        """End every run: without the hub nothing new begins."""
        for going in list(self._going.values()):
            going.run.cancel_steps("the hub ends")
        tasks = [going.task for going in self._going.values()]
        if not tasks:
            return
        _, late = await asyncio.wait(tasks, timeout=_RETRY_S)
        # What is not written down now is found unfinished at the next start.
        for task in late:
            task.cancel()

    def run_of(self, site: str) -> RunRecord | None:
        """Give the run that goes on at a site."""
        going = self._going.get(site)
        return None if going is None else going.run.record

    def due_us(self, live: LiveSite, mission: Mission, after_us: int = 0) -> int:
        """Tell when a mission is due next (µs, UTC); 0: never."""
        if mission.schedule is None:
            return 0
        zone = live.description.zone
        return next_due_us(mission.schedule, zone, after_us or self._now_us()) or 0

    async def start(
        self, live: LiveSite, kept: KeptMission, *, user: int, begun_by: str, first: int = 0
    ) -> RunRecord:
        """Begin a mission now, with the rights that an account has now.

        Args:
            live: the site.
            kept: the mission.
            user: with whose rights.
            begun_by: who pressed start, or `SCHEDULE`.
            first: the step to begin with, counted from 0.

        Raises:
            NotStarted: why not; nothing was asked of the robot.
            StoreDown: it cannot be written down, so it is not begun.

        """
        if live.name in self._starting:
            raise NotStarted("a mission is about to begin there")
        self._starting.add(live.name)
        try:
            return await self._start(live, kept, user=user, begun_by=begun_by, first=first)
        finally:
            self._starting.discard(live.name)

    async def _start(
        self, live: LiveSite, kept: KeptMission, *, user: int, begun_by: str, first: int
    ) -> RunRecord:
        going = self._going.get(live.name)
        if going is not None:
            raise NotStarted(f"{going.run.record.name} goes on there")
        who = await self._allowed_account(live, kept.mission, user)
        record = RunRecord(
            site=live.name,
            mission_id=kept.id,
            name=kept.mission.name,
            who=who.name,
            begun_by=begun_by,
            began_us=self._now_us(),
            steps=[StepRecord(step_name(step, live)) for step in kept.mission.steps],
        )
        # On disk before anything is asked.
        await self._store.add_run(record)
        line = MissionLine(self._service, who, kept.mission.name)
        run = MissionRun(
            live,
            kept.mission,
            record=record,
            line=line,
            save=self._save,
            clock=self._clock,
        )
        self._report(live, record, "mission started", f"begun by {begun_by}")
        task = asyncio.create_task(self._serve(live, run, line, first))
        self._going[live.name] = _Going(run, kept.mission, user, task)
        return record

    async def _allowed_account(self, live: LiveSite, mission: Mission, user: int) -> Who:
        who = await self._accounts.find_account(user)
        if who is None:
            raise NotStarted(_NO_ACCOUNT)
        if problem := start_problem(live, mission, who, self._clock.monotonic_ns()):
            raise NotStarted(problem)
        return who

    async def resume(self, live: LiveSite, who: str) -> None:
        """Let a paused run go on, where a mission might begin now.

        Raises:
            NotStarted: why it does not; it stays paused.
            StoreDown: it cannot be told whether it may.

        """
        going = self._find_going(live)
        await self._allowed_account(live, going.mission, going.user)
        going.run.resume_steps()
        self._report(live, going.run.record, "mission resumed", f"by {who}")
        await self._save(going.run.record)

    async def pause(self, live: LiveSite, who: str) -> None:
        """Have a run begin no further step.

        Raises:
            NotStarted: none goes on there.

        """
        going = self._find_going(live)
        going.run.pause_steps()
        self._report(live, going.run.record, "mission paused", f"by {who}")
        await self._save(going.run.record)

    def cancel(self, live: LiveSite, who: str) -> None:
        """End a run, and what is under way.

        Raises:
            NotStarted: none goes on there.

        """
        self._find_going(live).run.cancel_steps(f"cancelled by {who}")

    def _find_going(self, live: LiveSite) -> _Going:
        going = self._going.get(live.name)
        if going is None:
            raise NotStarted("no mission goes on there")
        return going

    async def _serve(self, live: LiveSite, run: MissionRun, line: MissionLine, first: int) -> None:
        line.begin_hearing()
        end = RunEnd("interrupted", "it ended by a mistake of the hub's; see its log")
        try:
            end = await run.do_steps(first)
        except StoreDown:
            end = RunEnd("interrupted", "the hub's database does not answer")
        except Exception:  # noqa: BLE001 - whatever it is, the run is over and that is told
            _LOG.exception("mission %s of %s", run.record.name, live.name)
        finally:
            await line.end_hearing()
            del self._going[live.name]
        await self._end_record(run.record, end)

    async def _end_record(self, record: RunRecord, end: RunEnd) -> None:
        record.state, record.why, record.ended_us = end.state, end.why, self._now_us()
        live = self._sites.find_site(record.site)
        if live is not None:
            self._report(live, record, f"mission {end.state}", end.why)
        written = False
        while not written:
            try:
                await self._store.save_run(record)
                if live is not None and end.state in _BAD:
                    await self._notify(live, record)
                written = True
            except StoreDown as error:
                _LOG.warning("how mission %s ended is written down later: %s", record.name, error)
                await asyncio.sleep(_RETRY_S)

    # ── schedules ──

    async def watch_schedules(self) -> None:
        """Begin what is due until cancelled."""
        readable = True
        while True:
            try:
                await self.look_at_schedules()
                if not readable:
                    _LOG.warning("schedules of missions are read again")
                readable = True
            except StoreDown as error:
                # Once, and not at each look.
                if readable:
                    _LOG.warning("schedules of missions cannot be read: %s", error)
                readable = False
            await asyncio.sleep(_LOOK_S)

    async def look_at_schedules(self) -> None:
        """Begin what is due; tell of what is past its time, which is not done any more.

        Raises:
            StoreDown: it cannot be told what is due.

        """
        now_us = self._now_us()
        for kept in await self._store.due_missions(now_us):
            live = self._sites.find_site(kept.site)
            # Taken first: whatever happens next, this time is acted on once.
            next_us = 0 if live is None else self.due_us(live, kept.mission, now_us)
            if not await self._store.claim_due(kept, next_us) or live is None:
                continue
            late_us = now_us - kept.due_us
            if late_us > _LATEST_US:
                await self._miss(live, kept, "the hub was not running, or stood still, at its time")
                continue
            try:
                await self.start(live, kept, user=kept.owner_id, begun_by=SCHEDULE)
            except NotStarted as refused:
                await self._miss(live, kept, refused.why)

    async def _miss(self, live: LiveSite, kept: KeptMission, why: str) -> None:
        record = RunRecord(
            site=live.name,
            mission_id=kept.id,
            name=kept.mission.name,
            who=kept.owner,
            begun_by=SCHEDULE,
            began_us=kept.due_us,
        )
        await self._store.add_run(record)
        await self._end_record(record, RunEnd("missed", why))

    async def _save(self, record: RunRecord) -> None:
        await self._store.save_run(record)

    def _report(self, live: LiveSite, record: RunRecord, kind: str, more: str) -> None:
        # Of the whole site: a mission may use several devices.
        self._reporting.report_event(
            live,
            kind,
            who=record.who,
            message=f"{record.name} (run {record.id})" + (f": {more}" if more else ""),
            good=record.state not in _BAD,
        )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
