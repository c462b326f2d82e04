"""The history as the rest of the hub sees it.

The file is longer than 300 lines because all that the history promises stands here in one place;
how it is done is in the modules beside it.
"""

from __future__ import annotations

import asyncio
import logging
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.anomaly.runner import signal_of
from talaia.hub.history.engine import READERS, Checkpoints, address_of, open_engine
from talaia.hub.history.errors import HistoryBusy, HistoryError
from talaia.hub.history.forecast import DAY_US
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.queries.channels import stored_channels
from talaia.hub.history.queries.outliers import find_outliers
from talaia.hub.history.queries.reader import Reader
from talaia.hub.history.queries.sample_stream import SampleChunk, flow
from talaia.hub.history.queries.statistics import read_statistics
from talaia.hub.history.queries.wide_table import joined
from talaia.hub.history.queries.window import FARTHEST_US
from talaia.hub.history.sensors.sensor_views import (
    kinds_of,
    read_kinds,
    remember_sensors,
    rename_sensors,
    show_sensors,
)
from talaia.hub.history.sensors.view_sql import SensorView, sensors_of
from talaia.hub.history.storage import read_storage
from talaia.hub.history.writing.block_index import BlockIndex
from talaia.hub.history.writing.retention import too_much, too_old
from talaia.hub.history.writing.writer import Writer
from talaia.hub.history.writing.writer_jobs import (
    Append,
    Below,
    Describe,
    Drop,
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
        Awaitable,
        Callable,
        Collection,
        Iterator,
        Mapping,
        Sequence,
    )
    from typing import ParamSpec, TypeVar

    from talaia.clock import Clock
    from talaia.hub.history.queries.channels import StoredChannel
    from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.series import Series
    from talaia.hub.history.queries.statistics import Statistics
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.history.storage import Storage
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

    P = ParamSpec("P")
    R = TypeVar("R")

__all__ = ["HistoryStore"]

_LOG = logging.getLogger(__name__)
# Exports that may go on at once; each holds a few megabytes.
_EXPORTS = 4
# So long a description waits for the views of its sensors; the rest are made behind it.
_VIEWS_S = 1.0


