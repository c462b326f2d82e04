"""The history of another shard's lead, read at its database: to read needs no term."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, TypeVar

from talaia.hub.history.connection_cut import ConnectionCut
from talaia.hub.history.database_threads import DatabaseThreads
from talaia.hub.history.engine import address_of, open_engine
from talaia.hub.history.errors import HistoryAway
from talaia.hub.history.sensors.sensor_views import read_sensors
from talaia.hub.history.servers import site_reads
from talaia.hub.store.lead.lead_lock import mark_apart

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from sqlalchemy import Engine

    from talaia.hub.history.servers.site_reads import SiteChannel, StoredBlock
    from talaia.hub.history.servers.write_term import WriteTerm
    from talaia.hub.history.writing.writer_jobs import GapJob

__all__ = ["OtherHistory"]

ResultT = TypeVar("ResultT")
# One that has not answered for so long stands still (s).
_STILL_S = 20.0


class OtherHistory:
    """What a move reads of a site whose history another lead writes; see `SiteSource`."""

    def __init__(self, url: str, term: WriteTerm | None) -> None:
        """Prepare for a URL; ``term`` sees that it is the right database (none: it surely is).

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        self._cut = ConnectionCut()
        # The lead of the main shard ends sessions there that are not marked.
        self._engine = open_engine(url, writes=False, on_connect=mark_apart(url), cut=self._cut)
        self._threads = DatabaseThreads(address_of(url), 1, "history-move")
        self._term = term

    async def check_owner(self) -> None:
        """See that it is the database that is meant.

        Raises:
            HistoryAway: it is another hub's, or has another name here, or cannot be read.

        """
        if self._term is not None:
            await self._ask(self._term.read_term)

    async def close(self) -> None:
        """Let go of it; what stands still is cut off."""
        self._cut.cut_all()
        await asyncio.to_thread(self._threads.close)
        self._engine.dispose()

    async def list_channels(self, site: str) -> list[SiteChannel]:
        """See `SiteSource.list_channels`."""
        return await self._ask(site_reads.list_channels, site)

    async def list_blocks(self, site: str) -> list[StoredBlock]:
        """See `SiteSource.list_blocks`."""
        return await self._ask(site_reads.list_blocks, site)

    async def read_blocks(
        self, blocks: Sequence[StoredBlock]
    ) -> tuple[list[tuple[dict[str, Any], bytes]], list[dict[str, Any]]]:
        """See `SiteSource.read_blocks`."""
        return await self._ask(site_reads.read_blocks, blocks)

    async def read_recent(
        self, channels: Sequence[SiteChannel], after: tuple[int, int]
    ) -> list[dict[str, Any]]:
        """See `SiteSource.read_recent`."""
        ids = [channel.id for channel in channels]
        return await self._ask(site_reads.read_recent, ids, after)

    async def read_sensors(self, site: str) -> list[dict[str, Any]]:
        """See `SiteSource.read_sensors`."""
        return await self._ask(read_sensors, site)

    async def read_runs(self, site: str) -> dict[str, list[tuple[int, int]]]:
        """See `SiteSource.read_runs`; right once the other lead has written them."""
        return await self._ask(site_reads.read_runs, site)

    async def read_gaps(self, site: str) -> list[GapJob]:
        """See `SiteSource.read_gaps`."""
        return await self._ask(site_reads.read_gaps, site)

    async def _ask(self, read: Callable[..., ResultT], *asked: object) -> ResultT:
        def ask(engine: Engine) -> ResultT:
            return read(engine, *asked)

        try:
            async with asyncio.timeout(_STILL_S):
                return await self._threads.run_query(ask, self._engine)
        except TimeoutError:
            # Its thread waits yet: nothing more can be asked there.
            self._cut.cut_all()
            raise HistoryAway(f"it has not answered for {_STILL_S:g} s") from None
