"""The history: every sample, and the sites that are known by it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.records.history import HistoryPages
from talaia.hub.features.feature import BackgroundTask, Feature
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.build_history import build_history, check_homes
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.live.offline_sites import OfflineSites
from talaia.hub.store.sites.descriptions import Descriptions

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.ports import History
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["HistoryFeature"]


class HistoryFeature(Feature):
    """Samples that are stored.

    Attributes:
        store: keeps them and gives them back.

    """

    name = "history"

    def __init__(self, core: Core, *, store: History | None, registry: SiteRegistry) -> None:
        """Keep samples in ``store``; none: in the database of the settings."""
        limits = HistoryLimits(bytes=core.settings.history_bytes)
        # With connections of its own: a long read must not hold up sessions or the log.
        self.store = store or build_history(
            core.settings,
            core.database,
            core.clock,
            limits,
            on_connect=core.on_connect,
            shard=core.shard.name,
            plan=None if core.seat is None else core.seat.plan,
            begin_anew=None if core.seat is None else core.seat.begin_anew,
        )
        self._core = core
        if isinstance(self.store, HistoryServers):
            self.tasks = [BackgroundTask(name="servers", run=self.store.run)]
        # Sites of before, which are shown while their gateways are away.
        self._known_sites = OfflineSites(
            sites=core.sites,
            registry=registry,
            versions=Descriptions(core.database, core.clock),
            history=self.store,
            shard=core.shard,
            clock=core.clock,
        )
        self.routers = [HistoryPages(self.store).make_router()]

    async def open(self) -> None:
        """Open it, and know the sites of before with their last values."""
        if not self._core.settings.history_servers:
            await check_homes(self._core.database)
        await self.store.open()
        await self._known_sites.restore_sites()

    async def close(self) -> None:
        """Close it; what it was given is written first."""
        await self.store.close()