class HistoryStore:
    """Samples for good, in one SQL database; nothing of it runs on the event loop.

    One program at a time may have a database's history open. Times are microseconds since the
    epoch (UTC).
    """

    def __init__(self, url: str, clock: Clock, limits: HistoryLimits | None = None) -> None:
        """Prepare for a SQLAlchemy URL with a synchronous driver; nothing is opened yet.

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        limits = limits or HistoryLimits()
        self._address = address_of(url)
        self._writing = open_engine(url, writes=True)
        self._reading = open_engine(url, writes=False)
        self._limits = limits
        self._ledger = ledger = BlockIndex(self._writing, clock, limits)
        self._checkpoints = Checkpoints(self._writing, self._reading)
        self._writer = Writer(ledger, self._checkpoints, clock, limits.linger_s)
        self._reader = Reader(self._reading, ledger, limits)
        # Two connections less than the engine has: the checkpoint's and the exports'.
        self._threads = ThreadPoolExecutor(READERS - 2, "history-reader")
        self._exporter = ThreadPoolExecutor(1, "history-export")
        self._exports = 0
        self._clock = clock
        # How long each channel is kept (µs); those that are not here are kept for good.
        self._kept_us: dict[tuple[str, str], int] = {}
        # What each signal is, or was when it was last described.
        self._kinds: dict[tuple[str, str], StoredSensorKind] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._showing: set[asyncio.Task[None]] = set()
        self._one_site = asyncio.Lock()
        self._one_count = asyncio.Lock()
        self._closing = False

    async def create_tables(self) -> None:
        """Make the history's tables where no migration does, for tools and tests."""
        tables = list(HISTORY_TABLES)
        await asyncio.to_thread(metadata.create_all, self._writing, tables)

    async def open(self) -> None:
        """Read what a former run left in the journal, and begin to write.

        Raises:
            HistoryError: the database cannot be opened, or its tables are missing.

        """
        await self._writer.start()
        self._kinds = await self._in_thread(read_kinds, self._reading)
        for every_s, work in ((self._limits.show_s, self.show), (self._limits.tidy_s, self.tidy)):
            if every_s:
                self._tasks.append(asyncio.create_task(_every(every_s, work)))

    async def close(self) -> None:
        """Store what waits, and let go of the database."""
        for task in self._tasks:
            task.cancel()
        self._closing = True
        await asyncio.gather(*self._tasks, *self._showing, return_exceptions=True)
        await self._writer.stop()
        await asyncio.to_thread(self._end)

    async def append(
        self, site: str, boot: str, first: int, addresses: Sequence[str], columns: Columns
    ) -> None:
        """Store samples; durable on return. Those that are there already change nothing.

        Args:
            site: whose they are.
            boot: the gateway's run.
            first: sequence number of the first; the others follow without a hole.
            addresses: what ``columns.channel`` indexes.
            columns: the samples, in any order of time; not to be changed afterwards.

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
        from_us: int,
        to_us: int,
        reason: str,
    ) -> None:
        """Store that samples ``first`` to ``last`` are lost; durable on return.

        With ``last = first - 1`` it is a gap in time of which no sequence numbers are known.

        Raises:
            HistoryError: it is not stored.

        """
        await self._writer.complete_job(GapJob(site, boot, first, last, from_us, to_us, reason))

    async def stored_below(self, site: str, boot: str) -> int:
        """Give the first sequence number of a boot that is neither stored nor in a gap."""
        return await self._writer.complete_job(Below(site, boot))

    async def describe(self, site: Site) -> None:
        """Make a place for every signal of a description at once, and a view named after it.

        A database that refuses views (it takes a right of its own on a server) keeps the samples
        all the same; that is logged.

        Raises:
            HistoryError: the channels' numbers are not stored.

        """
        channels = [channel.address for channel in site.channels()]
        await self._writer.complete_job(Describe(site.site, channels))
        self._keep(site)
        sensors = sensors_of(site, self._ledger.names.channels)
        missing = await self._in_thread(remember_sensors, self._writing, site.site, sensors)
        for address, kind in kinds_of(sensors).items():
            self._kinds[site.site, address] = kind
        task = asyncio.create_task(self._show_sensors(site.site, missing))
        self._showing.add(task)
        task.add_done_callback(self._showing.discard)
        # The views of many sensors take a while: the gateway's samples do not wait for them.
        await asyncio.wait({task}, timeout=_VIEWS_S)

    async def rename(self, site: str, moves: Mapping[str, str]) -> None:
        """Let channels go on under other addresses, with all their history.

        Args:
            site: whose they are.
            moves: the new addresses by the former ones. Where the new one has a history of its
                own, both stay as they are.

        Raises:
            HistoryError: nothing is renamed.

        """
        if not moves:
            return
        await self._writer.complete_job(Rename(site, moves))
        signals = {old.partition(".")[0]: new.partition(".")[0] for old, new in moves.items()}
        await self._in_thread(rename_sensors, self._writing, site, signals)
        for old, new in signals.items():
            if (kind := self._kinds.pop((site, old), None)) is not None:
                self._kinds.setdefault((site, new), kind)

    async def _show_sensors(self, site: str, sensors: list[SensorView]) -> None:
        async with self._one_site:
            try:
                await self._in_thread(
                    show_sensors, self._writing, site, sensors, lambda: self._closing
                )
            except HistoryError as error:
                _LOG.warning("the sensors of %s have no views for SQL: %s", site, error)

    async def show(self) -> None:
        """Write the newest reading of each channel where the views show it.

        Raises:
            HistoryError: it is not stored.

        """
        await self._writer.complete_job(Show())

    async def tidy(self) -> int:
        """Drop what is older than its signal keeps, and the oldest if all is too much.

        Returns:
            How many blocks were dropped.

        Raises:
            HistoryError: the database cannot be read or written.

        """
        now_us = self._clock.wall_ns() // 1000
        channels = self._ledger.names.channels
        before_us = {
            channel: now_us - kept_us
            for (site, address), channel in channels.items()
            if (kept_us := self.kept_us(site, address))
        }
        dropped = 0
        while doomed := await self._in_thread(too_old, self._reading, before_us):
            await self._writer.complete_job(Drop(doomed))
            dropped += len(doomed)
        while self._limits.bytes and (
            doomed := await self._in_thread(too_much, self._reading, self._limits.bytes)
        ):
            await self._writer.complete_job(Drop(doomed))
            dropped += len(doomed)
        if dropped:
            _LOG.info("%d blocks of the history were too old or too much, and are dropped", dropped)
        return dropped

    async def storage(self) -> Storage:
        """Tell how much room the history takes, by channel.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._in_thread(read_storage, self._reading, self._clock.wall_ns() // 1000)

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
        return self._kept_us.get((site, signal_of(address)), 0)

    def knows(self, site: str, address: str) -> bool:
        """Tell whether a channel has ever had a sample."""
        return (site, address) in self._ledger.names.channels

    def kind_of(self, site: str, address: str) -> StoredSensorKind | None:
        """Give what a channel's signal is, or was when it was last described; None: not known."""
        return self._kinds.get((site, address.partition(".")[0]))

    async def read(
        self,
        site: str,
        addresses: Sequence[str],
        from_us: int,
        to_us: int,
        width: int,
        steps: Collection[str] = (),
    ) -> list[Series]:
        """Read a window, both ends included, for a chart of so many pixels.

        A series has at most ``2 * width`` points: all samples if they fit (``exact``), otherwise
        the least and the greatest of each pixel, in order of time and at their own times. Pixels
        are anchored to the epoch. Of texts, the first and the last of each pixel are kept; of
        ``steps`` (addresses of states), the last and one that differs from it. An unknown address
        gives an empty series.

        Raises:
            HistoryError: the database cannot be read.

        """
        if width < 1:
            raise HistoryError(f"a chart of {width} pixels cannot be drawn", "ask for 1 or more")
        reading = self._reader.read
        return await self._in_thread(
            reading, site, addresses, from_us=from_us, to_us=to_us, width=width, steps=steps
        )

    async def last(
        self, site: str, addresses: Sequence[str], to_us: int = FARTHEST_US
    ) -> dict[str, tuple[int, float, str]]:
        """Give the newest sample up to ``to_us`` of each address that has one.

        It is a time (µs), a value (NaN for a text), and a text.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._in_thread(self._reader.last, site, addresses, to_us)

    async def statistics(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int
    ) -> list[Statistics]:
        """Sum up a window, both ends included, of each address.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._in_thread(
            read_statistics,
            self._reading,
            self._ledger,
            self._limits,
            site=site,
            addresses=addresses,
            from_us=from_us,
            to_us=to_us,
        )

    async def outliers(
        self, site: str, address: str, from_us: int, to_us: int, k: float
    ) -> AsyncGenerator[Outliers | None]:
        """Find how many samples of a window, both ends included, are far outside its quartiles.

        It gives None again and again, so that who asks may stop, and what was found at the end.
        One channel after the other is looked at, whoever asks: of many samples it takes seconds.

        Raises:
            HistoryError: the database cannot be read.

        """
        async with self._one_count:
            steps = find_outliers(
                self._reading,
                self._ledger,
                site=site,
                address=address,
                from_us=from_us,
                to_us=to_us,
                k=k,
                most=self._limits.counted,
            )
            found = None
            while found is None:
                # Behind the charts, in turn with exports.
                found = await self._run(self._exporter, lambda: next(steps))
                yield found

    async def channels(self, site: str, without: Collection[str] = ()) -> list[StoredChannel]:
        """List every channel of a site that has history, those of former descriptions too.

        Those that are named in ``without`` are left out, and cost nothing.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._in_thread(stored_channels, self._reading, self._ledger, site, without)

    async def export(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        form: FileForm,
        width: int = 0,
    ) -> AsyncIterator[bytes]:
        """Give the bytes of a file with a window, both ends included, of some channels.

        With a ``width``, it holds what a chart of so many pixels shows, otherwise every sample.
        What is held at once does not grow with the window.

        Raises:
            HistoryBusy: too many exports go on already.
            HistoryError: the database cannot be read.

        """
        if self._exports >= _EXPORTS:
            raise HistoryBusy(f"{_EXPORTS} exports go on already", "try again when one has ended")
        self._exports += 1
        try:
            pieces = await self._run(
                self._exporter,
                lambda: self._begin_export(site, columns, from_us, to_us, form, width),
            )
            while piece := await self._run(self._exporter, lambda: next(pieces, b"")):
                yield piece
        finally:
            self._exports -= 1

    def _begin_export(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        form: FileForm,
        width: int,
    ) -> Iterator[bytes]:
        # Arrow takes 40 MB of memory, which a hub that exports nothing need not carry.
        from talaia.hub.history.queries.files import written

        addresses = [column.address for column in columns]
        if width:
            steps = {column.address for column in columns if column.states}
            shown = self._reader.read(
                site, addresses, from_us=from_us, to_us=to_us, width=width, steps=steps
            )
            flows = [iter([SampleChunk(series.samples(), FARTHEST_US + 1)]) for series in shown]
        else:
            flows = [
                flow(
                    self._reading,
                    self._ledger,
                    site=site,
                    address=address,
                    from_us=from_us,
                    to_us=to_us,
                )
                for address in addresses
            ]
        return written(form, list(columns), joined(flows))

    def _keep(self, site: Site) -> None:
        """Remember how long the signals are kept; what is not described any more is kept."""
        for key in [key for key in self._kept_us if key[0] == site.site]:
            del self._kept_us[key]
        for channel in site.channels():
            days = site.devices[channel.device].signals[channel.signal].keep
            if days > 0:
                self._kept_us[site.site, channel.address] = round(days * DAY_US)

    async def _in_thread(
        self,
        work: Callable[P, R],
        *args: P.args,
        **kwargs: P.kwargs,
    ) -> R:
        return await self._run(self._threads, lambda: work(*args, **kwargs))

    async def _run(self, threads: ThreadPoolExecutor, work: Callable[[], R]) -> R:
        try:
            return await asyncio.get_running_loop().run_in_executor(threads, work)
        except SQLAlchemyError as error:
            reason = getattr(error, "orig", None) or error
            raise HistoryError(
                f"{self._address} cannot be read: {reason}", "check that it can be reached"
            ) from error

    def _end(self) -> None:
        self._threads.shutdown()
        self._exporter.shutdown()
        self._checkpoints.close()
        self._reading.dispose()
        self._writing.dispose()


async def _every(period_s: float, work: Callable[[], Awaitable[object]]) -> None:
    while True:
        await asyncio.sleep(period_s)
        # The writing thread logs what goes wrong, once; the next time comes anyway.
        with suppress(HistoryError):
            await work()
