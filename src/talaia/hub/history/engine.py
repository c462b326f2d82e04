"""The history's connections: one that writes and a few that read, on any of the databases."""

from __future__ import annotations

import socket
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from sqlalchemy import create_engine, event
from sqlalchemy.exc import OperationalError, SQLAlchemyError

from talaia.hub.errors import StoreError
from talaia.hub.history.errors import HistoryError
from talaia.hub.store.database_url import reach
from talaia.hub.store.sqlite import open_sqlite

if TYPE_CHECKING:
    from concurrent.futures import Future

    from sqlalchemy import Connection, Engine
    from sqlalchemy.engine.interfaces import DBAPIConnection, DBAPICursor, ExecutionContext
    from sqlalchemy.pool import ConnectionPoolEntry

    from talaia.hub.store.database_url import Reach

__all__ = ["READERS", "Checkpoints", "address_of", "open_engine"]

# Two for charts, one for exports, one that copies SQLite's journal.
READERS = 4
# SQLite's journal is copied into the database after so many bytes of bodies.
_CHECKPOINT_BYTES = 4 * 1024 * 1024
# Of pages, each of SQLite's connections holds so many (KiB). More is of no use: each commit makes
# the readers forget theirs, the journal is only ever added to, and what is read again comes from
# the system's cache.
_CACHE_KIB = 2048


def open_engine(url: str, *, writes: bool) -> Engine:
    """Prepare connections; the database is not touched yet.

    Raises:
        HistoryError: the URL cannot be read, or its driver is not installed.

    """
    found = _reach(url)
    try:
        engine = create_engine(
            found.url,
            connect_args=found.arguments,
            pool_size=1 if writes else READERS,
            max_overflow=0,
            # Every use begins and ends its transaction itself; to end it again is a round trip.
            pool_reset_on_return=None,
            pool_pre_ping=found.url.get_backend_name() != "sqlite",
        )
    except ImportError as error:
        missing = found.missing(error)
        raise HistoryError(missing.problem, missing.remedy) from error
    if engine.dialect.name == "postgresql":
        event.listen(engine, "connect", _send_at_once)
        event.listen(engine, "before_cursor_execute", _write_out, retval=True)
    elif engine.dialect.name == "mysql":
        event.listen(engine, "connect", _gather_long)
    elif engine.dialect.name == "sqlite":
        opened = open_sqlite("wal_autocheckpoint=0", f"cache_size=-{_CACHE_KIB}")
        event.listen(engine, "connect", opened)
        event.listen(engine, "begin", _begin_writing if writes else _begin_reading)
    return engine


def address_of(url: str) -> str:
    """Give the URL without its password, for messages."""
    return _reach(url).url.render_as_string(hide_password=True)


class Checkpoints:
    """Keeps SQLite's journal short, off the path of the commits; does nothing elsewhere.

    The bulk is copied by a thread of its own while commits go on. That never reaches the end of
    a journal that grows meanwhile, so the writing thread copies the few pages that are left;
    only then does SQLite begin the journal anew.
    """

    def __init__(self, engine: Engine, reader: Engine) -> None:
        """Use ``reader`` for the bulk and ``engine``, the writing thread's, for the rest."""
        self._engine = engine
        self._reader = reader
        # Written since the last checkpoint.
        self._bytes = 0
        # A checkpoint that is under way, if one is.
        self._bulk: Future[None] | None = None
        # One of its own: a checkpoint waits for the disk, and neither a commit nor a reader may.
        self._thread = ThreadPoolExecutor(1, "history-checkpoint")
        # The others look after their log by themselves.
        self._active = engine.dialect.name == "sqlite"

    def after_commit(self, size: int) -> None:
        """Count a commit of ``size`` bytes; called by the writing thread."""
        if not self._active:
            return
        self._bytes += size
        if self._bulk is None and self._bytes >= _CHECKPOINT_BYTES:
            self._bytes = 0
            self._bulk = self._thread.submit(_checkpoint, self._reader)
        elif self._bulk is not None and self._bulk.done():
            self._bulk = None
            _checkpoint(self._engine)

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown()


def _reach(url: str) -> Reach:
    try:
        return reach(url, blocking=True)
    except StoreError as error:
        raise HistoryError(error.problem, error.remedy) from error


def _checkpoint(engine: Engine) -> None:
    connection = engine.raw_connection()
    try:
        # It waits for nobody; what is in use stays for the next time.
        cursor = connection.cursor()
        cursor.execute("PRAGMA wal_checkpoint(PASSIVE)")
        cursor.close()
    except (SQLAlchemyError, engine.dialect.loaded_dbapi.Error):
        # A checkpoint that fails loses nothing: a full disk shows itself at the next commit.
        connection.invalidate()
    finally:
        connection.close()


def _send_at_once(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let pg8000's socket hold nothing back.

    It would keep the end of a long statement until the server has acknowledged the beginning,
    for which the server takes 40 ms.
    """
    # The driver has no option for it. Without its socket it is slow, nothing else.
    opened = getattr(connection, "_usock", None)
    if isinstance(opened, socket.socket) and opened.family != socket.AF_UNIX:
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _write_out(
    _connection: Connection,
    _cursor: DBAPICursor,
    statement: str,
    parameters: Any,  # noqa: ANN401 - whatever the dialect makes of them
    _context: ExecutionContext | None,
    many: bool,  # noqa: FBT001
) -> tuple[str, Any]:
    """Write whole numbers into the statement itself.

    For a parameter pg8000 looks through the statement character by character, and asks the server
    twice and waits twice; times and block numbers are most of what we ever ask by.
    """
    if many or not parameters or not all(type(parameter) is int for parameter in parameters):
        return statement, parameters
    return statement % tuple(f"'{parameter}'" for parameter in parameters), ()


def _gather_long(connection: DBAPIConnection, _entry: ConnectionPoolEntry) -> None:
    """Let MariaDB make one text of many rows; see `columns`."""
    cursor = connection.cursor()
    cursor.execute("SET SESSION group_concat_max_len = 67108864")
    cursor.close()


def _begin_writing(connection: Connection) -> None:
    _begin(connection, "BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    _begin(connection, "BEGIN")


def _begin(connection: Connection, words: str) -> None:
    # SQLAlchemy's own way to run a statement takes longer than SQLite takes to begin.
    cursor = connection.connection.cursor()
    try:
        cursor.execute(words)
    except connection.dialect.loaded_dbapi.Error as error:
        raise OperationalError(words, None, error) from error
    finally:
        cursor.close()
