"""How much room the history takes, and when it will be full: for admins."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter

from talaia.clock import SECOND
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.history_schemas import ChannelStorageShape, OutlookShape, StorageShape
from talaia.hub.history.forecast import DAY_US, StorageRoom, Warn, forecast_storage, growth_of

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.files.ports import FileStore
    from talaia.hub.history.forecast import Forecast, Growth
    from talaia.hub.history.storage import ChannelStorage, Storage
    from talaia.hub.live.sites import Sites
    from talaia.hub.ports import History

__all__ = ["StoragePages"]

# Every page of an admin asks for the outlook; the list of blocks is not gone through for each.
_OUTLOOK_NS = 300 * SECOND


class StoragePages:
    """The routes of storage."""

    def __init__(self, *, history: History, files: FileStore, sites: Sites, clock: Clock) -> None:
        """Answer from what is stored; ``files`` are where whole files are."""
        self._history = history
        self._files = files
        self._sites = sites
        self._clock = clock
        # The last look and when it was (monotonic ns); shared by all pages.
        self._found: Storage | None = None
        self._found_ns = 0
        # One look at a time: who comes meanwhile takes what it finds.
        self._looking = asyncio.Lock()

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/storage")(self.storage)
        router.get("/api/storage/outlook")(self.outlook)
        return router

    async def storage(self) -> StorageShape:
        """Tell what the history takes, channel by channel, and when it will be full."""
        # Whoever opens the page of storage wants to see it as it is.
        found = await self._measure_storage(0)
        now_us = self._clock.wall_ns() // 1000
        said = self._make_forecast(found)
        return StorageShape(
            kind=found.kind,
            place=found.place,
            database_bytes=found.database_bytes,
            spare_bytes=found.spare_bytes,
            blocks_bytes=found.blocks_bytes,
            free_bytes=found.free_bytes,
            disk_bytes=found.disk_bytes,
            limit_bytes=self._history.most_bytes,
            day_bytes=said.day_bytes,
            full_us=said.full_us,
            by_limit=said.by_limit,
            oldest_us=said.oldest_us,
            kept_days=None if said.kept_us is None else said.kept_us / DAY_US,
            warn=said.warn,
            trouble=self._history.trouble,
            files_trouble=self._files.trouble,
            channels=[self._channel_schema(channel, now_us) for channel in found.channels],
        )

    async def outlook(self) -> OutlookShape:
        """Tell in short whether there is room for what comes; at most five minutes old."""
        trouble = self._history.trouble
        if trouble and self._found is None:
            # The database may be away: what is known must not wait for it.
            return OutlookShape(
                trouble=trouble,
                files_trouble=self._files.trouble,
                warn=Warn.NOTHING,
                full_us=None,
                free_bytes=None,
            )
        # In trouble the last look is shown, however old it is.
        found = self._found if trouble and self._found else await self._measure_storage(_OUTLOOK_NS)
        said = self._make_forecast(found)
        return OutlookShape(
            trouble=trouble,
            files_trouble=self._files.trouble,
            warn=said.warn,
            full_us=said.full_us,
            free_bytes=found.free_bytes,
        )

    async def _measure_storage(self, old_ns: int) -> Storage:
        """Look how much is stored, unless that was done less than ``old_ns`` ago."""
        async with self._looking:
            now_ns = self._clock.monotonic_ns()
            if self._found is None or now_ns - self._found_ns >= old_ns:
                self._found = await self._history.measure_storage()
                self._found_ns = now_ns
            return self._found

    def _make_forecast(self, found: Storage) -> Forecast:
        now_us = self._clock.wall_ns() // 1000
        # What is free inside the SQLite file is used again before the file grows.
        free = None if found.free_bytes is None else found.free_bytes + found.spare_bytes
        # Rollups and indices grow with the blocks.
        share = max(1.0, found.database_bytes / found.blocks_bytes) if found.blocks_bytes else 1.0
        room = StorageRoom(
            found.blocks_bytes, self._history.most_bytes, free, found.disk_bytes, share
        )
        return forecast_storage(
            room, [self._channel_growth(channel, now_us) for channel in found.channels], now_us
        )

    def _channel_growth(self, stored: ChannelStorage, now_us: int) -> Growth:
        keep_us = self._history.kept_us(stored.site, stored.address)
        # Of what is no longer described nothing more comes.
        week_bytes = stored.week_bytes if self._is_described(stored) else 0
        return growth_of(week_bytes, stored.first_us, keep_us, now_us)

    def _is_described(self, stored: ChannelStorage) -> bool:
        live = self._sites.find_site(stored.site)
        device, _, channel = stored.address.partition("/")
        described = live.description.devices.get(device) if live else None
        return described is not None and channel.partition(".")[0] in described.signals

    def _channel_schema(self, stored: ChannelStorage, now_us: int) -> ChannelStorageShape:
        kind = self._history.kind_of(stored.site, stored.address)
        return ChannelStorageShape(
            site=stored.site,
            address=stored.address,
            name=kind.name if kind else "",
            described=self._is_described(stored),
            samples=stored.samples,
            bytes=stored.bytes,
            day_bytes=round(self._channel_growth(stored, now_us).rate * DAY_US),
            first_us=stored.first_us,
            last_us=stored.last_us,
            keep_days=self._history.kept_us(stored.site, stored.address) / DAY_US,
        )
