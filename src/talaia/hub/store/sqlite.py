"""How every SQLite connection of the hub is opened: a commit lasts, and readers never wait."""

from __future__ import annotations

import contextlib
import sqlite3
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.pool import ConnectionPoolEntry

__all__ = ["SqliteConnection", "open_sqlite"]

_ALWAYS = (
    "busy_timeout=10000",
    "journal_mode=WAL",
    "synchronous=FULL",
    "journal_size_limit=16777216",
)


class SqliteConnection(sqlite3.Connection):
    """Gives its locks back the moment it is closed; a ``factory`` of sqlite3.

    SQLite itself waits with that until the last statement is gone
    (https://sqlite.org/c3ref/close.html), and a statement lives as long as somebody holds the
    exception that left its transaction: one request that was cut off would keep all others from
    writing.
    """

    def close(self) -> None:
        """Give up what was begun, and close."""
        # One that is closed already says so, here and below.
        with contextlib.suppress(sqlite3.Error):
            self.rollback()
        super().close()


def open_sqlite(*more: str) -> Callable[[DBAPIConnection, ConnectionPoolEntry], None]:
    """Give a listener for SQLAlchemy's ``connect`` event that sets our pragmas and ``more``.

    The driver would begin transactions late and commit before a change of tables; whoever listens
    here begins them itself, so that nothing is ever half applied.
    """

    def opened(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
        connection.isolation_level = None
        cursor = connection.cursor()
        for pragma in (*_ALWAYS, *more):
            cursor.execute(f"PRAGMA {pragma}")
        cursor.close()

    return opened
