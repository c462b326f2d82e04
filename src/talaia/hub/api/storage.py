"""How much room the history takes, for admins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter

from talaia.hub.api.history_shapes import ChannelStorageShape, StorageShape

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.storage import Storage
    from talaia.hub.ports import History

__all__ = ["StoragePages", "full_at"]

_DAY_US = 86_400_000_000


class StoragePages:
    """The route of storage."""

    def __init__(self, history: History, clock: Clock) -> None:
        """Answer from what is stored."""
        self._history = history
        self._clock = clock

    def router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter()
        router.get("/api/storage")(self.storage)
        return router

    async def storage(self) -> StorageShape:
        """Tell what the history takes, channel by channel, and when it will be full."""
        found = await self._history.storage()
        limit = self._history.most_bytes
        return StorageShape(
            database_bytes=found.database_bytes,
            blocks_bytes=found.blocks_bytes,
            free_bytes=found.free_bytes,
            limit_bytes=limit,
            day_bytes=found.day_bytes,
            full_us=full_at(found, limit, self._clock.wall_ns() // 1000),
            channels=[
                ChannelStorageShape(
                    keep_days=self._history.kept_us(each.site, each.address) / _DAY_US,
                    **each._asdict(),
                )
                for each in found.channels
            ],
        )


def full_at(found: Storage, limit: int, now_us: int) -> int | None:
    """Give when (µs since the epoch) the limit or the disk is reached at the present rate."""
    days = []
    lately = sum(each.day_bytes for each in found.channels)
    if limit and lately:
        days.append(max(0.0, (limit - found.blocks_bytes) / lately))
    if found.free_bytes is not None and found.day_bytes:
        days.append(found.free_bytes / found.day_bytes)
    # Beyond a hundred years a forecast says nothing.
    return now_us + round(min(days) * _DAY_US) if days and min(days) < 36_500 else None
