"""What an admin hands on to whoever helps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.server.support_bundle import SupportBundlePages
from talaia.hub.features.feature import Feature
from talaia.hub.store.sites.descriptions import Descriptions

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.store.audit import Audit

__all__ = ["SupportFeature"]


class SupportFeature(Feature):
    """The support bundle, as a download."""

    name = "support"

    def __init__(self, core: Core, *, audit: Audit) -> None:
        """Write to ``audit`` that one was made."""
        pages = SupportBundlePages(
            settings=core.settings,
            sites=core.known_sites,
            descriptions=Descriptions(core.database, core.clock),
            audit=audit,
        )
        self.routers = [pages.make_router()]
