"""What of a site is on one server, given to another one, taken from another one, and erased."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import delete, select

from talaia.hub.history.sensors.sensor_views import adopt_sensors, drop_sensors, read_sensors
from talaia.hub.history.servers import site_reads
from talaia.hub.history.writing.writer_jobs import (
    Adopt,
    AdoptRuns,
    Forget,
    ReadRuns,
    SealSite,
)
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import Engine

    from talaia.hub.history.database_threads import DatabaseThreads
    from talaia.hub.history.sensors.sensor_registry import SensorRegistry
    from talaia.hub.history.servers.site_reads import SiteChannel, StoredBlock
    from talaia.hub.history.writing.block_index import BlockIndex
    from talaia.hub.history.writing.tidying import Tidier
    from talaia.hub.history.writing.writer import Writer
    from talaia.hub.history.writing.writer_jobs import GapJob

__all__ = ["CopiedChannel", "SiteTransfer"]

# Rows deleted, and readings copied, in one transaction.
_ROWS = 5_000
_BLOCKS = 256
_channel, _block = tables.channel, tables.block


class CopiedChannel(NamedTuple):
    """How far a channel has come; ``block``: up to which, by the number where it comes from."""

    address: str
    move: str
    block: int


class SiteTransfer:
    """One server's side of a move; a site is written by nobody else while it is used."""

    def __init__(
        self,
        *,
        threads: DatabaseThreads,
        reading: Engine,
        writing: Engine,
        writer: Writer,
        sensors: SensorRegistry,
        ledger: BlockIndex,
        tidier: Tidier,
    ) -> None:
        """Read in ``threads``, and let ``writer`` do what changes its ``ledger``."""
        self._threads = threads
        self._reading, self._writing = reading, writing
        self._writer = writer
        self._sensors = sensors
        # Knows which sites are here.
        self._ledger = ledger
        # Waits while a site moves.
        self._tidier = tidier

    def has_site(self, site: str) -> bool:
        """Tell whether anything is known of a site."""
        names = self._ledger.names
        return any(key[0] == site for key in (*names.channels.copy(), *names.boots.copy()))

    def hold_retention(self, site: str, *, held: bool) -> None:
        """Drop nothing while a site moves, or go on."""
        (self._tidier.held_for.add if held else self._tidier.held_for.discard)(site)

    # ── where it comes from ──

    async def list_channels(self, site: str) -> list[SiteChannel]:
        """List a site's channels, with samples or without."""
        return await self._threads.run_query(site_reads.list_channels, self._reading, site)

    async def list_blocks(self, site: str) -> list[StoredBlock]:
        """List a site's blocks, by channel and number."""
        return await self._threads.run_query(site_reads.list_blocks, self._reading, site)

    async def read_blocks(
        self, blocks: Sequence[StoredBlock]
    ) -> tuple[list[tuple[dict[str, Any], bytes]], list[dict[str, Any]]]:
        """Read blocks with their bodies, and the rollup rows in which they are."""
        return await self._threads.run_query(site_reads.read_blocks, self._reading, blocks)

    async def read_recent(
        self, channels: Sequence[SiteChannel], after: tuple[int, int]
    ) -> list[dict[str, Any]]:
        """Read some of the readings that views show, after a time and a channel."""
        ids = [channel.id for channel in channels]
        return await self._threads.run_query(site_reads.read_recent, self._reading, ids, after)

    async def read_sensors(self, site: str) -> list[dict[str, Any]]:
        """Read what a site's sensors are, and were."""
        return await self._threads.run_query(read_sensors, self._reading, site)

    async def seal_site(self, site: str) -> None:
        """Make blocks of all that a site has outside of them; of what comes meanwhile, most."""
        before = None
        # Of a site that is sent to, something is always outside: it is enough that no more goes in.
        while (left := await self._writer.complete_job(SealSite(site))) and left != before:
            before = left

    async def seal_all(self, site: str) -> None:
        """Make blocks of all that a site has outside of them; nothing comes meanwhile."""
        while await self._writer.complete_job(SealSite(site)):
            pass

    async def write_runs(self, site: str) -> None:
        """Have in the database what of each boot is stored, for others who read it there."""
        await self._writer.complete_job(AdoptRuns(site, {}))

    async def read_runs(self, site: str) -> dict[str, list[tuple[int, int]]]:
        """Give what of each boot is stored."""
        found: dict[str, list[tuple[int, int]]] = {}
        await self._writer.complete_job(ReadRuns(site, found))
        return found

    async def read_gaps(self, site: str) -> list[GapJob]:
        """Give what of each boot is lost, as it is written."""
        return await self._threads.run_query(site_reads.read_gaps, self._reading, site)

    # ── where it goes ──

    async def read_copied(self, site: str) -> dict[int, CopiedChannel]:
        """Tell how far a site has come here, by its channels' numbers where it comes from."""
        return await self._threads.run_query(_read_copied, self._reading, site)

    async def clear_copied(self, site: str) -> None:
        """Forget how far a site has come: it is here, and nothing of it is a copy."""
        await self._threads.run_query(_clear_copied, self._writing, site)

    async def adopt_rows(self, job: Adopt) -> None:
        """Store blocks and rows that come."""
        await self._writer.complete_job(job)

    async def adopt_runs(
        self, site: str, runs: Mapping[str, Sequence[tuple[int, int]]], gaps: Sequence[GapJob]
    ) -> None:
        """Count as stored, or as lost, what is that where the site comes from."""
        await self._writer.complete_job(AdoptRuns(site, runs))
        for gap in gaps:
            await self._writer.complete_job(gap)

    async def adopt_sensors(self, site: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Know what sensors are, and were, of which nothing is known here."""
        await self._threads.run_query(adopt_sensors, self._writing, site, rows)
        await self._sensors.load_sensors()

    # ── what is left behind ──

    async def erase_site(self, site: str) -> None:
        """Delete all of a site, a little at a time; broken off, it is done again."""
        await self._sensors.wait_for_views()
        while await self._threads.run_query(drop_sensors, self._writing, site):
            pass
        self._sensors.forget_site(site)
        # Nothing may be dealt to channels that are gone.
        await self.seal_all(site)
        while await self._threads.run_query(_erase_some, self._writing, site):
            pass
        await self._writer.complete_job(Forget(site))


def _read_copied(engine: Engine, site: str) -> dict[int, CopiedChannel]:
    table = tables.copied
    with engine.begin() as connection:
        rows = connection.execute(select(table).where(table.c.site == site)).all()
    return {row.source_channel: CopiedChannel(row.address, row.move, row.block_id) for row in rows}


def _clear_copied(engine: Engine, site: str) -> None:
    with engine.begin() as connection:
        connection.execute(delete(tables.copied).where(tables.copied.c.site == site))


def _erase_some(engine: Engine, site: str) -> bool:
    """Delete some of a site's rows; tell whether there were any."""
    with engine.begin() as connection:
        blocks = connection.execute(
            select(_block.c.channel_id, _block.c.first_us, _block.c.id)
            .join(_channel, _channel.c.id == _block.c.channel_id)
            .where(_channel.c.site == site)
            .limit(_BLOCKS)
        ).all()
        if blocks:
            ids = [row.id for row in blocks]
            connection.execute(delete(tables.body).where(tables.body.c.block_id.in_(ids)))
            for channel in {row.channel_id for row in blocks}:
                mine = [row for row in blocks if row.channel_id == channel]
                connection.execute(
                    delete(_block).where(
                        _block.c.channel_id == channel,
                        _block.c.first_us.in_([row.first_us for row in mine]),
                        _block.c.id.in_([row.id for row in mine]),
                    )
                )
            return True
        channels = list(connection.scalars(select(_channel.c.id).where(_channel.c.site == site)))
        for table in (tables.rollup, tables.recent):
            for channel in channels:
                past_us = _some_time(connection, table, channel)
                if past_us is None:
                    continue
                column = table.c.bucket_us if table is tables.rollup else table.c.time_us
                connection.execute(
                    delete(table).where(table.c.channel_id == channel, column <= past_us)
                )
                return True
    return False


def _some_time(connection: Any, table: Any, channel: int) -> int | None:  # noqa: ANN401
    """Give a time up to which a channel has at most so many rows; None: it has none."""
    column = table.c.bucket_us if table is tables.rollup else table.c.time_us
    query = select(column).where(table.c.channel_id == channel).order_by(column).limit(_ROWS)
    found = connection.scalars(query).all()
    return int(found[-1]) if found else None
