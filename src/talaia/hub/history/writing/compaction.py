"""From tails to blocks: what is written when a channel has enough samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import and_, bindparam, delete, or_, select, update

from talaia.hub.history.blocks.block import BlockSamples, encode_block, in_order, split_blocks
from talaia.hub.history.blocks.rollup import (
    WIDTHS,
    Cells,
    finest_width,
    join_cells,
    merge_cells,
    summarise_samples,
    widen_cells,
)
from talaia.hub.history.blocks.rows import cells_to_rows, rows_to_cells, summary_of
from talaia.hub.history.writing.bulk_writes import insert_rows, put_rows
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection

__all__ = ["Newest", "Saved", "Sealed", "read_newest", "save_tail", "seal_tail", "write_tails"]

# Of a channel, the last rollup row of each width, each as one cell.
Newest = dict[int, Cells]


class Saved(NamedTuple):
    """A tail as it stands, to be written so that the journal need not keep it."""

    channel: int
    row: int
    body: bytes


class Sealed(NamedTuple):
    """Blocks and rollups of a channel, ready to be written.

    Attributes:
        row: journal rows up to this one are in blocks now.
        first_block: id of the first of the blocks.
        longest_us: length of the channel's longest block, these and the former ones.
        was_saved: the channel has a saved tail, which must go.

    """

    channel: int
    row: int
    first_block: int
    longest_us: int
    was_saved: bool
    blocks: list[dict[str, Any]]
    bodies: list[dict[str, Any]]
    rollups: dict[int, Cells]

    def write_blocks(self, connection: Connection, newest: Newest) -> Newest:
        """Write all of it; the caller commits.

        Args:
            connection: in a transaction.
            newest: the last rollup row of each width.

        Returns:
            The last rollup row of each width, once this is committed.

        """
        insert_rows(connection, tables.block, self.blocks)
        insert_rows(connection, tables.body, self.bodies)
        if self.was_saved:
            table = tables.tail
            connection.execute(delete(table).where(table.c.channel_id == self.channel))
        if self.rollups:
            newest = _add_rollups(connection, self.channel, self.rollups, newest)
        _advance(connection, self.channel, {"saved_row": self.row, "longest_us": self.longest_us})
        return newest

    def count_bytes(self) -> int:
        """Count the bytes of the bodies."""
        return sum(len(row["body"]) for row in self.bodies)


def save_tail(channel: int, row: int, samples: BlockSamples) -> Saved:
    """Compress a tail, in the order in which its samples came."""
    # It is read at the next start at the most, and gives way to a longer one or to a block.
    return Saved(channel, row, encode_block(samples, is_kept=False))


def write_tails(connection: Connection, saves: Sequence[Saved]) -> None:
    """Put tails in place of their channels' former ones; the caller commits."""
    if not saves:
        return
    rows = [{"channel_id": saved.channel, "body": saved.body} for saved in saves]
    put_rows(connection, tables.tail, rows)
    table = tables.channel
    advanced = update(table).where(table.c.id == bindparam("of_channel"))
    connection.execute(
        advanced.values(saved_row=bindparam("to_row")),
        [{"of_channel": saved.channel, "to_row": saved.row} for saved in saves],
    )


def seal_tail(
    channel: int,
    row: int,
    *,
    first_block: int,
    longest_us: int,
    samples: BlockSamples,
    block: int,
    was_saved: bool,
) -> Sealed:
    """Compress a tail into blocks and sum it up."""
    blocks, bodies = [], []
    rollups: dict[int, list[Cells]] = {}
    for number, part in enumerate(split_blocks(in_order(samples), block), first_block):
        # Texts have no least and no greatest; a block with texts is always read itself.
        finest = 0 if part.texts else finest_width(part.time_us)
        whole = summarise_samples(part.time_us, part.value, 0)
        first = int(part.time_us[0])
        longest_us = max(longest_us, int(part.time_us[-1]) - first)
        body = encode_block(part)
        same = {"id": number, "channel_id": channel, "finest_us": finest, "bytes": len(body)}
        for cell in cells_to_rows(whole, **same):
            cell["first_us"] = cell.pop("bucket_us")
            blocks.append(cell)
        bodies.append({"block_id": number, "body": body})
        cells = None
        for width_us in WIDTHS[WIDTHS.index(finest) :] if finest else ():
            # Each width is a multiple of the one before it.
            if cells is None:
                cells = summarise_samples(part.time_us, part.value, width_us)
            else:
                cells = widen_cells(cells, width_us)
            rollups.setdefault(width_us, []).append(cells)
    merged = {
        width_us: merge_cells(join_cells(parts)) if len(parts) > 1 else parts[0]
        for width_us, parts in rollups.items()
    }
    return Sealed(channel, row, first_block, longest_us, was_saved, blocks, bodies, merged)


def read_newest(connection: Connection, channel: int) -> Newest:
    """Read the last rollup row of each width."""
    table = tables.rollup
    query = select(table.c.bucket_us, *summary_of(table)).where(table.c.channel_id == channel)
    found: Newest = {}
    for width_us in WIDTHS:
        of_width = query.where(table.c.width_us == width_us)
        rows = connection.execute(of_width.order_by(table.c.bucket_us.desc()).limit(1)).all()
        if rows:
            found[width_us] = rows_to_cells(rows)
    return found


def _add_rollups(
    connection: Connection, channel: int, rollups: dict[int, Cells], newest: Newest
) -> Newest:
    """Add cells to the rows that are there: the first is, as a rule, and so are late ones."""
    # Rows before the last one are not in memory: samples that came late fall into them.
    late = {
        width_us: cells.bucket_us[cells.bucket_us < newest[width_us].bucket_us[0]].tolist()
        for width_us, cells in rollups.items()
        if width_us in newest
    }
    there = _read_rollups(connection, channel, late) if any(late.values()) else {}
    rows: list[dict[str, Any]] = []
    last = dict(newest)
    for width_us, cells in rollups.items():
        parts = [there[width_us]] if width_us in there else []
        known = newest.get(width_us)
        if known is not None and known.bucket_us[0] in cells.bucket_us:
            parts.append(known)
        both = merge_cells(join_cells([*parts, cells])) if parts else cells
        rows += cells_to_rows(both, channel_id=channel, width_us=width_us)
        if known is None or both.bucket_us[-1] >= known.bucket_us[0]:
            last[width_us] = both.newest_cell()
    put_rows(connection, tables.rollup, rows)
    return last


def _read_rollups(
    connection: Connection, channel: int, wanted: dict[int, list[int]]
) -> dict[int, Cells]:
    table = tables.rollup
    query = select(table.c.width_us, table.c.bucket_us, *summary_of(table)).where(
        table.c.channel_id == channel,
        or_(
            *(
                and_(table.c.width_us == width_us, table.c.bucket_us.in_(buckets))
                for width_us, buckets in wanted.items()
                if buckets
            )
        ),
    )
    there: dict[int, list[Any]] = {}
    for row in connection.execute(query):
        there.setdefault(row[0], []).append(row[1:])
    return {width_us: rows_to_cells(rows) for width_us, rows in there.items()}


def _advance(connection: Connection, channel: int, values: dict[str, int]) -> None:
    table = tables.channel
    connection.execute(update(table).where(table.c.id == channel).values(**values))
