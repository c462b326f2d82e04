"""Many rows in one statement, new ones or in place of those that are there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Connection, Table

    from talaia.hub.store.dialects.dialect import Row

__all__ = ["insert_rows", "insert_values", "put_rows"]


def insert_rows(connection: Connection, table: Table, rows: Sequence[Row]) -> None:
    """Insert rows; all of them have the same keys in the same order."""
    if rows:
        insert_values(connection, table, tuple(rows[0]), [tuple(row.values()) for row in rows])


def insert_values(
    connection: Connection, table: Table, names: tuple[str, ...], rows: Sequence[Sequence[Any]]
) -> None:
    """Insert rows of values of these columns; of thousands, dicts would take longer to make."""
    if rows:
        dialect_of(connection).write_rows(connection, table, names, rows, in_place=False)


def put_rows(connection: Connection, table: Table, rows: Sequence[Row]) -> None:
    """Insert rows in place of those with the same primary key."""
    if rows:
        values = [tuple(row.values()) for row in rows]
        dialect_of(connection).write_rows(connection, table, tuple(rows[0]), values, in_place=True)
