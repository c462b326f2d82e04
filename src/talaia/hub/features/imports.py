"""Recordings that `talaia import` leaves in the data folder."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.history.parcel import FOLDER
from talaia.hub.live.inbox import Inbox
from talaia.hub.live.known import ImportedSites

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms import Alarms
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites import SiteRegistry

__all__ = ["ImportsFeature"]


class ImportsFeature(Feature):
    """Takes imports into the history, and knows their sites."""

    name = "imports"

    def __init__(
        self,
        core: Core,
        *,
        registry: SiteRegistry,
        history: History,
        alarms: Alarms,
        audit: Audit,
    ) -> None:
        """Store in ``history``; a site that nobody knew is described to ``alarms``."""
        imported = ImportedSites(
            sites=core.sites, registry=registry, history=history, alarms=alarms, audit=audit
        )
        inbox = Inbox(history, core.settings.data / FOLDER, imported.imported)
        self.tasks = [BackgroundTask(name="take imports", run=inbox.run)]
