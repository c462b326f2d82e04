"""Many rows in one statement, new ones or in place of those that are there, on each database.

A statement for each row would be most of the time on a server: every one waits for an answer.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from sqlalchemy import BigInteger, Double, Insert, Integer, LargeBinary, insert, text
from sqlalchemy.dialects import mysql, postgresql, sqlite

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Column, Connection, Table, TextClause

__all__ = ["insert_rows", "put_rows"]


def insert_rows(connection: Connection, table: Table, rows: Sequence[dict[str, Any]]) -> None:
    """Insert rows; all of them have the same keys."""
    _write(connection, table, rows, in_place=False)


def put_rows(connection: Connection, table: Table, rows: Sequence[dict[str, Any]]) -> None:
    """Insert rows in place of those with the same primary key."""
    _write(connection, table, rows, in_place=True)


def _write(
    connection: Connection, table: Table, rows: Sequence[dict[str, Any]], *, in_place: bool
) -> None:
    if not rows:
        return
    names = tuple(rows[0])
    dialect = connection.dialect.name
    if dialect == "postgresql" and len(rows) > 1:
        # Its driver would send the rows one by one.
        columns = {name: [row[name] for row in rows] for name in names}
        connection.execute(_unnest(table, names, in_place), columns)
    elif in_place:
        connection.execute(_upsert(dialect, table, names), list(rows))
    else:
        connection.execute(insert(table), list(rows))


@cache
def _unnest(table: Table, names: tuple[str, ...], in_place: bool) -> TextClause:  # noqa: FBT001
    arrays = ", ".join(f"CAST(:{name} AS {_array(table.c[name])})" for name in names)
    # Every name is a column of ours.
    words = f"INSERT INTO {table.name} ({', '.join(names)}) SELECT * FROM unnest({arrays})"  # noqa: S608
    if in_place:
        keys = [column.name for column in table.primary_key]
        others = ", ".join(f"{name} = EXCLUDED.{name}" for name in names if name not in keys)
        words += f" ON CONFLICT ({', '.join(keys)}) DO UPDATE SET {others}"
    return text(words)


def _array(column: Column[Any]) -> str:
    kinds = {LargeBinary: "bytea", Double: "double precision", Integer: "integer"}
    # A big integer is an integer, too.
    if isinstance(column.type, BigInteger):
        return "bigint[]"
    kind = next((word for kind, word in kinds.items() if isinstance(column.type, kind)), "text")
    return f"{kind}[]"


@cache
def _upsert(dialect: str, table: Table, names: tuple[str, ...]) -> Insert:
    keys = [column.name for column in table.primary_key]
    others = [name for name in names if name not in keys]
    if dialect in {"mysql", "mariadb"}:
        mine = mysql.insert(table)
        return mine.on_duplicate_key_update({name: mine.inserted[name] for name in others})
    made = sqlite.insert(table) if dialect == "sqlite" else postgresql.insert(table)
    done: Insert = made.on_conflict_do_update(
        index_elements=keys, set_={name: made.excluded[name] for name in others}
    )
    return done
