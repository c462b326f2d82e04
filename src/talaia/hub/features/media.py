"""Pictures of cameras, from gateways to pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sockets.gateway_sockets import GatewaySocket
from talaia.hub.api.sockets.picture_sockets import PictureSockets
from talaia.hub.features.feature import Feature
from talaia.hub.live.pictures.media_link import MediaLinks
from talaia.hub.live.pictures.picture_fanout import PictureFanout

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.features.people import PeopleFeature
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.store.audit import Audit

__all__ = ["MediaFeature"]


class MediaFeature(Feature):
    """Streams, each asked for only while somebody looks.

    Attributes:
        streams: all of them.

    """

    name = "media"

    def __init__(
        self,
        core: Core,
        *,
        people: PeopleFeature,
        links: OpenLinks,
        flood_guard: FloodGuard,
        audit: Audit,
    ) -> None:
        """Let in who is of ``people``; those and ``links`` close whose right has ended.

        ``flood_guard`` slows gateways that say too much; ``audit`` has who looked unblurred.
        """
        # One copy of each stream comes from its gateway, however many look at it.
        self.streams = PictureFanout(core.sites, core.clock, core.settings.linger_s)
        pages = PictureSockets(
            admission=people.admission,
            sites=core.sites,
            seats=people.seats,
            media=self.streams,
            clock=core.clock,
            audit=audit,
        )
        gateways = GatewaySocket(
            "/gateway/media",
            admission=people.admission,
            flood_guard=flood_guard,
            server=MediaLinks(
                sites=core.sites,
                media=self.streams,
                taps=core.taps,
                links=links,
                flood_guard=flood_guard,
                clock=core.clock,
            ),
        )
        self.sockets = [pages.router(), gateways.router()]

    async def close(self) -> None:
        """Stop the timers."""
        self.streams.close()
