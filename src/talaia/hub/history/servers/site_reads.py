"""What of a site stands in a database of histories, as a move reads it; with any connection."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import or_, select

from talaia.hub.history.blocks.rollup import WIDTHS
from talaia.hub.history.writing.writer_jobs import GapJob
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Engine

__all__ = [
    "SiteChannel",
    "StoredBlock",
    "list_blocks",
    "list_channels",
    "read_blocks",
    "read_gaps",
    "read_recent",
    "read_runs",
]

# Readings in one answer.
_ROWS = 5_000
_channel, _block = tables.channel, tables.block


class SiteChannel(NamedTuple):
    """A channel as it stands on its server; ``since_us``: since when it has been known."""

    id: int
    address: str
    since_us: int


class StoredBlock(NamedTuple):
    """Where a block stands."""

    channel: int
    first_us: int
    last_us: int
    id: int


def list_channels(engine: Engine, site: str) -> list[SiteChannel]:
    """List a site's channels, with samples or without."""
    query = (
        select(_channel.c.id, _channel.c.address, _channel.c.since_us)
        .where(_channel.c.site == site)
        .order_by(_channel.c.id)
    )
    with engine.begin() as connection:
        return [SiteChannel(*row) for row in connection.execute(query)]


def list_blocks(engine: Engine, site: str) -> list[StoredBlock]:
    """List a site's blocks, by channel and number."""
    query = (
        select(_block.c.channel_id, _block.c.first_us, _block.c.last_us, _block.c.id)
        .join(_channel, _channel.c.id == _block.c.channel_id)
        .where(_channel.c.site == site)
        .order_by(_block.c.channel_id, _block.c.id)
    )
    with engine.begin() as connection:
        return [StoredBlock(*row) for row in connection.execute(query)]


def read_blocks(
    engine: Engine, blocks: Sequence[StoredBlock]
) -> tuple[list[tuple[dict[str, Any], bytes]], list[dict[str, Any]]]:
    """Read blocks with their bodies, and the rollup rows in which they are."""
    body = tables.body
    ids = [block.id for block in blocks]
    with engine.begin() as connection:
        bodies = {
            row.block_id: bytes(row.body)
            for row in connection.execute(select(body).where(body.c.block_id.in_(ids)))
        }
        rows = []
        rollups: list[dict[str, Any]] = []
        for channel in dict.fromkeys(block.channel for block in blocks):
            mine = [block for block in blocks if block.channel == channel]
            query = select(_block).where(
                _block.c.channel_id == channel,
                _block.c.first_us.in_([block.first_us for block in mine]),
                _block.c.id.in_([block.id for block in mine]),
            )
            found = connection.execute(query.order_by(_block.c.id)).mappings()
            rows += [(dict(row), bodies[row["id"]]) for row in found if row["id"] in bodies]
            table = tables.rollup
            from_us = min(block.first_us for block in mine)
            to_us = max(block.last_us for block in mine)
            # Each row stands for all samples of its time: it is right once all blocks have come.
            overlapping = or_(
                *(
                    (table.c.width_us == width_us)
                    & (table.c.bucket_us >= from_us // width_us * width_us)
                    & (table.c.bucket_us <= to_us)
                    for width_us in WIDTHS
                )
            )
            query = select(table).where(table.c.channel_id == channel, overlapping)
            rollups += [dict(row) for row in connection.execute(query).mappings()]
    return rows, rollups


def read_recent(
    engine: Engine, channels: Sequence[int], after: tuple[int, int]
) -> list[dict[str, Any]]:
    """Read some of the readings that views show, after a time and a channel."""
    table = tables.recent
    time_us, channel = after
    query = (
        select(table)
        .where(
            or_(
                table.c.time_us > time_us,
                (table.c.time_us == time_us) & (table.c.channel_id > channel),
            ),
            table.c.channel_id.in_(channels),
        )
        .order_by(table.c.time_us, table.c.channel_id)
        .limit(_ROWS)
    )
    with engine.begin() as connection:
        return [dict(row) for row in connection.execute(query).mappings()]


def read_gaps(engine: Engine, site: str) -> list[GapJob]:
    """Give what of each boot is lost, as it is written."""
    gap, boot = tables.gap, tables.boot
    query = (
        select(
            boot.c.boot, gap.c.first_seq, gap.c.last_seq, gap.c.from_us, gap.c.to_us, gap.c.reason
        )
        .join(boot, boot.c.id == gap.c.boot_id)
        .where(boot.c.site == site)
    )
    with engine.begin() as connection:
        return [GapJob(site, *row) for row in connection.execute(query)]


def read_runs(engine: Engine, site: str) -> dict[str, list[tuple[int, int]]]:
    """Give what of each boot is stored, by what was written of it; boots without any, too."""
    table, boot = tables.stored_range, tables.boot
    query = (
        select(boot.c.boot, table.c.first_seq, table.c.past_seq)
        .outerjoin(table, table.c.boot_id == boot.c.id)
        .where(boot.c.site == site)
        .order_by(boot.c.id, table.c.first_seq)
    )
    found: dict[str, list[tuple[int, int]]] = {}
    with engine.begin() as connection:
        for name, first, past in connection.execute(query):
            ranges = found.setdefault(name, [])
            if first is not None:
                ranges.append((int(first), int(past)))
    return found
