"""Steps of a migration that may be taken again.

MariaDB commits each change of tables by itself, so a migration that was killed half-way is found
half done at the next start. Every step here looks first and does only what is missing; with that
the next start takes it up where it ended.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from alembic import op

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from sqlalchemy.sql.schema import SchemaItem

__all__ = [
    "BIG",
    "HASH",
    "ID",
    "LONG",
    "NAME",
    "add_column",
    "create_index",
    "create_table",
    "seed",
]

ID = sa.BigInteger().with_variant(sa.Integer, "sqlite")
BIG = sa.BigInteger()
NAME = sa.String(200)
HASH = sa.String(64)
# MariaDB's TEXT ends at 64 KiB unless it is told a length; PostgreSQL's takes none.
LONG = sa.Text(4 * 1024 * 1024).with_variant(sa.Text(), "postgresql")

# MariaDB compares texts without regard to case and accents unless told otherwise.
_EXACT: dict[str, Any] = {"mysql_charset": "utf8mb4", "mysql_collate": "utf8mb4_bin"}


def create_table(name: str, *parts: SchemaItem, **options: Any) -> sa.Table:  # noqa: ANN401
    """Make a table unless it is there; give it in either case, for `seed`."""
    if _inspector().has_table(name):
        return sa.Table(name, sa.MetaData(), *parts)
    return op.create_table(name, *parts, **_EXACT, **options)


def create_index(name: str, table: str, columns: Sequence[str]) -> None:
    """Make an index unless it is there."""
    if name not in {index["name"] for index in _inspector().get_indexes(table)}:
        op.create_index(name, table, list(columns))


def add_column(table: str, column: sa.Column[Any]) -> None:
    """Add a column unless it is there; one that may not be NULL needs a ``server_default``."""
    if column.name not in {found["name"] for found in _inspector().get_columns(table)}:
        op.add_column(table, column)


def seed(table: sa.Table, rows: Sequence[Mapping[str, object]]) -> None:
    """Insert those of the rows that are not there yet, by the table's primary key."""
    key = list(table.primary_key.columns)
    there = {tuple(row) for row in op.get_bind().execute(sa.select(*key))}
    missing = [dict(row) for row in rows if tuple(row[one.name] for one in key) not in there]
    if missing:
        op.bulk_insert(table, missing)
    _count_on(table)


def _count_on(table: sa.Table) -> None:
    """Let PostgreSQL number the next row after those that came with their numbers."""
    if op.get_bind().dialect.name != "postgresql" or "id" not in table.c:
        return
    sequence = sa.func.pg_get_serial_sequence(table.name, "id")
    highest = sa.select(sa.func.max(table.c.id)).scalar_subquery()
    op.get_bind().execute(sa.select(sa.func.setval(sequence, highest)))


def _inspector() -> sa.Inspector:
    # A new one each time: it remembers what it saw, and we change it.
    return sa.inspect(op.get_bind())
