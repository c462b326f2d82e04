"""What a window of a channel amounts to: how many, least, greatest, mean, spread, first, last."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from sqlalchemy import select, union_all

from talaia.hub.history.blocks.block import BlockSamples, concatenate_samples, in_order
from talaia.hub.history.blocks.rollup import (
    WIDTHS,
    Cells,
    cover_window,
    join_cells,
    merge_cells,
    summarise_samples,
)
from talaia.hub.history.blocks.rows import rows_to_cells, summary_of
from talaia.hub.history.queries.window import (
    gaps_of,
    outside_rollups,
    overlapping_blocks,
    read_blocks,
    read_samples,
)
from talaia.hub.history.queries.window_query import windows_of
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection, Engine

    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.queries.series import HistoryGap
    from talaia.hub.history.queries.window import StoredWindow
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["SampleReading", "Statistics", "covered_us", "read_statistics"]

_block = tables.block


class SampleReading(NamedTuple):
    """One sample: microseconds since the epoch (UTC), value (NaN for a text), text."""

    time_us: int
    value: float
    text: str


class Statistics(NamedTuple):
    """A channel over a window, both ends included.

    Attributes:
        samples: how many there are.
        numbers: how many of them were finite numbers; mean and deviation are of these.
        low: the first least reading; None when there are no numbers.
        high: the first greatest reading.
        mean: NaN when there are no finite numbers.
        deviation: standard deviation (of all of them, not of a sample of them); NaN when it is
            not known, which is so where rollups were written before they held it.
        first: the earliest reading.
        last: the latest reading.
        gap_us: how much of the window lies in recorded gaps.

    """

    address: str
    samples: int
    numbers: int
    low: SampleReading | None
    high: SampleReading | None
    mean: float
    deviation: float
    first: SampleReading | None
    last: SampleReading | None
    gap_us: int


def read_statistics(
    engine: Engine,
    ledger: BlockIndex,
    limits: HistoryLimits,
    *,
    site: str,
    addresses: Sequence[str],
    from_us: int,
    to_us: int,
) -> list[Statistics]:
    """Sum up a window of several channels; see `HistoryStore.read_statistics`."""
    windows = windows_of(ledger, site=site, addresses=addresses, from_us=from_us, to_us=to_us)
    asked = list(zip(addresses, windows, strict=True))
    with engine.begin() as connection:
        # Gaps are of the site (its link), not of a channel: once for all that were asked.
        gap_us = covered_us(gaps_of(connection, site, from_us, to_us), from_us, to_us)
        return [
            _of_nothing(address, gap_us)
            if found is None
            else _of_window(
                connection,
                address,
                window=found[0],
                held=found[1],
                most=limits.raw,
                gap_us=gap_us,
            )
            for address, found in asked
        ]


def covered_us(gaps: Sequence[HistoryGap], from_us: int, to_us: int) -> int:
    """Give how much of a window gaps cover; what several of them cover counts once."""
    covered, at = 0, from_us
    # Two gateways' gaps, or one that was written twice, may overlap.
    for gap in sorted(gaps):
        covered += max(0, min(gap.to_us, to_us) - max(gap.from_us, at))
        at = max(at, gap.to_us)
    return covered


def _of_nothing(address: str, gap_us: int) -> Statistics:
    return Statistics(address, 0, 0, None, None, math.nan, math.nan, None, None, gap_us)


def _of_window(
    connection: Connection,
    address: str,
    *,
    window: StoredWindow,
    held: BlockSamples,
    most: int,
    gap_us: int,
) -> Statistics:
    # What is not in a block yet, since blocks are written when they are full or old.
    tail = in_order(held).between_times(window.from_us, window.to_us)
    blocks = overlapping_blocks(connection, window, most)
    # Few samples: exact, from the samples. Many: from rollups where these cover whole cells, and
    # from blocks at both ends.
    if blocks is not None:
        samples, _ = read_samples(connection, blocks, window=window, most_texts=most)
        samples = in_order(concatenate_samples([samples, tail])).between_times(
            window.from_us, window.to_us
        )
        cells = summarise_samples(samples.time_us, samples.value, 0)
        ends = samples
    else:
        parts = [_read_cells(connection, window), summarise_samples(tail.time_us, tail.value, 0)]
        joined = join_cells(parts)
        cells = merge_cells(joined._replace(bucket_us=np.zeros_like(joined.bucket_us)))
        ends = _end_samples(connection, window, tail)
    if not cells.samples.size:
        return _of_nothing(address, gap_us)
    numbers = int(cells.numbers[0])
    # NaN where there were only texts.
    low, high = float(cells.low[0]), float(cells.high[0])
    return Statistics(
        address,
        samples=int(cells.samples[0]),
        numbers=numbers,
        low=None if math.isnan(low) else SampleReading(int(cells.low_us[0]), low, ""),
        high=None if math.isnan(high) else SampleReading(int(cells.high_us[0]), high, ""),
        mean=float(cells.total[0]) / numbers if numbers else math.nan,
        deviation=math.sqrt(float(cells.squares[0]) / numbers) if numbers else math.nan,
        first=_reading_at(ends, 0),
        last=_reading_at(ends, ends.time_us.size - 1),
        gap_us=gap_us,
    )


def _reading_at(samples: BlockSamples, at: int) -> SampleReading | None:
    if not samples.time_us.size:
        return None
    return SampleReading(
        int(samples.time_us[at]), float(samples.value[at]), samples.texts.get(at, "")
    )


def _read_cells(connection: Connection, window: StoredWindow) -> Cells:
    """Give cells that together hold what the database holds of a window."""
    pieces = cover_window(window.from_us, window.to_us + 1, WIDTHS[-1])
    table = tables.rollup
    query = select(table.c.bucket_us, *summary_of(table))
    rolled = [
        query.where(
            table.c.channel_id == window.channel,
            table.c.width_us == piece.width_us,
            table.c.bucket_us >= piece.from_us,
            table.c.bucket_us < piece.past_us,
        )
        for piece in pieces
        if piece.width_us
    ]
    rows = connection.execute(union_all(*rolled)).all() if rolled else []
    parts = [rows_to_cells(rows)]
    whole, cut = [], []
    for number, row in outside_rollups(connection, window, pieces):
        piece = pieces[number]
        # A block that lies in the piece has its own sums; only one that is cut must be read.
        if piece.from_us <= row.first_us and row.last_us < piece.past_us:
            whole.append(row[2:])
        else:
            cut.append((row.id, piece))
    parts.append(rows_to_cells(whole))
    read = read_blocks(connection, sorted({number for number, _ in cut}))
    for number, piece in cut:
        if number in read:
            part = read[number].between_times(piece.from_us, piece.past_us - 1)
            parts.append(summarise_samples(part.time_us, part.value, 0))
    return join_cells(parts)


def _end_samples(connection: Connection, window: StoredWindow, tail: BlockSamples) -> BlockSamples:
    """Give samples of a window of which the first and the last are the window's."""
    # Blocks that came over a bad link overlap, so the first sample need not be in the first block
    # by number, nor the last in the last.
    edge = (
        select(_block.c.id)
        .where(*window.overlap_conditions(), _block.c.first_us >= window.from_us)
        .order_by(_block.c.first_us, _block.c.id)
        .limit(1)
    )
    other = (
        select(_block.c.id)
        .where(*window.overlap_conditions(), _block.c.last_us <= window.to_us)
        .order_by(_block.c.last_us.desc(), _block.c.id.desc())
        .limit(1)
    )
    ids = {number for query in (edge, other) for number in connection.scalars(query)}
    # Besides, the blocks that an end of the window cuts through.
    for at_us in (window.from_us, window.to_us):
        cut = window._replace(from_us=at_us, to_us=at_us)
        ids |= set(connection.scalars(select(_block.c.id).where(*cut.overlap_conditions())))
    read = read_blocks(connection, sorted(ids))
    parts = [read[number] for number in sorted(read)]
    return in_order(concatenate_samples([*parts, tail])).between_times(window.from_us, window.to_us)
