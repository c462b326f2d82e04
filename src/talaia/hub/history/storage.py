"""How much room the history takes, signal by signal."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import case, func, select

from talaia.hub.history.forecast import WEEK_US
from talaia.hub.history.writing.retention import BLOCK_BYTES
from talaia.hub.store import history_tables as tables
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection, Engine

__all__ = ["ChannelStorage", "Storage", "join_storage", "read_storage"]

_block = tables.block


class ChannelStorage(NamedTuple):
    """What one channel takes.

    Attributes:
        samples: in blocks; the newest, up to some ten thousand, are not there yet.
        bytes: of its blocks.
        week_bytes: of its blocks of the last seven days.

    """

    site: str
    address: str
    samples: int
    bytes: int
    first_us: int
    last_us: int
    week_bytes: int


class Storage(NamedTuple):
    """What all of it takes, in bytes.

    Attributes:
        kind: which database it is, and its version.
        place: where it is: a file, or a server and a name.
        database_bytes: the whole database, with indices and rollups; 0 if it does not tell.
        spare_bytes: in a SQLite file, free for what comes next; it has not gone to the disk.
        free_bytes: on the disk of a SQLite database; None for a server, whose disk is not ours.
        disk_bytes: that disk's size; 0 for a server.
        blocks_bytes: of all blocks.

    """

    kind: str
    place: str
    database_bytes: int
    spare_bytes: int
    free_bytes: int | None
    disk_bytes: int
    blocks_bytes: int
    channels: list[ChannelStorage]


def read_storage(engine: Engine, now_us: int) -> Storage:
    """Look through the list of blocks; the blocks themselves are not read."""
    channel = tables.channel
    lately = case((_block.c.last_us >= now_us - WEEK_US, BLOCK_BYTES), else_=0)
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
        total, spare = dialect_of(connection).measure_size(connection)
        kind = _database_kind(connection)
    # MariaDB and PostgreSQL give sums as decimals.
    channels = [
        ChannelStorage(site, address, *(int(number) for number in numbers))
        for site, address, *numbers in rows
    ]
    blocks = sum(channel.bytes for channel in channels)
    place = _database_place(engine)
    free, size = _disk_space(engine)
    return Storage(kind, place, total, spare, free, size, blocks, channels)


def join_storage(found: Sequence[Storage]) -> Storage:
    """Give what several databases take together; the first is the one whose disk is told."""
    own = found[0]
    return own._replace(
        place="; ".join(one.place for one in found),
        database_bytes=sum(one.database_bytes for one in found),
        spare_bytes=sum(one.spare_bytes for one in found),
        blocks_bytes=sum(one.blocks_bytes for one in found),
        channels=[channel for one in found for channel in one.channels],
    )


def _database_kind(connection: Connection) -> str:
    name = dialect_of(connection).product_name(connection)
    version = connection.dialect.server_version_info or ()
    # PostgreSQL and SQLite say more than anybody wants to know.
    return f"{name} {'.'.join(str(part) for part in version[:3])}".strip()


def _database_place(engine: Engine) -> str:
    url = engine.url
    if not dialect_of(engine).is_server:
        return str(url.database or "")
    port = f":{url.port}" if url.port else ""
    return f"{url.database} on {url.host or 'this machine'}{port}"


def _disk_space(engine: Engine) -> tuple[int | None, int]:
    file = dialect_of(engine).file_of(engine.url)
    if file is None:
        return None, 0
    usage = shutil.disk_usage(file.parent)
    return usage.free, usage.total
