"""Missions: steps in order that a robot does, begun by people or by a schedule."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.missions.mission_pages import MissionPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.missions.mission_service import MissionService
from talaia.hub.store.missions.mission_notices import add_mission_notice
from talaia.hub.store.missions.mission_store import MissionStore

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.features.feature import Core
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pages.page_service import PageService
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.accounts.mission_accounts import MissionAccounts
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.missions.mission_store import RunRecord

__all__ = ["MissionsFeature"]


class MissionsFeature(Feature):
    """Missions of all sites.

    Attributes:
        store: what is kept.
        service: runs them.

    """

    name = "missions"

    def __init__(
        self,
        core: Core,
        *,
        accounts: MissionAccounts,
        pages: PageService,
        reporting: RobotEvents,
        deliver: Callable[[], None],
        audit: Audit,
    ) -> None:
        """Ask robots by ``pages``; ``deliver`` is called when there may be a message to send."""
        self._core = core
        self._deliver = deliver
        self.store = MissionStore(core.database, core.clock, core.shard.own_rows)
        self.service = MissionService(
            sites=core.sites,
            store=self.store,
            accounts=accounts,
            service=pages,
            reporting=reporting,
            notify=self._notify,
            clock=core.clock,
        )
        self.routers = [
            MissionPages(
                store=self.store, service=self.service, audit=audit, clock=core.clock
            ).make_router()
        ]
        self.tasks = [BackgroundTask(name="schedules", run=self.service.watch_schedules)]

    async def open(self) -> None:
        """Tell of runs that the end of the hub interrupted."""
        await self.service.open()

    async def close(self) -> None:
        """End what goes on."""
        await self.service.close()

    async def _notify(self, live: LiveSite, record: RunRecord) -> None:
        now_us = self._core.clock.wall_ns() // 1000
        if await add_mission_notice(self._core.database, record, live.description.name, now_us):
            self._deliver()
