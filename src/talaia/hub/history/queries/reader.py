"""Windows of the history, read at the width of a chart.

Samples come from memory (what is not in a block yet), from blocks, and, where there are too many
to draw, from rollups. A window is covered by the widest buckets that fit its pixels; its two ends,
which cut through buckets, by narrower ones, and what is left of them by the samples themselves.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import bindparam, select, union_all

from talaia.hub.history.blocks.block import BlockSamples, concatenate_samples, in_order
from talaia.hub.history.blocks.cache import BlockCache
from talaia.hub.history.blocks.columns import columns_of
from talaia.hub.history.blocks.rollup import cover_window, tier_for
from talaia.hub.history.blocks.rows import to_float
from talaia.hub.history.queries.downsample import (
    bucket_extremes,
    bucket_starts,
    distinct_positions,
    edges_of,
    pixel_width,
    steps_of,
)
from talaia.hub.history.queries.listed_blocks import list_together
from talaia.hub.history.queries.newest import read_newest
from talaia.hub.history.queries.series import HistoryGap, Series, empty_series
from talaia.hub.history.queries.window import (
    FARTHEST_US,
    StoredWindow,
    gaps_of,
    kept_bodies,
    outside_rollups,
    overlapping_blocks,
    read_samples,
)
from talaia.hub.history.queries.window_query import windows_of
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray
    from sqlalchemy import CompoundSelect, Connection, Engine

    from talaia.hub.history.blocks.rollup import RollupPiece
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.history.queries.listed_blocks import ListedBlocks
    from talaia.hub.history.writing.block_index import BlockIndex

__all__ = ["Reader"]

_block = tables.block


class Reader:
    """Reads in whatever thread it is called; never waits for a write."""

    def __init__(self, engine: Engine, ledger: BlockIndex, limits: HistoryLimits) -> None:
        """Read by ``engine``, and look into the ledger's tails."""
        # Connections that only read, one for each thread at a time.
        self._engine = engine
        # Where blocks are, and what is in none yet.
        self._ledger = ledger
        self._limits = limits
        # A chart that is moved asks for most of its blocks again.
        self._cache = BlockCache(limits.cached)

    @property
    def cached_bytes(self) -> int:
        """Memory that blocks which were read lately take."""
        return self._cache.bytes

    def read_series(
        self,
        site: str,
        addresses: Sequence[str],
        *,
        from_us: int,
        to_us: int,
        width: int,
        steps: Collection[str] = (),
    ) -> list[Series]:
        """Read a window of several channels; see `HistoryStore.read_series`."""
        windows = windows_of(
            self._ledger, site=site, addresses=addresses, from_us=from_us, to_us=to_us
        )
        asked = list(zip(addresses, windows, strict=True))
        with self._engine.begin() as connection:
            gaps = gaps_of(connection, site, *_clamp_window(from_us, to_us))
            listed = list_together(
                connection,
                [found[0] for _, found in asked if found is not None],
                most=self._most_samples(width),
                most_bodies=self._limits.cached,
                cache=self._cache,
            )
            return [
                empty_series(address, gaps)
                if found is None
                else self._read_channel(
                    connection,
                    address,
                    window=found[0],
                    held=found[1],
                    width=width,
                    gaps=gaps,
                    steps=address in steps,
                    listed=listed,
                )
                for address, found in asked
            ]

    def _most_samples(self, width: int) -> int:
        """Give how many samples of a channel are read as they are; more are read as rollups."""
        return max(self._limits.raw, 2 * width)

    def last_readings(
        self, site: str, addresses: Sequence[str], to_us: int = FARTHEST_US
    ) -> dict[str, tuple[int, float, str]]:
        """Find each channel's newest sample up to ``to_us``; see `HistoryStore.last_readings`."""
        return read_newest(
            self._engine, self._ledger, self._cache, site=site, addresses=addresses, to_us=to_us
        )

    def _read_channel(
        self,
        connection: Connection,
        address: str,
        *,
        window: StoredWindow,
        held: BlockSamples,
        width: int,
        gaps: list[HistoryGap],
        steps: bool,
        listed: ListedBlocks | None,
    ) -> Series:
        tail = in_order(held).between_times(window.from_us, window.to_us)
        span_us = window.to_us - window.from_us + 1
        most = self._most_samples(width)
        blocks: Sequence[Any] | None
        if listed is None:
            blocks = overlapping_blocks(connection, window, most)
        else:
            blocks = listed.rows[window.channel]
            if sum(row.samples for row in blocks) > most:
                blocks = None
        tier = 0
        if blocks is None:
            tier = tier_for(pixel_width(span_us, width) or span_us)
        if tier:
            pixel_us = pixel_width(span_us, width, tier)
            names = _STEPS if steps else _LINES
            rolled = _read_rollups(
                connection,
                cache=self._cache,
                window=window,
                tier=tier,
                pixel_us=pixel_us,
                names=names,
            )
            if not rolled.texts and not tail.texts:
                points = in_order(concatenate_samples([rolled, tail]))
                return _draw_series(
                    address, samples=points, pixel_us=pixel_us, gaps=gaps, steps=steps
                )
        if blocks is None:
            blocks = overlapping_blocks(connection, window, FARTHEST_US) or ()
        samples, unread = read_samples(
            connection,
            blocks,
            window=window,
            most_texts=self._limits.texts,
            cache=self._cache,
            known={} if listed is None else listed.bodies,
        )
        gaps = [*gaps, *unread]
        samples = in_order(concatenate_samples([samples, tail])).between_times(
            window.from_us, window.to_us
        )
        if samples.time_us.size <= 2 * width:
            return Series(address, *samples, not unread, gaps)
        return _draw_series(
            address, samples=samples, pixel_us=pixel_width(span_us, width), gaps=gaps, steps=steps
        )


