"""The history's connections: one that writes and a few that read, on any of the databases."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from sqlalchemy import create_engine, event
from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import StoreError
from talaia.hub.history.errors import HistoryError
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.dialects.choice import dialect_of

if TYPE_CHECKING:
    from concurrent.futures import Future

    from sqlalchemy import Engine

    from talaia.hub.history.connection_cut import ConnectionCut
    from talaia.hub.store.database_url import OnConnect, Reach

__all__ = ["READERS", "Checkpoints", "address_of", "open_engine"]

# Two for charts, one for exports, one that copies SQLite's journal.
READERS = 4
# SQLite's journal is copied into the database after so many bytes of bodies.
_CHECKPOINT_BYTES = 4 * 1024 * 1024


def open_engine(
    url: str,
    *,
    writes: bool,
    on_connect: OnConnect | None = None,
    cut: ConnectionCut | None = None,
) -> Engine:
    """Prepare connections; the database is not touched yet.

    ``on_connect`` may refuse one; ``cut`` can end all of them at once.

    Raises:
        HistoryError: the URL cannot be read, or its driver is not installed.

    """
    found = _parse_url(url)
    try:
        engine = create_engine(
            found.url,
            connect_args={**found.arguments, **found.dialect.opening_bounds},
            pool_size=1 if writes else READERS,
            max_overflow=0,
            # Every use begins and ends its transaction itself; to end it again is a round trip.
            pool_reset_on_return=None,
            pool_pre_ping=found.dialect.is_server,
        )
    except ImportError as error:
        missing = found.missing_driver(error)
        raise HistoryError(missing.problem, missing.remedy) from error
    if on_connect is not None:
        event.listen(engine, "connect", on_connect)
    found.dialect.prepare_history(engine, writes=writes)
    if cut is not None:
        cut.guard_engine(engine)
    return engine


def address_of(url: str) -> str:
    """Give the URL without its password, for messages."""
    return _parse_url(url).url.render_as_string(hide_password=True)


class Checkpoints:
    """Keeps SQLite's journal short, off the path of the commits; does nothing elsewhere.

    The bulk is copied by a thread of its own while commits go on. That never reaches the end of
    a journal that grows meanwhile, so the writing thread copies the few pages that are left;
    only then does SQLite begin the journal anew.
    """

    def __init__(self, engine: Engine, reader: Engine) -> None:
        """Use ``reader`` for the bulk and ``engine``, the writing thread's, for the rest."""
        # The writing thread's: its one connection is used between two commits.
        self._engine = engine
        # For the bulk, beside the commits.
        self._reader = reader
        # Written since the last checkpoint.
        self._bytes = 0
        # A checkpoint that is under way, if one is.
        self._bulk: Future[None] | None = None
        # One of its own: a checkpoint waits for the disk, and neither a commit nor a reader may.
        self._thread = ThreadPoolExecutor(1, "history-checkpoint")
        # The others look after their log by themselves.
        self._active = dialect_of(engine).has_checkpoints

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


def _parse_url(url: str) -> Reach:
    try:
        return parse_database_url(url, blocking=True)
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
