"""What is dropped: blocks that are older than their signal keeps, or the oldest for lack of room.

A block is dropped as a whole, once its last sample is too old, and the rollup rows of its time are
made anew from what is left. Nothing else ever deletes samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import delete, func, select

from talaia.hub.history.blocks.rollup import (
    WIDTHS,
    join_cells,
    merge_cells,
    summarise_samples,
    widen_cells,
)
from talaia.hub.history.blocks.rows import cells_to_rows, rows_to_cells, summary_of
from talaia.hub.history.queries.window import read_blocks
from talaia.hub.history.writing.bulk_writes import insert_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy import Connection, Engine

__all__ = ["BLOCK_BYTES", "Doomed", "delete_blocks", "stored_bytes", "too_much", "too_old"]

# Blocks dropped in one commit: few, so that what comes in does not wait.
AT_ONCE = 64
# A block from before its size was written down: about what its samples take.
_BYTES_A_SAMPLE = 4
_block = tables.block
BLOCK_BYTES = func.coalesce(_block.c.bytes, _block.c.samples * _BYTES_A_SAMPLE)


class Doomed(NamedTuple):
    """A block that is to go."""

    channel: int
    first_us: int
    last_us: int
    id: int
    bytes: int


_columns = (
    _block.c.channel_id,
    _block.c.first_us,
    _block.c.last_us,
    _block.c.id,
    BLOCK_BYTES.label("bytes"),
)


def too_old(engine: Engine, before_us: Mapping[int, int]) -> list[Doomed]:
    """List some blocks that end before what their channel keeps; ``before_us`` by channel."""
    found: list[Doomed] = []
    with engine.begin() as connection:
        for channel, past_us in before_us.items():
            query = (
                select(*_columns)
                .where(_block.c.channel_id == channel, _block.c.last_us < past_us)
                .order_by(_block.c.last_us)
                .limit(AT_ONCE - len(found))
            )
            found += [Doomed(*row) for row in connection.execute(query)]
            if len(found) >= AT_ONCE:
                break
    return found


def too_much(engine: Engine, most_bytes: int) -> list[Doomed]:
    """List some of the oldest blocks of all channels if all together take more than this."""
    over = stored_bytes(engine) - most_bytes
    if over <= 0:
        return []
    with engine.begin() as connection:
        query = select(*_columns).order_by(_block.c.last_us, _block.c.id).limit(AT_ONCE)
        oldest = [Doomed(*row) for row in connection.execute(query)]
    chosen = []
    for block in oldest:
        if over <= 0:
            break
        chosen.append(block)
        over -= block.bytes
    return chosen


def stored_bytes(engine: Engine) -> int:
    """Give what all blocks take (bytes)."""
    with engine.begin() as connection:
        return int(connection.scalar(select(func.coalesce(func.sum(BLOCK_BYTES), 0))) or 0)


def delete_blocks(connection: Connection, doomed: Sequence[Doomed]) -> None:
    """Delete blocks, and bring the rollup rows of their channels in line with what is left."""
    ids = [block.id for block in doomed]
    connection.execute(delete(tables.body).where(tables.body.c.block_id.in_(ids)))
    for channel in {block.channel for block in doomed}:
        mine = [block.id for block in doomed if block.channel == channel]
        connection.execute(
            delete(_block).where(_block.c.channel_id == channel, _block.c.id.in_(mine))
        )
        from_us = min(block.first_us for block in doomed if block.channel == channel)
        past_us = max(block.last_us for block in doomed if block.channel == channel)
        _sum_up_again(connection, channel, from_us, past_us)
        left = connection.scalar(
            select(func.min(_block.c.first_us)).where(_block.c.channel_id == channel)
        )
        until_us = past_us if left is None else min(past_us, left)
        recent = tables.recent
        connection.execute(
            delete(recent).where(recent.c.time_us <= until_us, recent.c.channel_id == channel)
        )


def _sum_up_again(connection: Connection, channel: int, from_us: int, to_us: int) -> None:
    """Make the rollup rows of a stretch of time anew from the blocks that are left.

    From narrow to wide: each width is made of the rows of the one before it, and of the blocks
    that are in no narrower one.
    """
    table = tables.rollup
    finer = None
    for width_us in WIDTHS:
        first = from_us // width_us * width_us
        past = (to_us // width_us + 1) * width_us
        mine = (table.c.channel_id == channel, table.c.bucket_us >= first, table.c.bucket_us < past)
        connection.execute(delete(table).where(*mine, table.c.width_us == width_us))
        parts = []
        if finer is not None:
            query = select(table.c.bucket_us, *summary_of(table))
            rows = connection.execute(query.where(*mine, table.c.width_us == finer)).all()
            if rows:
                parts.append(widen_cells(rows_to_cells(rows), width_us))
        blocks = connection.scalars(
            select(_block.c.id)
            .where(_block.c.channel_id == channel, _block.c.finest_us == width_us)
            .where(_block.c.first_us < past, _block.c.last_us >= first)
            .order_by(_block.c.id)
        ).all()
        for samples in read_blocks(connection, blocks).values():
            part = samples.between_times(first, past - 1)
            parts.append(summarise_samples(part.time_us, part.value, width_us))
        cells = merge_cells(join_cells(parts)) if parts else None
        if cells is not None and cells.bucket_us.size:
            insert_rows(
                connection, table, cells_to_rows(cells, channel_id=channel, width_us=width_us)
            )
        finer = width_us
