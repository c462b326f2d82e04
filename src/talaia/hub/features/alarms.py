"""Alarms: judged, kept, shown, acted on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sites.alarms import AlarmPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.live.alarms.alarm_engine import AlarmEngine
from talaia.hub.store.alarms.alarm_states import AlarmStore
from talaia.hub.store.alarms.notification_outbox import NotificationOutbox

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.ports import History
    from talaia.hub.store.accounts.people import People
    from talaia.hub.store.audit import Audit

__all__ = ["AlarmsFeature"]


class AlarmsFeature(Feature):
    """Every alarm of every site.

    Attributes:
        engine: judges and keeps them; it is the `AnomalySink` and `SightingSink` that
            detectors speak to.
        outbox: messages that are to be sent about them.

    """

    name = "alarms"

    def __init__(self, core: Core, *, people: People, history: History, audit: Audit) -> None:
        """Preview alarms on ``history``; ``people`` are named by who acted."""
        # Alarms and what has happened to them; the engine writes, the pages only read.
        store = AlarmStore(core.database, core.shard.own_rows)
        self.outbox = NotificationOutbox(core.database)
        self.engine = AlarmEngine(
            sites=core.sites,
            browsers=core.browsers,
            store=store,
            notices=self.outbox,
            clock=core.clock,
        )
        pages = AlarmPages(
            alarms=self.engine,
            store=store,
            people=people,
            history=history,
            audit=audit,
            clock=core.clock,
        )
        self.routers = [pages.make_router()]
        self.tasks = [
            # Told to end instead of cancelled: what was judged is still to be written.
            BackgroundTask(name="judge", run=self.engine.run, stop=self.engine.stop),
        ]

    async def open(self) -> None:
        """Bring back how alarms stood."""
        await self.engine.open()
