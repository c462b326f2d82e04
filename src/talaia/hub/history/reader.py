"""Windows of the history, read at the width of a chart.

Samples come from memory (what is not in a block yet), from blocks, and, where there are too many
to draw, from rollups. A window is covered by the widest buckets that fit its pixels; its two ends,
which cut through buckets, by narrower ones, and what is left of them by the samples themselves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from sqlalchemy import func, literal, or_, select, union_all

from talaia.hub.history.block import EMPTY, Samples, concatenate, decode, in_order
from talaia.hub.history.rollup import Piece, cover, tier_for
from talaia.hub.history.rows import to_float
from talaia.hub.history.series import HistoryGap, Series, empty_series
from talaia.hub.history.thin import edges_of, extremes, groups, pixel_width
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import ColumnElement, Connection, Engine

    from talaia.hub.history.ledger import Ledger
    from talaia.hub.history.limits import Limits

__all__ = ["Reader"]

FARTHEST_US = 2**62
_BODIES_AT_ONCE = 200
_block = tables.block


class _Window(NamedTuple):
    """One channel and one stretch of time, both ends included."""

    channel: int
    from_us: int
    to_us: int
    longest_us: int
    before_block: int

    def blocks(self) -> list[ColumnElement[bool]]:
        """Tell the blocks that overlap it."""
        return [
            _block.c.channel_id == self.channel,
            _block.c.first_us <= self.to_us,
            _block.c.first_us >= max(self.from_us - self.longest_us, -(2**63)),
            _block.c.last_us >= self.from_us,
            _block.c.id < self.before_block,
        ]


class Reader:
    """Reads in whatever thread it is called; never waits for a write."""

    def __init__(self, engine: Engine, ledger: Ledger, limits: Limits) -> None:
        """Read by ``engine``, and look into the ledger's tails."""
        self._engine = engine
        self._ledger = ledger
        self._limits = limits

    def read(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int, width: int
    ) -> list[Series]:
        """Read a window of several channels; see `HistoryStore.read`."""
        # A driver would take numpy's whole numbers for something else.
        from_us = max(-FARTHEST_US, min(FARTHEST_US, int(from_us)))
        to_us = max(-FARTHEST_US, min(FARTHEST_US, int(to_us)))
        # Memory before the database: what is sealed after this look is still in the snapshot, and
        # its blocks stay out of the list. The other way round, samples could be in neither.
        names, tails = self._ledger.names, self._ledger.tails
        asked: list[tuple[str, _Window | None, Samples]] = []
        for address in addresses:
            channel = names.channels.get((site, address))
            if channel is not None and from_us <= to_us:
                samples, before = tails.snapshot(channel)
                window = _Window(channel, from_us, to_us, names.longest_us[channel], before)
                asked.append((address, window, samples))
            else:
                asked.append((address, None, EMPTY))
        with self._engine.begin() as connection:
            gaps = _gaps(connection, site, from_us, to_us)
            return [
                empty_series(address, gaps)
                if window is None
                else self._series(connection, address, window, samples, width, gaps)
                for address, window, samples in asked
            ]

    def last(self, site: str, addresses: Sequence[str]) -> dict[str, tuple[int, float, str]]:
        """Find the newest sample of each channel; see `HistoryStore.last`."""
        names, tails = self._ledger.names, self._ledger.tails
        known = [(a, names.channels[site, a]) for a in addresses if (site, a) in names.channels]
        asked = [(a, channel, tails.snapshot(channel).samples) for a, channel in known]
        found = {}
        with self._engine.begin() as connection:
            for address, channel, samples in asked:
                tail = in_order(samples)
                both = concatenate([_newest_block(connection, channel, tail), tail])
                if not both.time_us.size:
                    continue
                # Of equal times the one that came last; the tail came after the blocks.
                at = both.time_us.size - 1 - int(np.argmax(both.time_us[::-1]))
                text = both.texts.get(at, "")
                found[address] = (int(both.time_us[at]), float(both.value[at]), text)
        return found

    def _series(
        self,
        connection: Connection,
        address: str,
        window: _Window,
        held: Samples,
        width: int,
        gaps: list[HistoryGap],
    ) -> Series:
        tail = in_order(held).between(window.from_us, window.to_us)
        query = select(func.coalesce(func.sum(_block.c.samples), 0)).where(*window.blocks())
        count = int(connection.scalar(query) or 0)
        span_us = window.to_us - window.from_us + 1
        many = count > max(self._limits.raw, 2 * width)
        tier = tier_for(pixel_width(span_us, width) or span_us) if many else 0
        if tier:
            pixel_us = pixel_width(span_us, width, tier)
            rolled = _rolled(connection, window, tier, pixel_us)
            if not rolled.texts and not tail.texts:
                return _drawn(address, in_order(concatenate([rolled, tail])), pixel_us, gaps)
        samples, unread_us = _raw(connection, window, self._limits.texts)
        if unread_us is not None:
            gaps = [*gaps, HistoryGap(window.from_us, unread_us, "too many texts to show at once")]
        samples = in_order(concatenate([samples, tail])).between(window.from_us, window.to_us)
        if samples.time_us.size <= 2 * width:
            return Series(address, *samples, unread_us is None, gaps)
        return _drawn(address, samples, pixel_width(span_us, width), gaps)