def _clamp_window(from_us: int, to_us: int) -> tuple[int, int]:
    return max(-FARTHEST_US, int(from_us)), min(FARTHEST_US, int(to_us))


def _draw_series(
    address: str,
    *,
    samples: BlockSamples,
    pixel_us: int,
    gaps: list[HistoryGap],
    steps: bool,
) -> Series:
    starts = bucket_starts(samples.time_us, pixel_us)
    if samples.texts:
        kept = edges_of(starts, samples.time_us.size)
    elif steps:
        kept = steps_of(samples.value, starts)
    else:
        kept = distinct_positions(bucket_extremes(samples.value, starts))
    return Series(address, *samples.select_positions(kept), exact=False, gaps=gaps)


# Of a state, a chart needs what held last, too.
_LINES = ("low_us", "low", "high_us", "high")
_STEPS = (*_LINES, "last_us", "last")


def _read_rollups(
    connection: Connection,
    *,
    cache: BlockCache,
    window: StoredWindow,
    tier: int,
    pixel_us: int,
    names: tuple[str, ...],
) -> BlockSamples:
    """Give points that hold the extremes of each pixel: of rollups, and of what is in none."""
    pieces = cover_window(window.from_us, window.to_us + 1, tier)
    wide = [piece for piece in pieces if piece.width_us]
    parts = []
    if wide:
        parameters = {"channel": window.channel}
        for number, piece in enumerate(wide):
            parameters |= {f"{name}_{number}": value for name, value in piece._asdict().items()}
        columns = columns_of(connection, _rollup_statement(names, len(wide)), parameters)
        if columns:
            parts.append(_join_points(columns[0::2], columns[1::2]))
    inside: list[Any] = []
    cut: list[tuple[int, RollupPiece]] = []
    for number, row in outside_rollups(connection, window, pieces):
        piece = pieces[number]
        one_pixel = not pixel_us or row.first_us // pixel_us == row.last_us // pixel_us
        whole = piece.from_us <= row.first_us and row.last_us < piece.past_us
        if one_pixel and whole and row.numbers:
            inside.append([getattr(row, name) for name in names])
        else:
            cut.append((row.id, piece))
    read = kept_bodies(connection, sorted({number for number, _ in cut}), window.run, cache)
    if inside:
        listed = list(zip(*inside, strict=True))
        values = [to_float(column) for column in listed[1::2]]
        parts.append(_join_points([np.array(times, np.int64) for times in listed[0::2]], values))
    parts += [
        read[number].between_times(piece.from_us, piece.past_us - 1)
        for number, piece in cut
        if number in read
    ]
    return concatenate_samples(parts)


@cache
def _rollup_statement(names: tuple[str, ...], pieces: int) -> CompoundSelect[Any]:
    """Make it once: to make it anew for each chart took as long as to run it."""
    table = tables.rollup
    query = select(*(table.c[name] for name in names))
    return union_all(
        *(
            query.where(
                table.c.channel_id == bindparam("channel"),
                table.c.width_us == bindparam(f"width_us_{number}"),
                table.c.bucket_us >= bindparam(f"from_us_{number}"),
                table.c.bucket_us < bindparam(f"past_us_{number}"),
            )
            for number in range(pieces)
        )
    )


def _join_points(
    times_us: Sequence[NDArray[np.int64]], values: Sequence[NDArray[np.float64]]
) -> BlockSamples:
    return BlockSamples(np.concatenate(times_us), np.concatenate(values), {})
