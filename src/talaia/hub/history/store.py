"""The history as the rest of the hub sees it."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.history.engine import READERS, Checkpoints, address_of, open_engine
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.jobs import Append, Below, Gap
from talaia.hub.history.ledger import Ledger
from talaia.hub.history.limits import Limits
from talaia.hub.history.reader import Reader
from talaia.hub.history.writer import Writer
from talaia.hub.store.history_tables import HISTORY_TABLES
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import ParamSpec, TypeVar

    from talaia.clock import Clock
    from talaia.hub.history.series import Series
    from talaia.wire.columns import Columns

    P = ParamSpec("P")
    R = TypeVar("R")

__all__ = ["HistoryStore"]


class HistoryStore:
    """Samples for good, in one SQL database; nothing of it runs on the event loop.

    One program at a time may have a database's history open. Times are microseconds since the
    epoch (UTC).
    """

    def __init__(self, url: str, clock: Clock, limits: Limits | None = None) -> None:
        """Prepare for a SQLAlchemy URL with a synchronous driver; nothing is opened yet.

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        limits = limits or Limits()
        self._address = address_of(url)
        self._writing = open_engine(url, writes=True)
        self._reading = open_engine(url, writes=False)
        ledger = Ledger(self._writing, clock, limits)
        self._checkpoints = Checkpoints(self._writing, self._reading)
        self._writer = Writer(ledger, self._checkpoints, clock, limits.linger_s)
        self._reader = Reader(self._reading, ledger, limits)
        # One connection less than the engine has: the checkpoint's is one of them.
        self._threads = ThreadPoolExecutor(READERS - 1, "history-reader")

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

    async def close(self) -> None:
        """Store what waits, and let go of the database."""
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
            await self._writer.do(Append(site, boot, first, addresses, columns))

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
        await self._writer.do(Gap(site, boot, first, last, from_us, to_us, reason))

    async def stored_below(self, site: str, boot: str) -> int:
        """Give the first sequence number of a boot that is neither stored nor in a gap."""
        return await self._writer.do(Below(site, boot))

    async def read(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int, width: int
    ) -> list[Series]:
        """Read a window, both ends included, for a chart of so many pixels.

        A series has at most ``2 * width`` points: all samples if they fit (``exact``), otherwise
        the least and the greatest of each pixel, in order of time and at their own times. Pixels
        are anchored to the epoch. Of texts, the first and the last of each pixel are kept. An
        unknown address gives an empty series.

        Raises:
            HistoryError: the database cannot be read.

        """
        if width < 1:
            raise HistoryError(f"a chart of {width} pixels cannot be drawn", "ask for 1 or more")
        return await self._in_thread(self._reader.read, site, addresses, from_us, to_us, width)

    async def last(self, site: str, addresses: Sequence[str]) -> dict[str, tuple[int, float, str]]:
        """Give the newest sample of each address that has one: time (µs), value, text.

        Raises:
            HistoryError: the database cannot be read.

        """
        return await self._in_thread(self._reader.last, site, addresses)

    async def _in_thread(
        self, work: Callable[P, R], *args: P.args, **kwargs: P.kwargs
    ) -> R:  # fmt: skip
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._threads, lambda: work(*args, **kwargs))
        except SQLAlchemyError as error:
            reason = getattr(error, "orig", None) or error
            raise HistoryError(
                f"{self._address} cannot be read: {reason}", "check that it can be reached"
            ) from error

    def _end(self) -> None:
        self._threads.shutdown()
        self._checkpoints.close()
        self._reading.dispose()
        self._writing.dispose()
