"""Sightings: what cameras have seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.sightings import SightingPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.detection.sightings import SightingJournal
from talaia.hub.store.sites.sighting_reviews import SightingReviews
from talaia.hub.store.sites.sightings import SightingStore

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.live.alarms.alarm_engine import AlarmEngine

__all__ = ["SightingsFeature"]


class SightingsFeature(Feature):
    """Keeps each sighting once, and tells pages and alarms of it.

    Attributes:
        journal: takes them.
        store: where they are kept.

    """

    name = "sightings"

    def __init__(self, core: Core, *, alarms: AlarmEngine) -> None:
        """Tell ``alarms`` of every sighting."""
        self.store = SightingStore(core.database, core.shard.own_rows)
        self.journal = SightingJournal(
            sites=core.sites,
            browsers=core.browsers,
            store=self.store,
            clock=core.clock,
            days=core.settings.sightings_days,
            most=core.settings.sightings_most,
        )
        # The journal tells each sighting once, also where a gateway reports it again.
        self.journal.add_listener(alarms)
        self.routers = [SightingPages(self.store, SightingReviews(core.database)).make_router()]
        self.tasks = [BackgroundTask(name="keep", run=self.journal.run, stop=self.journal.stop)]

    async def open(self) -> None:
        """Bring back what was in sight."""
        await self.journal.open()
