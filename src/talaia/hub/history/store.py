"""The history as the rest of the hub sees it; how it is done is in the modules beside it.

Long, because all that the history promises stands here in one place.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.history.database_threads import DatabaseThreads
from talaia.hub.history.engine import READERS, Checkpoints, address_of, open_engine
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.queries.channels import stored_channels
from talaia.hub.history.queries.long_reads import LongReads
from talaia.hub.history.queries.reader import Reader
from talaia.hub.history.queries.statistics import read_statistics
from talaia.hub.history.queries.window import FARTHEST_US
from talaia.hub.history.repeated_work import RepeatedWork
from talaia.hub.history.sensors.sensor_registry import SensorRegistry
from talaia.hub.history.servers.site_transfer import SiteTransfer
from talaia.hub.history.storage import read_storage
from talaia.hub.history.writing.block_index import BlockIndex
from talaia.hub.history.writing.retention_periods import RetentionPeriods
from talaia.hub.history.writing.tidying import Tidier
from talaia.hub.history.writing.writer import Writer
from talaia.hub.history.writing.writer_jobs import (
    Append,
    Below,
    Describe,
    GapJob,
    Rename,
    Show,
)
from talaia.hub.store.history_tables import HISTORY_TABLES
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from collections.abc import (
        AsyncGenerator,
        AsyncIterator,
        Collection,
        Mapping,
        Sequence,
    )

    from talaia.clock import Clock
    from talaia.hub.history.connection_cut import ConnectionCut
    from talaia.hub.history.queries.channels import StoredChannel
    from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.series import Series
    from talaia.hub.history.queries.statistics import Statistics
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.history.servers.write_term import WriteTerm
    from talaia.hub.history.storage import Storage
    from talaia.hub.store.database_url import OnConnect
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = ["HistoryStore"]


class HistoryStore:
    """Samples for good, in one SQL database; nothing of it runs on the event loop.

    One program at a time may have a database's history open. Times are microseconds since the
    epoch (UTC). By ``transfer`` a site comes from another server, or goes to one.
    """

    def __init__(
        self,
        url: str,
        clock: Clock,
        limits: HistoryLimits | None = None,
        *,
        on_connect: OnConnect | None = None,
        term: WriteTerm | None = None,
        cut: ConnectionCut | None = None,
    ) -> None:
        """Prepare for a SQLAlchemy URL; ``on_connect`` may refuse a connection, ``term`` writing.

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        limits, address = limits or HistoryLimits(), address_of(url)
        # One connection that writes, and a few that read at the same time.
        self._writing = open_engine(url, writes=True, on_connect=on_connect, cut=cut)
        self._reading = open_engine(url, writes=False, on_connect=on_connect, cut=cut)
        if term is not None:
            term.guard_engine(self._writing)
        self._limits, self._clock = limits, clock
        # Which blocks and channels there are; changed by the writing thread alone.
        self._ledger = ledger = BlockIndex(self._writing, clock, limits)
        # Keep SQLite's journal short.
        self._checkpoints = Checkpoints(self._writing, self._reading)
        # The one thread that writes; everything that changes samples is a job of its.
        self._writer = Writer(ledger, self._checkpoints, clock, limits.linger_s)
        self._reader = Reader(self._reading, ledger, limits)
        # Two less than the engine has connections: the checkpoint's and that of long reads.
        self._threads = DatabaseThreads(address, READERS - 2, "history-reader")
        # Files and counts, which must not take the charts' threads.
        self._long_reads = LongReads(
            address=address, engine=self._reading, ledger=ledger, reader=self._reader, limits=limits
        )
        # How long each channel is kept.
        self._periods = RetentionPeriods()
        self._tidier = Tidier(
            threads=self._threads,
            reading=self._reading,
            ledger=ledger,
            writer=self._writer,
            periods=self._periods,
            most_bytes=limits.bytes,
            clock=clock,
        )
        # What signals are, and their views for SQL.
        self._sensors = SensorRegistry(self._threads, self._reading, self._writing)
        # What of a site comes from another server, or goes to one.
        self.transfer = SiteTransfer(
            threads=self._threads,
            reading=self._reading,
            writing=self._writing,
            writer=self._writer,
            sensors=self._sensors,
            ledger=ledger,
            tidier=self._tidier,
        )
        # Showing the newest readings, and dropping the oldest.
        self._repeated = RepeatedWork()

    async def create_tables(self) -> None:
        """Make the history's tables where no migration does, for tools and tests."""
        await asyncio.to_thread(metadata.create_all, self._writing, list(HISTORY_TABLES))

    async def open(self) -> None:
        """Read what a former run left in the journal, and begin to write.

        Raises:
            HistoryError: the database cannot be opened, or its tables are missing.

        """
        await self._writer.start()
        await self._sensors.load_sensors()
        self._repeated.start_work(self._limits.show_s, self.write_plain_rows)
        self._repeated.start_work(self._limits.tidy_s, self.apply_retention)

    async def close(self) -> None:
        """Store what waits, and let go of the database."""
        await self._repeated.end_work()
        await self._sensors.close()
        # Last, so that what the others asked it for is stored.
        await self._writer.stop()
        await asyncio.to_thread(self._end_threads)

    async def append_samples(
        self, site: str, boot: str, first: int, *, addresses: Sequence[str], columns: Columns
    ) -> None:
        """Store samples; durable on return.

        Raises:
            HistoryError: nothing of it counts as stored; send it again.

        """
        if len(columns):
            await self._writer.complete_job(Append(site, boot, first, addresses, columns))

    async def record_gap(
        self,
        site: str,
        boot: str,
        first: int,
        last: int,
        *,
        from_us: int,
        to_us: int,
        reason: str,
    ) -> None:
        """Store that samples ``first`` to ``last`` are lost; durable on return.

        Raises:
            HistoryError: it is not stored.

        """
        await self._writer.complete_job(GapJob(site, boot, first, last, from_us, to_us, reason))

    async def stored_below(self, site: str, boot: str) -> int:
        """Give the first sequence number of a boot that is neither stored nor in a gap."""
        return await self._writer.complete_job(Below(site, boot))

    async def describe_site(self, site: Site) -> None:
        """Make a place for every signal of a description at once, and a view named after it.

        Raises:
            HistoryError: the channels' numbers are not stored.

        """
        self._periods.describe_site(site)
        with self._sensors.hold_views():
            await self._writer.complete_job(Describe.every_channel(site))
            await self._sensors.describe_site(site, self._ledger.names.channels)

    async def rename_channels(self, site: str, moves: Mapping[str, str]) -> None:
        """Let channels go on under other addresses; see `History.rename_channels`.

        Raises:
            HistoryError: nothing is renamed.

        """
        if not moves:
            return
        await self._writer.complete_job(Rename(site, moves))
        await self._sensors.rename_channels(site, moves)

    async def write_plain_rows(self) -> None:
        """Write the newest reading of each channel where the views show it.

        Raises:
            HistoryError: it is not stored.

        """
        await self._writer.complete_job(Show())

    async def apply_retention(self) -> int:
        """Drop what is too old, and the oldest if all is too much; give how many blocks went.

        Raises:
            HistoryError: the database cannot be read or written.

        """
        return await self._tidier.drop_old_blocks()

    async def measure_storage(self) -> Storage:
        """Tell how much room the history takes, by channel.

        Raises:
            HistoryError: the database cannot be read.

        """
        now_us = self._clock.wall_ns() // 1000
        return await self._threads.run_query(read_storage, self._reading, now_us)

    @property
    def cached_bytes(self) -> int:
        """Memory that blocks which were read lately take."""
        return self._reader.cached_bytes

    @property
    def trouble(self) -> str:
        """Why nothing can be stored at present; empty while all is well."""
        return self._writer.trouble

    @property
    def most_bytes(self) -> int:
        """What blocks may take (bytes); 0 if there is no limit."""
        return self._limits.bytes

    def kept_us(self, site: str, address: str) -> int:
        """Give how long a channel is kept (µs), scores as long as their signal; 0 is for good."""
        return self._periods.kept_us(site, address)

    def has_channel(self, site: str, address: str) -> bool:
        """Tell whether a channel has ever had a sample."""
        return (site, address) in self._ledger.names.channels

    def kind_of(self, site: str, address: str) -> StoredSensorKind | None:
        """Give what a channel's signal is, or was when it was last described; None: not known."""
        return self._sensors.kind_of(site, address)

    async def wait_for_views(self) -> None:
        """Wait for the SQL views of all that was described so far; see `SensorRegistry`."""
        await self._sensors.wait_for_views()

    async def read_series(
        self,
        site: str,
        addresses: Sequence[str],
        from_us: int,
        to_us: int,
        *,
        width: int,
        steps: Collection[str] = (),
    ) -> list[Series]:
        """Read a window, both ends included, for a chart; see `History.read_series`.

        Raises:
            HistoryError: the database cannot be read.

        """
        if width < 1:
            raise HistoryError(f"a chart of {width} pixels cannot be drawn", "ask for 1 or more")
        window = {"from_us": from_us, "to_us": to_us, "width": width}
        reading = self._reader.read_series
        return await self._threads.run_query(reading, site, addresses, steps=steps, **window)

    async def last_readings(
        self, site: str, addresses: Sequence[str], to_us: int = FARTHEST_US
    ) -> dict[str, tuple[int, float, str]]:
        """Give the newest sample up to ``to_us`` of each address; see `History.last_readings`.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._threads.run_query(self._reader.last_readings, site, addresses, to_us)

    async def read_statistics(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int
    ) -> list[Statistics]:
        """Sum up a window, both ends included, of each address.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._threads.run_query(
            read_statistics,
            self._reading,
            self._ledger,
            self._limits,
            site=site,
            addresses=addresses,
            from_us=from_us,
            to_us=to_us,
        )

    def count_outliers(
        self, site: str, address: str, from_us: int, to_us: int, *, k: float
    ) -> AsyncGenerator[Outliers | None]:
        """Find how many samples are far outside a window's quartiles; see `History.count_outliers`.

        Raises:
            HistoryError: the database cannot be read.

        """
        return self._long_reads.find_outliers(site, address, from_us, to_us, k=k)

    async def list_channels(self, site: str, without: Collection[str] = ()) -> list[StoredChannel]:
        """List every channel of a site that has history, but for those in ``without``.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._threads.run_query(
            stored_channels, self._reading, self._ledger, site, without
        )

    def export_samples(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        *,
        form: FileForm,
        width: int = 0,
    ) -> AsyncIterator[bytes]:
        """Give the bytes of a file with a window of some channels; see `History.export_samples`.

        Raises:
            HistoryBusy: too many exports go on already.
            HistoryError: the database cannot be read.

        """
        return self._long_reads.export_file(site, columns, from_us, to_us, form=form, width=width)

    def _end_threads(self) -> None:
        self._threads.close()
        self._long_reads.close()
        self._checkpoints.close()
        self._reading.dispose()
        self._writing.dispose()
