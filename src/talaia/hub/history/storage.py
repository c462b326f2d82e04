"""How much room the history takes, signal by signal, and when it will be full."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import case, func, select

from talaia.hub.history.retention import BLOCK_BYTES
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

__all__ = ["ChannelStorage", "Storage", "read_storage"]

DAY_US = 86_400_000_000
_block = tables.block


class ChannelStorage(NamedTuple):
    """What one channel takes.

    Attributes:
        samples: in blocks; the newest few thousand are not there yet.
        bytes: of its blocks.
        day_bytes: of its blocks of the last 24 hours.

    """

    site: str
    address: str
    samples: int
    bytes: int
    first_us: int
    last_us: int
    day_bytes: int


class Storage(NamedTuple):
    """What all of it takes.

    Attributes:
        database_bytes: the whole database, with indices and rollups; 0 if it does not tell.
        free_bytes: on the disk of a SQLite database; None for a server, whose disk is not ours.
        blocks_bytes: of all blocks.
        day_bytes: how much a day the database grows, by the last 24 hours; 0 if it does not.

    """

    database_bytes: int
    free_bytes: int | None
    blocks_bytes: int
    day_bytes: int
    channels: list[ChannelStorage]


def read_storage(engine: Engine, now_us: int) -> Storage:
    """Look through the list of blocks; the blocks themselves are not read."""
    channel = tables.channel
    lately = case((_block.c.last_us >= now_us - DAY_US, BLOCK_BYTES), else_=0)
    query = (
        select(
            channel.c.site,
            channel.c.address,
            func.coalesce(func.sum(_block.c.samples), 0),
            func.coalesce(func.sum(BLOCK_BYTES), 0),
            func.coalesce(func.min(_block.c.first_us), 0),
            func.coalesce(func.max(_block.c.last_us), 0),
            func.coalesce(func.sum(lately), 0),
        )
        .join(_block, _block.c.channel_id == channel.c.id)
        .group_by(channel.c.id, channel.c.site, channel.c.address)
        .order_by(channel.c.site, channel.c.address)
    )
    with engine.begin() as connection:
        rows = connection.execute(query).all()
        total = _database_bytes(connection)
    # MariaDB and PostgreSQL give sums as decimals.
    channels = [
        ChannelStorage(site, address, *(int(number) for number in numbers))
        for site, address, *numbers in rows
    ]
    blocks = sum(each.bytes for each in channels)
    lately_bytes = sum(each.day_bytes for each in channels)
    # Rollups and indices grow with the blocks.
    share = max(1.0, total / blocks) if blocks else 1.0
    return Storage(total, _free(engine), blocks, round(lately_bytes * share), channels)


def _database_bytes(connection: Connection) -> int:
    match connection.dialect.name:
        case "sqlite":
            pages = connection.exec_driver_sql("PRAGMA page_count").scalar() or 0
            spare = connection.exec_driver_sql("PRAGMA freelist_count").scalar() or 0
            size = connection.exec_driver_sql("PRAGMA page_size").scalar() or 0
            return int((pages - spare) * size)
        case "postgresql":
            found = connection.exec_driver_sql("SELECT pg_database_size(current_database())")
        case _:
            found = connection.exec_driver_sql(
                "SELECT SUM(data_length + index_length) FROM information_schema.tables"
                " WHERE table_schema = DATABASE()"
            )
    return int(found.scalar() or 0)


def _free(engine: Engine) -> int | None:
    if engine.dialect.name != "sqlite" or not engine.url.database:
        return None
    return shutil.disk_usage(Path(engine.url.database).parent).free
