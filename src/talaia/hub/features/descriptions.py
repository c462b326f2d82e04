"""Site descriptions: their versions, and changes that are handed to gateways."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.descriptions import DescriptionPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.gateways.change_requests import ChangeRequestClient
from talaia.hub.live.gateways.description_intake import DescriptionIntake
from talaia.hub.live.site_mirror import SiteMirror
from talaia.hub.store.sites.descriptions import Descriptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.features.feature import Core
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.site_registry import SiteRegistry
    from talaia.model.description_follower import DescriptionFollower

__all__ = ["DescriptionsFeature"]


class DescriptionsFeature(Feature):
    """What describes a site, now and before.

    Attributes:
        describing: puts another description in a site's place.

    """

    name = "descriptions"

    def __init__(
        self,
        core: Core,
        *,
        followers: Sequence[DescriptionFollower[LiveSite]],
        reporting: RobotEvents,
        media: PictureFanout,
        history: History,
        registry: SiteRegistry,
        audit: Audit,
    ) -> None:
        """Show a description to ``followers`` in their order."""
        # Every text that a site went by.
        versions = Descriptions(core.database, core.clock)
        # What a person sent and a gateway has not answered yet.
        changes = ChangeRequestClient(registry)
        self.describing = DescriptionIntake(
            sites=core.sites,
            followers=followers,
            reporting=reporting,
            media=media,
            history=history,
            registry=registry,
            versions=versions,
            changes=changes,
        )
        pages = DescriptionPages(versions=versions, changes=changes, audit=audit)
        self.routers = [pages.make_router()]
        # Of other shards, where there are any and this hub answers for all.
        self._mirror = core.known_sites if isinstance(core.known_sites, SiteMirror) else None
        if self._mirror is not None:
            self.tasks = [BackgroundTask(name="sites of others", run=self._mirror.run)]

    async def open(self) -> None:
        """Know what sites of other shards are."""
        if self._mirror is not None:
            await self._mirror.refresh()
