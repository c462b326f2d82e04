"""Parts of ``INSERT`` statements that engines share. Every name in them is one of our tables'."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sqlalchemy import Table

__all__ = ["insert_head", "on_conflict", "split_names"]


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
