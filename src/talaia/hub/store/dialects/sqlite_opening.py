"""How a connection to SQLite is opened: what it promises of commits, and who waits for whom."""

from __future__ import annotations

import contextlib
import sqlite3
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from sqlalchemy.engine.interfaces import DBAPIConnection, DBAPICursor
    from sqlalchemy.pool import ConnectionPoolEntry

__all__ = ["SqliteConnection", "open_sqlite"]

# A commit is on the disk when it ends (FULL), and stops no reader (WAL). Without a time to wait, a
# second writer would fail at once.
_ALWAYS = (
    "busy_timeout=10000",
    "journal_mode=WAL",
    "synchronous=FULL",
    "journal_size_limit=16777216",
)
# Who is refused while a file is opened tries again so often, for so long (s).
_AGAIN_S, _OPEN_S = 0.01, 10.0


class SqliteConnection(sqlite3.Connection):
    """Gives its locks back the moment it is closed; a ``factory`` of sqlite3.

    SQLite itself waits with that until the last statement is gone
    (https://sqlite.org/c3ref/close.html), and a statement lives as long as somebody holds the
    exception that left its transaction: one request that was cut off would keep all others from
    writing.

    It sets its pragmas while it is opened, in the thread that opens it: from outside, each of them
    is a way to that thread and back.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:  # noqa: ANN401 - sqlite3's own
        """Open the file, and keep foreign keys.

        Raises:
            sqlite3.Error: it cannot be opened, or is no database.

        """
        super().__init__(*arguments, **options)
        try:
            _set_pragmas(self, (*_ALWAYS, "foreign_keys=ON"))
        except sqlite3.Error:
            # Whoever keeps the exception keeps this object.
            self.close()
            raise

    def close(self) -> None:
        """Give up what was begun, and close."""
        # One that is closed already says so, here and below.
        with contextlib.suppress(sqlite3.Error):
            self.rollback()
        super().close()


def open_sqlite(*more: str) -> Callable[[DBAPIConnection, ConnectionPoolEntry], None]:
    """Give a listener for SQLAlchemy's ``connect`` event that sets our pragmas and ``more``."""

    def opened(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
        _set_pragmas(connection, (*_ALWAYS, *more))

    return opened


def _set_pragmas(connection: DBAPIConnection | sqlite3.Connection, pragmas: Sequence[str]) -> None:
    """Set them, and leave it to us when transactions begin.

    The driver would begin transactions late and commit before a change of tables; who opens a
    connection here begins them itself, so that nothing is ever half applied.
    """
    connection.isolation_level = None
    cursor = connection.cursor()
    for pragma in pragmas:
        _set_pragma(cursor, pragma)
    cursor.close()


def _set_pragma(cursor: DBAPICursor | sqlite3.Cursor, pragma: str) -> None:
    ends = time.monotonic() + _OPEN_S
    while True:
        try:
            cursor.execute(f"PRAGMA {pragma}")
        except sqlite3.OperationalError as error:
            # Of several that open a new file at once, one changes its journal; SQLite refuses the
            # others without waiting, for they read the file already.
            is_busy = getattr(error, "sqlite_errorcode", 0) & 0xFF == sqlite3.SQLITE_BUSY
            if not is_busy or time.monotonic() > ends:
                raise
            time.sleep(_AGAIN_S)
        else:
            return
