"""Reads that take seconds or minutes: files of a window, and counts of every sample in it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.history.blocks.block import LastTimes
from talaia.hub.history.database_threads import DatabaseThreads
from talaia.hub.history.errors import HistoryBusy
from talaia.hub.history.queries.arrow_library import has_arrow, require_arrow
from talaia.hub.history.queries.csv_file import write_csv
from talaia.hub.history.queries.export_formats import FileForm
from talaia.hub.history.queries.outliers import find_outliers
from talaia.hub.history.queries.sample_stream import SampleChunk, stream_samples
from talaia.hub.history.queries.wide_table import join_channels
from talaia.hub.history.queries.window import FARTHEST_US

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator, Iterator, Sequence

    from sqlalchemy import Engine

    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.queries.export_formats import ExportColumn
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.reader import Reader
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["LongReads"]

# Exports that may go on at once; each holds a few megabytes.
_EXPORTS = 4


class LongReads:
    """Goes on with long reads a piece at a time, all of them in one thread.

    One thread means that however many of them there are, they hold one connection and one core:
    charts, which people wait for, have the others to themselves.
    """

    def __init__(
        self,
        *,
        address: str,
        engine: Engine,
        ledger: BlockIndex,
        reader: Reader,
        limits: HistoryLimits,
    ) -> None:
        """Read with ``engine``, whose database is shown as ``address``."""
        # Where blocks are looked up, and what tells which of them there are.
        self._engine = engine
        self._ledger = ledger
        # A chart's own points, for an export of what a chart shows.
        self._reader = reader
        self._limits = limits
        # The one thread that all pieces of all long reads take turns in.
        self._thread = DatabaseThreads(address, 1, "history-export")
        # Exports that are under way, whether or not a piece of them is being made.
        self._exports = 0
        # Held by the one count that is under way: of many samples it takes seconds, and two at
        # once would both take twice as long.
        self._one_count = asyncio.Lock()

    async def find_outliers(
        self, site: str, address: str, from_us: int, to_us: int, *, k: float
    ) -> AsyncGenerator[Outliers | None]:
        """See `HistoryStore.count_outliers`."""
        async with self._one_count:
            steps = find_outliers(
                self._engine,
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
                # A step at a time, in turn with exports.
                found = await self._thread.run_query(lambda: next(steps))
                yield found

    async def export_file(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        *,
        form: FileForm,
        width: int,
    ) -> AsyncIterator[bytes]:
        """See `HistoryStore.export_samples`."""
        if self._exports >= _EXPORTS:
            raise HistoryBusy(f"{_EXPORTS} exports go on already", "try again when one has ended")
        self._exports += 1
        try:
            pieces = await self._thread.run_query(
                self._begin_export, site, columns, from_us, to_us, form=form, width=width
            )
            # The next piece is made when the last one was sent: a slow browser holds one piece.
            while piece := await self._thread.run_query(lambda: next(pieces, b"")):
                yield piece
        finally:
            self._exports -= 1

    def _begin_export(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        *,
        form: FileForm,
        width: int,
    ) -> Iterator[bytes]:
        arrow = has_arrow()
        if not arrow and form is not FileForm.CSV:
            require_arrow("Parquet and Arrow files")
        addresses = [column.address for column in columns]
        if width:
            steps = {column.address for column in columns if column.states}
            shown = self._reader.read_series(
                site, addresses, from_us=from_us, to_us=to_us, width=width, steps=steps
            )
            flows = [iter([SampleChunk(series.samples(), FARTHEST_US + 1)]) for series in shown]
        else:
            last = LastTimes()
            flows = [
                stream_samples(
                    self._engine,
                    self._ledger,
                    site=site,
                    address=address,
                    from_us=from_us,
                    to_us=to_us,
                    last=last,
                )
                for address in addresses
            ]
        rows = join_channels(flows)
        if not arrow:
            return write_csv(columns, rows)
        # Arrow takes 40 MB of memory, which a hub that exports nothing need not carry.
        from talaia.hub.history.queries.files import write_file

        return write_file(form, list(columns), rows)

    def close(self) -> None:
        """Wait for the piece that is being made, and end the thread; blocks."""
        self._thread.close()
