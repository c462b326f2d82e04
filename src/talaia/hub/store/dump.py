"""All tables of one database copied into another, whatever kinds of database they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import Column, MetaData, String, Table, create_engine, insert, select, tuple_

# Every table of ours must be known before `metadata` is gone through.
from talaia.hub.store import (
    alarm_tables as _alarm_tables,
    alert_notice_tables as _alert_notice_tables,
    board_tables as _board_tables,
    file_tables as _file_tables,
    history_tables as _history_tables,
    map_tables as _map_tables,
    mission_tables as _mission_tables,
    note_tables as _note_tables,
    observing_tables as _observing_tables,
    robot_log_tables as _robot_log_tables,
    witness_tables as _witness_tables,
)
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.dialects.choice import dialect_of
from talaia.hub.store.history_servers import home_tables as _home_tables
from talaia.hub.store.lead import lead_table as _lead_table
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy import Connection, Engine

__all__ = ["VERSION_TABLE", "copy_tables", "open_plain"]

# Rows at a time: those of blocks are large.
_AT_ONCE = 200
_ = (
    _alarm_tables,
    _alert_notice_tables,
    _board_tables,
    _file_tables,
    _home_tables,
    _history_tables,
    _lead_table,
    _map_tables,
    _note_tables,
    _robot_log_tables,
    _mission_tables,
    _observing_tables,
    _witness_tables,
)
VERSION_TABLE = Table(
    "alembic_version", MetaData(), Column("version_num", String(32), primary_key=True)
)


def open_plain(url: str) -> Engine:
    """Open a database for one long transaction that sees one state of it."""
    found = parse_database_url(url, blocking=True)
    engine = create_engine(found.url, connect_args=found.arguments)
    return dialect_of(engine).open_snapshot(engine)


def copy_tables(source: Connection, target: Connection) -> int:
    """Copy all rows of all tables in place of those that are there; the caller commits.

    Returns:
        How many rows there are.

    """
    tables = [*metadata.sorted_tables, VERSION_TABLE]
    # In reverse, so that rows go before those that they refer to.
    for table in reversed(tables):
        target.execute(table.delete())
    copied = 0
    for table in tables:
        for rows in _read_rows(source, table):
            target.execute(insert(table), rows)
            copied += len(rows)
        dialect_of(target).advance_sequences(target, table)
    return copied


def _read_rows(source: Connection, table: Table) -> Iterator[list[dict[str, Any]]]:
    """Read a table by its key, a few rows at a time: a database need not fit into memory."""
    # By key, not by offset: each page costs the same, however far it is.
    keys = list(table.primary_key)
    query = select(table).order_by(*keys).limit(_AT_ONCE)
    rows = source.execute(query).mappings().all()
    while rows:
        yield [dict(row) for row in rows]
        last = tuple_(*(rows[-1][key.name] for key in keys))
        rows = source.execute(query.where(tuple_(*keys) > last)).mappings().all()
