"""What engines share of writing and reading rows. Names in statements are our tables' own."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray
    from sqlalchemy import Connection, Table


__all__ = ["insert_head", "on_conflict", "parse_columns", "run_for_rows", "split_names"]


def run_for_rows(connection: Connection, words: str, rows: Sequence[Sequence[Any]]) -> None:
    """Run one statement with the values of all rows as its parameters, in the driver's own way."""
    values = [tuple(row) for row in rows]
    connection.exec_driver_sql(words, values if len(values) > 1 else values[0])


def parse_columns(texts: Iterable[str | None]) -> Iterator[NDArray[Any]]:
    """Read columns that came as one text each: times and values by turns."""
    # Times are whole numbers that a float would round.
    return (
        np.fromstring(column or "", np.float64 if at % 2 else np.int64, sep=",")
        for at, column in enumerate(texts)
    )


@cache
def insert_head(table: Table, names: tuple[str, ...]) -> str:
    """Write what stands before the values."""
    return f"INSERT INTO {table.name} ({', '.join(names)}) VALUES "  # noqa: S608


@cache
def on_conflict(table: Table, names: tuple[str, ...]) -> str:
    """Write what stands behind the values so that they replace a row, for SQLite and PostgreSQL."""
    keys, others = split_names(table, names)
    changes = ", ".join(f"{name} = EXCLUDED.{name}" for name in others)
    return f" ON CONFLICT ({', '.join(keys)}) DO UPDATE SET {changes}"


def split_names(table: Table, names: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Give the names of the primary key, and those of ``names`` that are not in it."""
    keys = [column.name for column in table.primary_key]
    return keys, [name for name in names if name not in keys]
