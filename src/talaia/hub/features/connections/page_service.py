"""What serves every connection, of pages and of other tools' clients, by the same rights."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.feature import Feature
from talaia.hub.live.pages.message_authorizer import MessageAuthorizer
from talaia.hub.live.pages.page_commands import PageCommands
from talaia.hub.live.pages.page_service import PageMessages, PageService

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.features.sightings import SightingsFeature
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.observing.night_board import NightBoard
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.audit import Audit

__all__ = ["ConnectionsFeature"]


class ConnectionsFeature(Feature):
    """One service for all connections.

    Attributes:
        service: serves each over its own transport.

    """

    name = "connections"

    def __init__(
        self,
        core: Core,
        *,
        seats: SocketSessions,
        reporting: RobotEvents,
        sightings: SightingsFeature,
        nights: NightBoard,
        audit: Audit,
    ) -> None:
        """Tell a connection that comes what ``reporting``, ``sightings`` and ``nights`` know."""
        self.service = PageService(
            # Each message is held against the rights of this moment.
            gate=MessageAuthorizer(sites=core.sites, rights=seats),
            seats=seats,
            browsers=core.browsers,
            greeters=(reporting, sightings.journal, nights),
            messages=PageMessages(
                fanout=core.fanout,
                commanding=PageCommands(core.sites, reporting.held_stops, audit),
                clock=core.clock,
            ),
        )