def _drawn(address: str, samples: Samples, pixel_us: int, gaps: list[HistoryGap]) -> Series:
    starts = groups(samples.time_us, pixel_us)
    if samples.texts:
        kept = edges_of(starts, samples.time_us.size)
    else:
        kept = np.unique(np.concatenate(extremes(samples.value, starts)))
    return Series(address, *samples.chosen(kept), exact=False, gaps=gaps)


def _raw(connection: Connection, window: _Window, most_texts: int) -> tuple[Samples, int | None]:
    """Read all blocks of a window, and tell up to when they were not read, if there were too many.

    Samples come in the order of their blocks, which is that in which they came.
    """
    query = select(_block.c.id, _block.c.last_us).where(*window.blocks()).order_by(_block.c.last_us)
    blocks = [(row.id, row.last_us) for row in connection.execute(query)]
    read: dict[int, Samples] = {}
    size = 0
    while blocks and (size < most_texts or not any(part.texts for part in read.values())):
        ids = [number for number, _ in blocks[-_BODIES_AT_ONCE:]]
        del blocks[-_BODIES_AT_ONCE:]
        some = _bodies(connection, ids)
        size += sum(part.time_us.size for part in some.values())
        read.update(some)
    unread_us = blocks[-1][1] if blocks else None
    return concatenate([read[number] for number in sorted(read)]), unread_us


def _bodies(connection: Connection, ids: Sequence[int]) -> dict[int, Samples]:
    table = tables.body
    found: dict[int, Samples] = {}
    for at in range(0, len(ids), _BODIES_AT_ONCE):
        query = select(table).where(table.c.block_id.in_(ids[at : at + _BODIES_AT_ONCE]))
        found.update({row[0]: decode(row[1]) for row in connection.execute(query)})
    return found


def _rolled(connection: Connection, window: _Window, tier: int, pixel_us: int) -> Samples:
    """Give points that hold the extremes of each pixel: of rollups, and of what is in none."""
    pieces = cover(window.from_us, window.to_us + 1, tier)
    wide = [piece for piece in pieces if piece.width_us]
    parts = []
    if wide:
        table = tables.rollup
        rows = connection.execute(
            union_all(
                *(
                    select(table.c.low_us, table.c.low, table.c.high_us, table.c.high).where(
                        table.c.channel_id == window.channel,
                        table.c.width_us == piece.width_us,
                        table.c.bucket_us >= piece.from_us,
                        table.c.bucket_us < piece.past_us,
                    )
                    for piece in wide
                )
            )
        ).all()
        parts.append(_points(rows))
    inside: list[Any] = []
    cut: list[tuple[int, Piece]] = []
    for number, row in _outside_rollups(connection, window, pieces):
        piece = pieces[number]
        one_pixel = not pixel_us or row.first_us // pixel_us == row.last_us // pixel_us
        whole = piece.from_us <= row.first_us and row.last_us < piece.past_us
        if one_pixel and whole and row.numbers:
            inside.append((row.low_us, row.low, row.high_us, row.high))
        else:
            cut.append((row.id, piece))
    bodies = _bodies(connection, sorted({number for number, _ in cut}))
    parts.append(_points(inside))
    parts += [bodies[number].between(piece.from_us, piece.past_us - 1) for number, piece in cut]
    return concatenate(parts)


def _outside_rollups(
    connection: Connection, window: _Window, pieces: Sequence[Piece]
) -> list[tuple[int, Any]]:
    """List the blocks that the rollups of a piece do not hold, with the piece's number."""
    columns = [_block.c[name] for name in ("id", "first_us", "last_us", "numbers")]
    columns += [_block.c[name] for name in ("low_us", "low", "high_us", "high")]
    queries = [
        select(literal(number).label("piece"), *columns).where(
            *window._replace(from_us=piece.from_us, to_us=piece.past_us - 1).blocks(),
            or_(_block.c.finest_us == 0, _block.c.finest_us > piece.width_us),
        )
        for number, piece in enumerate(pieces)
    ]
    return [(row.piece, row) for row in connection.execute(union_all(*queries))]


def _points(rows: Sequence[Sequence[Any]]) -> Samples:
    """Make points of rows of least and greatest, each with its time."""
    if not rows:
        return EMPTY
    low_us, low, high_us, high = zip(*rows, strict=True)
    return Samples(np.array(low_us + high_us, np.int64), to_float(low + high), {})


def _newest_block(connection: Connection, channel: int, tail: Samples) -> Samples:
    """Read the block with the newest sample, unless the tail's newest is newer."""
    query = (
        select(_block.c.id, _block.c.last_us)
        .where(_block.c.channel_id == channel)
        .order_by(_block.c.last_us.desc(), _block.c.id.desc())
        .limit(1)
    )
    row = connection.execute(query).first()
    if row is None or (tail.time_us.size and row.last_us <= tail.time_us[-1]):
        return EMPTY
    return _bodies(connection, [row.id])[row.id]


def _gaps(connection: Connection, site: str, from_us: int, to_us: int) -> list[HistoryGap]:
    gap, boot = tables.gap, tables.boot
    query = (
        select(gap.c.from_us, gap.c.to_us, gap.c.reason)
        .join(boot, boot.c.id == gap.c.boot_id)
        .where(boot.c.site == site, gap.c.from_us <= to_us, gap.c.to_us >= from_us)
        .order_by(gap.c.from_us, gap.c.to_us)
    )
    return [HistoryGap(*row) for row in connection.execute(query)]
