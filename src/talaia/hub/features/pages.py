"""Pages: their files, the sites they list, and their sockets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.openapi import ApiDescription
from talaia.hub.api.sites.sites import SitePages
from talaia.hub.api.sockets.page_sockets import PageMessages, PageSockets
from talaia.hub.api.static_pages import Pages
from talaia.hub.features.feature import Feature
from talaia.hub.live.pages.message_authorizer import MessageAuthorizer
from talaia.hub.live.pages.page_commands import PageCommands
from talaia.web import static_dir

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.features.sightings import SightingsFeature
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.pages.session_registry import SocketSessions
    from talaia.hub.store.audit import Audit

__all__ = ["PagesFeature"]


class PagesFeature(Feature):
    """The last of all: its route takes every path that no other one takes."""

    name = "pages"

    def __init__(
        self,
        core: Core,
        *,
        admission: SocketAdmission,
        seats: SocketSessions,
        reporting: RobotEvents,
        sightings: SightingsFeature,
        audit: Audit,
    ) -> None:
        """Tell a page that comes what ``reporting`` and ``sightings`` know."""
        sockets = PageSockets(
            admission=admission,
            # Each message of a page is held against the rights of this moment.
            gate=MessageAuthorizer(sites=core.sites, rights=seats),
            seats=seats,
            browsers=core.browsers,
            greeters=(reporting, sightings.journal),
            messages=PageMessages(
                fanout=core.fanout,
                commanding=PageCommands(core.sites, audit),
                clock=core.clock,
            ),
        )
        sites = SitePages(
            sites=core.sites, audit=audit, sightings=sightings.store, clock=core.clock
        )
        self.sockets = [sockets.router()]
        # `Pages` last: it takes every path.
        self.routers = [sites.router(), ApiDescription().router(), Pages(static_dir()).router()]
