"""Releases of gateways: which are there, and how they are handed out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.releases.release_pages import ReleasePages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.releases.release_folder import ReleaseFolder
from talaia.hub.live.releases.rollout_service import RolloutService

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.store.audit import Audit

__all__ = ["ReleasesFeature"]


class ReleasesFeature(Feature):
    """Releases that an admin has put into the data folder, for gateways that take them.

    Attributes:
        rollouts: hands them out.

    """

    name = "releases"

    def __init__(self, core: Core, *, reporting: RobotEvents, audit: Audit) -> None:
        """Tell ``reporting`` what becomes of each gateway."""
        self.rollouts = RolloutService(
            folder=ReleaseFolder(core.settings.data / "releases", core.shard.suffix),
            sites=core.sites,
            reporting=reporting,
            clock=core.clock,
        )
        pages = ReleasePages(self.rollouts, sites=core.sites, audit=audit)
        self.routers = [pages.make_router()]
        self.tasks = [BackgroundTask(name="hand out releases", run=self.rollouts.run)]

    async def open(self) -> None:
        """Go on with the rollout of before."""
        await self.rollouts.open()
