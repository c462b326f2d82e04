"""The audit log: what happened, who asked for it, and how it ended."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.audit import AuditPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.store.audit import Audit

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core

__all__ = ["AuditFeature"]


class AuditFeature(Feature):
    """First to begin and last to end, so that every other feature can write.

    Attributes:
        log: what other features write to.

    """

    name = "audit"

    def __init__(self, core: Core) -> None:
        """Keep the log in the hub's database."""
        self.log = Audit(core.database, core.clock)
        self.routers = [AuditPages(self.log).make_router()]
        # Rows are chained, so one task writes them, one after the other.
        self.tasks = [
            BackgroundTask(name="write", run=self._write_records, stop=self._stop_writing)
        ]

    async def _write_records(self) -> None:
        self.log.append_record("hub started")
        await self.log.run()

    def _stop_writing(self) -> None:
        # Before the stop, which lets what waits be written once more.
        self.log.append_record("hub stopped")
        self.log.stop()
