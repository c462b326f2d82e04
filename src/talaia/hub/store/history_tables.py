"""The history's tables.

Times are microseconds since the epoch (UTC). Rollup rows and the summary of each block can be read
by anyone with SQL; in them, NaN is NULL, and an infinity is the greatest or least finite number,
because MariaDB keeps neither. The samples themselves, inside the bodies, keep every bit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    BigInteger,
    Column,
    Double,
    Index,
    Integer,
    String,
    Table,
    UniqueConstraint,
    event,
)

from talaia.hub.store.dialects.choice import dialect_of
from talaia.hub.store.dialects.column_types import (
    EXACT_NAME,
    LONG_BYTES,
    ROW_ID,
    UNICODE_TEXT,
)
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from sqlalchemy import Connection

__all__ = [
    "HISTORY_TABLES",
    "block",
    "body",
    "boot",
    "catalogue",
    "channel",
    "copied",
    "counter",
    "gap",
    "hot",
    "recent",
    "rollup",
    "sensor",
    "stored_range",
    "tail",
]


def _key_column(name: str, kind: Any = ROW_ID) -> Column[Any]:  # noqa: ANN401 - any column type
    # The program numbers rows itself: it writes many at once and wants no answer to each.
    return Column(name, kind, primary_key=True, autoincrement=False)


def _summary_columns() -> tuple[Column[Any], ...]:
    return (
        Column("samples", BigInteger, nullable=False),
        Column("numbers", BigInteger, nullable=False),
        Column("total", Double, nullable=False),
        Column("squares", Double),
        Column("low", Double),
        Column("low_us", BigInteger, nullable=False),
        Column("high", Double),
        Column("high_us", BigInteger, nullable=False),
        Column("last", Double),
        Column("last_us", BigInteger, nullable=False),
    )


# A channel keeps its row, and so its history, when it is renamed or removed in the description.
# `saved_row`: journal rows up to this one need not be read again for this channel.
# `longest_us`: no block of this channel is longer, so a window knows how far back to look.
channel = Table(
    "history_channel",
    metadata,
    _key_column("id"),
    Column("site", EXACT_NAME, nullable=False),
    Column("address", EXACT_NAME, nullable=False),
    Column("since_us", BigInteger, nullable=False),
    Column("saved_row", BigInteger, nullable=False),
    Column("longest_us", BigInteger, nullable=False),
    UniqueConstraint("site", "address"),
)

boot = Table(
    "history_boot",
    metadata,
    _key_column("id"),
    Column("site", EXACT_NAME, nullable=False),
    Column("boot", EXACT_NAME, nullable=False),
    UniqueConstraint("site", "boot"),
)

# Sequence numbers that are stored; those of rows still in the journal may be missing here.
stored_range = Table(
    "history_range",
    metadata,
    _key_column("boot_id"),
    _key_column("first_seq", BigInteger()),
    Column("past_seq", BigInteger, nullable=False),
)

gap = Table(
    "history_gap",
    metadata,
    _key_column("boot_id"),
    _key_column("first_seq", BigInteger()),
    _key_column("last_seq", BigInteger()),
    _key_column("from_us", BigInteger()),
    Column("to_us", BigInteger, nullable=False),
    Column("reason", UNICODE_TEXT, nullable=False),
)

# A list of channels that batches index: channel ids as u32, little-endian.
catalogue = Table(
    "history_catalogue",
    metadata,
    _key_column("id"),
    Column("channels", LONG_BYTES, nullable=False),
)

# The journal: every batch as it came, until all its samples are in blocks or tails.
# It is written and emptied all day, so PostgreSQL must not wait for a fifth of it to be dead.
hot = Table(
    "history_hot",
    metadata,
    _key_column("id"),
    Column("boot_id", ROW_ID, nullable=False),
    Column("catalogue_id", ROW_ID, nullable=False),
    Column("first_seq", BigInteger, nullable=False),
    Column("samples", Integer, nullable=False),
    Column("body", LONG_BYTES, nullable=False),
    postgresql_with={
        "autovacuum_vacuum_scale_factor": "0.0",
        "autovacuum_vacuum_threshold": "2000",
    },
)

# Samples of a slow channel that are not yet a block, so that the journal need not keep its rows.
tail = Table(
    "history_tail",
    metadata,
    _key_column("channel_id"),
    Column("body", LONG_BYTES, nullable=False),
)

# What is in a block. Bodies stand aside, so that looking for blocks reads few pages.
# `finest_us`: the block is in the rollups of this width and all wider ones; 0: in none.
# `bytes`: how long its body is; NULL in rows that were written before there was such a column.
block = Table(
    "history_block",
    metadata,
    _key_column("channel_id"),
    _key_column("first_us", BigInteger()),
    _key_column("id"),
    Column("finest_us", BigInteger, nullable=False),
    Column("bytes", Integer),
    *_summary_columns(),
    sqlite_with_rowid=False,
)
Index("ix_history_block_last_us", block.c.channel_id, block.c.last_us)

body = Table(
    "history_body",
    metadata,
    _key_column("block_id"),
    Column("body", LONG_BYTES, nullable=False),
)

rollup = Table(
    "history_rollup",
    metadata,
    _key_column("channel_id"),
    _key_column("width_us", BigInteger()),
    _key_column("bucket_us", BigInteger()),
    *_summary_columns(),
    sqlite_with_rowid=False,
)

# A reading of each channel every few seconds. Times come first, so that what is written together
# stands together.
recent = Table(
    "history_recent",
    metadata,
    _key_column("time_us", BigInteger()),
    _key_column("channel_id"),
    Column("value", Double),
    Column("text", UNICODE_TEXT),
    sqlite_with_rowid=False,
)

# What each sensor was when it was last described, and which view shows it. `made_of` tells when
# the view has to be made anew; it is empty while there is none. `states` is a JSON list; `type`,
# `states` and `decimals` are NULL in rows that were written before there were such columns.
sensor = Table(
    "history_sensor",
    metadata,
    _key_column("site", EXACT_NAME),
    _key_column("address", EXACT_NAME),
    Column("view_name", String(63), nullable=False),
    Column("shown_name", EXACT_NAME, nullable=False),
    Column("unit", EXACT_NAME, nullable=False),
    Column("made_of", String(32), nullable=False),
    Column("type", String(20)),
    Column("states", UNICODE_TEXT),
    Column("decimals", Integer),
    UniqueConstraint("view_name"),
)

# The number that the next one of a kind gets, where rows that had the last ones were deleted.
counter = Table(
    "history_counter",
    metadata,
    Column("name", String(20), primary_key=True),
    Column("next_number", BigInteger, nullable=False),
)

# What of a site that moves here has come: of each channel, by its number where it comes from, the
# blocks up to this one. `move` tells one move from another.
copied = Table(
    "history_copied",
    metadata,
    _key_column("site", EXACT_NAME),
    _key_column("source_channel"),
    Column("address", EXACT_NAME, nullable=False),
    Column("move", String(32), nullable=False),
    Column("block_id", BigInteger, nullable=False),
)

HISTORY_TABLES = (
    counter,
    copied,
    channel,
    boot,
    stored_range,
    gap,
    catalogue,
    hot,
    tail,
    block,
    body,
    rollup,
    recent,
    sensor,
)


def _store_uncompressed(table: Table, connection: Connection, **_: object) -> None:
    # Bodies are compressed already.
    dialect_of(connection).store_uncompressed(connection, table)


for _table in (hot, tail, body):
    event.listen(_table, "after_create", _store_uncompressed)
