"""Pages: their files, the sites they list, and their sockets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.accounts.unit_choices import UnitChoicePages
from talaia.hub.api.openapi import ApiDescription
from talaia.hub.api.sites.sites import SitePages
from talaia.hub.api.sockets.page_sockets import PageSockets
from talaia.hub.api.static_pages import Pages
from talaia.hub.features.feature import Feature
from talaia.hub.store.accounts.shown_units import ShownUnits
from talaia.web import static_dir

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.features.sightings import SightingsFeature
    from talaia.hub.live.pages.page_service import PageService
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
        service: PageService,
        sightings: SightingsFeature,
        audit: Audit,
    ) -> None:
        """Serve the sockets of pages by ``service``."""
        shown = ShownUnits(core.database)
        sites = SitePages(
            sites=core.sites,
            shown=shown,
            audit=audit,
            sightings=sightings.store,
            clock=core.clock,
        )
        self.sockets = [PageSockets(admission=admission, service=service).router()]
        # `Pages` last: it takes every path.
        self.routers = [
            sites.make_router(),
            UnitChoicePages(core.known_sites, shown).make_router(),
            ApiDescription().make_router(),
            Pages(static_dir()).make_router(),
        ]
