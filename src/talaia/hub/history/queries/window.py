"""Where in the database the samples of a window are.

What each chart asks is a statement that is made once and given its numbers: to make it anew took as
long as to run it.
"""

from __future__ import annotations

import logging
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import Integer, and_, bindparam, func, literal, or_, select, union_all

from talaia.hub.history.blocks.block import BlockSamples, concatenate_samples, decode_block
from talaia.hub.history.blocks.rows import summary_of
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.queries.series import HistoryGap
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import ColumnElement, CompoundSelect, Connection

    from talaia.hub.history.blocks.cache import BlockCache
    from talaia.hub.history.blocks.rollup import RollupPiece

__all__ = [
    "FARTHEST_US",
    "StoredWindow",
    "blocks_behind",
    "count_in_blocks",
    "gaps_of",
    "kept_bodies",
    "outside_rollups",
    "overlapping_blocks",
    "overlapping_of_channels",
    "read_blocks",
    "read_samples",
]

_LOG = logging.getLogger(__name__)
FARTHEST_US = 2**62
_BODIES_AT_ONCE = 200
# So many of the usual size (4 096) hold more than is read sample by sample.
_FEW = 64
_block = tables.block


class StoredWindow(NamedTuple):
    """One channel and one stretch of time, both ends included.

    ``run`` counts the ledger's loads; `BlockCache` needs it.
    """

    channel: int
    from_us: int
    to_us: int
    longest_us: int
    before_block: int
    run: int

    def overlap_conditions(self) -> list[ColumnElement[bool]]:
        """Tell the blocks that overlap it."""
        return _overlaps(self._bounds())

    def parameters(self, number: int = 0) -> dict[str, int]:
        """Give the values that a statement needs with the `_bound_overlaps` of this number."""
        return {f"{name}_{number}": value for name, value in self._bounds().items()}

    def _bounds(self) -> dict[str, int]:
        return {
            "channel": self.channel,
            "to_us": self.to_us,
            "earliest_us": max(self.from_us - self.longest_us, -(2**63)),
            "from_us": self.from_us,
            "before_block": self.before_block,
        }


def _overlaps(bounds: Mapping[str, Any]) -> list[ColumnElement[bool]]:
    return [
        _block.c.channel_id == bounds["channel"],
        _block.c.first_us <= bounds["to_us"],
        _block.c.first_us >= bounds["earliest_us"],
        _block.c.last_us >= bounds["from_us"],
        _block.c.id < bounds["before_block"],
    ]


def _bound_overlaps(number: int = 0) -> list[ColumnElement[bool]]:
    names = ("channel", "to_us", "earliest_us", "from_us", "before_block")
    return _overlaps({name: bindparam(f"{name}_{number}") for name in names})


_OVERLAPPING = (
    select(_block.c.id, _block.c.first_us, _block.c.last_us, _block.c.samples)
    .where(*_bound_overlaps())
    .order_by(_block.c.first_us, _block.c.id)
)
_FIRST_OVERLAPPING = _OVERLAPPING.limit(_FEW)
_BEHIND = _OVERLAPPING.where(
    or_(
        _block.c.first_us > bindparam("after_us"),
        and_(_block.c.first_us == bindparam("after_us"), _block.c.id > bindparam("after_id")),
    )
).limit(bindparam("most", type_=Integer))


def count_in_blocks(connection: Connection, window: StoredWindow) -> int:
    """Count the samples of the blocks that overlap a window."""
    query = select(func.coalesce(func.sum(_block.c.samples), 0)).where(*window.overlap_conditions())
    return int(connection.scalar(query) or 0)


def overlapping_blocks(
    connection: Connection, window: StoredWindow, most: int
) -> Sequence[Any] | None:
    """List the blocks that overlap a window; None if they hold more than ``most`` samples."""
    # Of a long window the first few tell that there are too many.
    rows = connection.execute(_FIRST_OVERLAPPING, window.parameters()).all()
    if sum(row.samples for row in rows) > most:
        return None
    if len(rows) < _FEW:
        return rows
    if count_in_blocks(connection, window) > most:
        return None
    return connection.execute(_OVERLAPPING, window.parameters()).all()


def blocks_behind(
    connection: Connection, window: StoredWindow, after: tuple[int, int], most: int
) -> Sequence[Any]:
    """List the first blocks that overlap a window and begin behind a time and a number."""
    bounds = {**window.parameters(), "after_us": after[0], "after_id": after[1], "most": most}
    return connection.execute(_BEHIND, bounds).all()


