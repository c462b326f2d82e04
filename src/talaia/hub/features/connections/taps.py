"""Raw topics of robots: which there are, and one of them for a page that follows it.

`Core.taps` hands them to all who take them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.assets import AssetPages
from talaia.hub.api.sites.topics import TopicPages
from talaia.hub.api.sockets.topic_sockets import TopicSockets
from talaia.hub.features.feature import Feature
from talaia.hub.live.assets.asset_cache import AssetCache
from talaia.hub.live.assets.asset_folder import AssetFolder
from talaia.hub.live.assets.robot_assets import RobotAssets

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.audit import Audit

__all__ = ["TapsFeature"]


class TapsFeature(Feature):
    """Lists topics to people, lets their pages follow them, and hands out meshes.

    Attributes:
        assets: files of robots, and those of them that gateways hand over.

    """

    name = "taps"

    def __init__(
        self, core: Core, *, admission: SocketAdmission, seats: SocketSessions, audit: Audit
    ) -> None:
        """Let pages in by ``admission``; ``seats`` closes whose right has ended."""
        data = core.settings.data
        self.assets = RobotAssets(
            folder=AssetFolder(core.settings.assets),
            cache=AssetCache(data / "meshes"),
            # Beside the sites in the cache: none of them has such a name.
            uploads=data / "meshes" / ".coming",
            sites=core.sites,
            taps=core.taps,
            has_site=core.shard.has_site,
        )
        self.routers = [TopicPages(core.taps).router(), AssetPages(self.assets).router()]
        sockets = TopicSockets(
            admission=admission,
            sites=core.sites,
            seats=seats,
            taps=core.taps,
            clock=core.clock,
            audit=audit,
        )
        self.sockets = [sockets.router()]

    async def close(self) -> None:
        """Wait for no gateway any more."""
        await self.assets.close()
