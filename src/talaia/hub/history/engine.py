"""The history's connections: one that writes and a few that read, on any of the databases."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from sqlalchemy import create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import StoreError
from talaia.hub.history.errors import HistoryError
from talaia.hub.store.reach import reach
from talaia.hub.store.sqlite import open_sqlite

if TYPE_CHECKING:
    from concurrent.futures import Future

    from sqlalchemy import Connection, Engine

    from talaia.hub.store.reach import Reach

__all__ = ["READERS", "Checkpoints", "address_of", "open_engine"]

# Two for charts, one for exports, one that copies SQLite's journal.
READERS = 4
# SQLite's journal is copied into the database after so many bytes of bodies.
_CHECKPOINT_BYTES = 4 * 1024 * 1024


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
            pool_pre_ping=found.url.get_backend_name() != "sqlite",
        )
    except ImportError as error:
        missing = found.missing(error)
        raise HistoryError(missing.problem, missing.remedy) from error
    if engine.dialect.name == "sqlite":
        opened = open_sqlite("wal_autocheckpoint=0", "cache_size=-16384")
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
        self._bytes = 0
        self._bulk: Future[None] | None = None
        self._thread = ThreadPoolExecutor(1, "history-checkpoint")
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


def _begin_writing(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN")