def overlapping_of_channels(
    connection: Connection, windows: Sequence[StoredWindow], most: int | None = None
) -> dict[int, list[Any]] | None:
    """List the blocks that overlap the windows of several channels, by channel, in one question.

    Args:
        connection: to the database.
        windows: of different channels; all are of the same stretch of time.
        most: None is given if there are so many blocks or more in all.

    """
    first = windows[0]
    longest_us = max(window.longest_us for window in windows)
    before = {window.channel: window.before_block for window in windows}
    whole = first._replace(longest_us=longest_us, before_block=max(before.values()))
    # All but the channel's own condition, which stands first.
    query = (
        select(_block.c.channel_id, _block.c.id, _block.c.first_us, _block.c.last_us)
        .add_columns(_block.c.samples)
        .where(_block.c.channel_id.in_(before), *whole.overlap_conditions()[1:])
        .order_by(_block.c.first_us, _block.c.id)
    )
    rows = connection.execute(query.limit(most)).all()
    if most is not None and len(rows) >= most:
        return None
    found: dict[int, list[Any]] = {channel: [] for channel in before}
    for row in rows:
        if row.id < before[row.channel_id]:
            found[row.channel_id].append(row)
    return found


def read_samples(
    connection: Connection,
    found: Sequence[Any],
    *,
    window: StoredWindow,
    most_texts: int,
    cache: BlockCache | None = None,
    known: Mapping[int, BlockSamples] = MappingProxyType({}),
) -> tuple[BlockSamples, list[HistoryGap]]:
    """Read blocks that overlap a window, and tell which stretches could not be read, and why.

    Samples come in the order of their blocks, which is that in which they came. Those of ``known``
    were read already.
    """
    blocks = sorted(found, key=lambda row: row.last_us)
    read: dict[int, BlockSamples] = {}
    unread: list[HistoryGap] = []
    size = 0
    while blocks and (size < most_texts or not any(part.texts for part in read.values())):
        some = blocks[-_BODIES_AT_ONCE:]
        del blocks[-_BODIES_AT_ONCE:]
        missing = [row.id for row in some if row.id not in known]
        read.update({row.id: known[row.id] for row in some if row.id in known})
        if missing:
            read.update(kept_bodies(connection, missing, window.run, cache))
        size = sum(part.time_us.size for part in read.values())
        unread += [
            HistoryGap(row.first_us, row.last_us, "a part of the database is damaged")
            for row in some
            if row.id not in read
        ]
    if blocks:
        why = "too many texts to show at once"
        unread.append(HistoryGap(window.from_us, blocks[-1].last_us, why))
    return concatenate_samples([read[number] for number in sorted(read)]), unread


def kept_bodies(
    connection: Connection, ids: Sequence[int], run: int, cache: BlockCache | None
) -> dict[int, BlockSamples]:
    """Read blocks by their numbers, those that a cache holds from there; see `read_blocks`."""
    if cache is None:
        return read_blocks(connection, ids)
    found = cache.find_blocks(run, ids)
    if len(found) < len(ids):
        read = read_blocks(connection, [number for number in ids if number not in found])
        cache.add_blocks(run, read)
        found.update(read)
    return found


def read_blocks(connection: Connection, ids: Sequence[int]) -> dict[int, BlockSamples]:
    """Read blocks by their numbers; those that are gone or damaged are left out."""
    table = tables.body
    found: dict[int, BlockSamples] = {}
    for at in range(0, len(ids), _BODIES_AT_ONCE):
        query = select(table).where(table.c.block_id.in_(ids[at : at + _BODIES_AT_ONCE]))
        for number, data in connection.execute(query):
            try:
                found[number] = decode_block(data)
            except HistoryError as error:
                _LOG.error("block %d cannot be read and is left out: %s", number, error)
    return found


def outside_rollups(
    connection: Connection, window: StoredWindow, pieces: Sequence[RollupPiece]
) -> list[tuple[int, Any]]:
    """List the blocks that the rollups of a piece do not hold, with the piece's number."""
    parameters: dict[str, int] = {}
    for number, piece in enumerate(pieces):
        part = window._replace(from_us=piece.from_us, to_us=piece.past_us - 1)
        parameters |= part.parameters(number) | {f"width_us_{number}": piece.width_us}
    found = connection.execute(_outside_statement(len(pieces)), parameters)
    return [(row.piece, row) for row in found]


@cache
def _outside_statement(pieces: int) -> CompoundSelect[Any]:
    columns = [_block.c.id, _block.c.first_us, *summary_of(_block)]
    queries = [
        select(literal(number).label("piece"), *columns).where(
            *_bound_overlaps(number),
            or_(_block.c.finest_us == 0, _block.c.finest_us > bindparam(f"width_us_{number}")),
        )
        for number in range(pieces)
    ]
    return union_all(*queries)


_GAPS = (
    select(tables.gap.c.from_us, tables.gap.c.to_us, tables.gap.c.reason)
    .join(tables.boot, tables.boot.c.id == tables.gap.c.boot_id)
    .where(
        tables.boot.c.site == bindparam("site"),
        tables.gap.c.from_us <= bindparam("to_us"),
        tables.gap.c.to_us >= bindparam("from_us"),
    )
    .order_by(tables.gap.c.from_us, tables.gap.c.to_us)
)


def gaps_of(connection: Connection, site: str, from_us: int, to_us: int) -> list[HistoryGap]:
    """List the recorded gaps of a site that touch a window."""
    asked = {"site": site, "from_us": from_us, "to_us": to_us}
    return [HistoryGap(*row) for row in connection.execute(_GAPS, asked)]
