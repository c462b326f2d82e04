"""Recordings that `talaia import` leaves in the data folder."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.history.import_file import FOLDER
from talaia.hub.live.files.import_inbox import ImportInbox
from talaia.hub.live.offline_sites import ImportedSites

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine
    from talaia.hub.ports import History
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.site_registry import SiteRegistry

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
        alarms: AlarmEngine,
        audit: Audit,
    ) -> None:
        """Store in ``history``; a site that nobody knew is described to ``alarms``."""
        imported = ImportedSites(
            sites=core.sites, registry=registry, history=history, alarms=alarms, audit=audit
        )
        # A folder in which ``talaia import`` leaves what it has read, for the hub to store.
        folder = core.settings.data / FOLDER
        inbox = ImportInbox(history, folder, imported.record_import, shard=core.shard)
        self.tasks = [BackgroundTask(name="take imports", run=inbox.run)]
