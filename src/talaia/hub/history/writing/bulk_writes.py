"""Many rows in one statement, new ones or in place of those that are there, on each database.

A statement for each row would be most of the time on a server: every one waits for an answer. And
these few statements are run a thousand times a second, so their words are made once.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from sqlalchemy import String, text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection, Table, TextClause

__all__ = ["insert_rows", "put_rows"]

Row = dict[str, Any]


def insert_rows(connection: Connection, table: Table, rows: Sequence[Row]) -> None:
    """Insert rows; all of them have the same keys in the same order."""
    _write(connection, table, rows, in_place=False)


def put_rows(connection: Connection, table: Table, rows: Sequence[Row]) -> None:
    """Insert rows in place of those with the same primary key."""
    _write(connection, table, rows, in_place=True)


def _write(connection: Connection, table: Table, rows: Sequence[Row], *, in_place: bool) -> None:
    if not rows:
        return
    names = tuple(rows[0])
    dialect = connection.dialect.name
    if dialect != "postgresql":
        values = [tuple(row.values()) for row in rows]
        words = _words(dialect, table, names, in_place)
        # Of several rows the driver makes one statement, or runs one that is prepared.
        connection.exec_driver_sql(words, values if len(values) > 1 else values[0])
    elif _has_texts(table, names):
        columns = {name: [row[name] for row in rows] for name in names}
        connection.execute(_unnest(table, names, in_place), columns)
    else:
        # With parameters its driver would look through the words for their places, character by
        # character, and wait twice for an answer.
        head, past = _around(table, names, in_place)
        written = ",".join([f"({','.join(map(_literal, row.values()))})" for row in rows])
        connection.exec_driver_sql(f"{head}{written}{past}")


@cache
def _words(dialect: str, table: Table, names: tuple[str, ...], in_place: bool) -> str:  # noqa: FBT001
    head, past = _around(table, names, in_place)
    if dialect == "sqlite":
        return f"{head}({', '.join('?' * len(names))}){past}"
    if in_place:
        _, others = _split(table, names)
        changes = ", ".join(f"{name} = VALUES({name})" for name in others)
        past = f" ON DUPLICATE KEY UPDATE {changes}"
    return f"{head}({', '.join(['%s'] * len(names))}){past}"


@cache
def _around(table: Table, names: tuple[str, ...], in_place: bool) -> tuple[str, str]:  # noqa: FBT001
    """Give what stands before and after the values; every name is a column of ours."""
    past = ""
    if in_place:
        keys, others = _split(table, names)
        changes = ", ".join(f"{name} = EXCLUDED.{name}" for name in others)
        past = f" ON CONFLICT ({', '.join(keys)}) DO UPDATE SET {changes}"
    return f"INSERT INTO {table.name} ({', '.join(names)}) VALUES ", past  # noqa: S608


def _literal(value: float | bytes | None) -> str:
    """Write a value so that PostgreSQL reads the same one."""
    if value is None:
        return "NULL"
    if isinstance(value, bytes):
        return f"decode('{value.hex()}','hex')"
    if not isinstance(value, float | int):
        raise TypeError(f"only numbers and bytes stand in a statement, no {type(value).__name__}")
    # Quoted, a float is read as a double at once; Python's digits give back every bit.
    return f"'{value!r}'"


@cache
def _has_texts(table: Table, names: tuple[str, ...]) -> bool:
    return any(isinstance(table.c[name].type, String) for name in names)


@cache
def _unnest(table: Table, names: tuple[str, ...], in_place: bool) -> TextClause:  # noqa: FBT001
    arrays = ", ".join(f"CAST(:{name} AS {_array(table, name)})" for name in names)
    head, past = _around(table, names, in_place)
    return text(f"{head.removesuffix('VALUES ')}SELECT * FROM unnest({arrays}){past}")  # noqa: S608


def _array(table: Table, name: str) -> str:
    kind = table.c[name].type
    if isinstance(kind, String):
        return "text[]"
    return "double precision[]" if kind.python_type is float else "bigint[]"


def _split(table: Table, names: tuple[str, ...]) -> tuple[list[str], list[str]]:
    keys = [column.name for column in table.primary_key]
    return keys, [name for name in names if name not in keys]
