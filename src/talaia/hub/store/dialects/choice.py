"""Which engine a database is of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.store.dialects.mariadb import MariadbDialect
from talaia.hub.store.dialects.postgresql import PostgresqlDialect
from talaia.hub.store.dialects.sqlite import SqliteDialect

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

    from talaia.hub.store.dialects.dialect import Dialect

__all__ = ["MARIADB", "POSTGRESQL", "SQLITE", "dialect_of", "find_dialect"]

SQLITE: Dialect = SqliteDialect()
POSTGRESQL: Dialect = PostgresqlDialect()
MARIADB: Dialect = MariadbDialect()
_BY_NAME = {
    "sqlite": SQLITE,
    "postgresql": POSTGRESQL,
    # As libpq and many services write it.
    "postgres": POSTGRESQL,
    "mysql": MARIADB,
    "mariadb": MARIADB,
}


def find_dialect(name: str) -> Dialect | None:
    """Find an engine by the first word of a URL, or by SQLAlchemy's name of it."""
    return _BY_NAME.get(name)


def dialect_of(bind: Connection | Engine) -> Dialect:
    """Give the engine that is behind a connection."""
    return _BY_NAME[bind.dialect.name]
