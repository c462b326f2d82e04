"""SQLite: a commit lasts, and readers never wait."""

from __future__ import annotations

import asyncio
import contextlib
import sqlite3
from functools import cache
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary, WeakSet

import aiosqlite
from sqlalchemy import event
from sqlalchemy.exc import DBAPIError

from talaia.hub.store.dialects.dialect import SINGLE, WRITES
from talaia.hub.store.dialects.sqlite_opening import SqliteConnection, open_sqlite
from talaia.hub.store.dialects.statement_words import insert_head, on_conflict

if TYPE_CHECKING:
    import threading
    from collections.abc import Iterator, Mapping, Sequence

    from sqlalchemy import URL, Connection, Engine, Table
    from sqlalchemy.engine import Dialect as EngineDialect
    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.pool import ConnectionPoolEntry

    from talaia.hub.store.dialects.dialect import Query, Values
    from talaia.hub.store.dialects.lead_words import LeadWords

__all__ = ["SqliteDialect", "copy_file"]

# Of pages, each of the history's connections holds so many (KiB). More is of no use: each commit
# makes the readers forget theirs, the journal is only ever added to, and what is read again comes
# from the system's cache.
_CACHE_KIB = 2048


# The threads of each engine's connections that have not been seen to end.
_THREADS: WeakKeyDictionary[EngineDialect, WeakSet[threading.Thread]] = WeakKeyDictionary()
# How long to wait for the end of one at most (s); it is not told to people.
_THREAD_S = 2.0


class SqliteDialect:
    """See `Dialect`."""

    waiting = "sqlite+aiosqlite"
    blocking = "sqlite"
    extra = "hub"
    is_server = False
    has_checkpoints = True
    remedy = "check that its folder exists and is writable"
    lead: LeadWords | None = None
    opening_bounds: Mapping[str, int] = {}
    idle_bound = ""

    def connect_arguments(self, driver: str) -> Mapping[str, Any]:
        """Let requests that were cut off give their locks back."""
        return {"factory": SqliteConnection} if driver == self.waiting else {}

    def tls_argument(self, driver: str) -> str:
        """Refuse: a file has no network before it."""
        raise ValueError(f"{driver} takes no TLS")

    def plain_arguments(self, driver: str) -> Mapping[str, Any]:
        """Say nothing: there is no network."""
        del driver
        return {}

    def prepare_accounts(self, engine: Engine) -> None:
        """Begin transactions ourselves; `SqliteConnection` keeps foreign keys."""
        event.listen(engine, "begin", _begin_accounts)
        event.listen(engine, "do_connect", _note_thread)

    async def wait_closed(self, engine: Engine) -> None:
        """Wait for aiosqlite's threads: one connection each, and closing ends them a little later.

        What they still report goes to an event loop that may have ended by then.
        """
        for thread in _THREADS.pop(engine.dialect, ()):
            if thread.is_alive():
                await asyncio.to_thread(thread.join, _THREAD_S)

    def prepare_history(self, engine: Engine, *, writes: bool) -> None:
        """Begin transactions ourselves; `Checkpoints` copies the journal, not a commit."""
        # Nothing is copied by a commit itself: `Checkpoints` does that beside it.
        opened = open_sqlite("wal_autocheckpoint=0", f"cache_size=-{_CACHE_KIB}")
        event.listen(engine, "connect", opened)
        event.listen(engine, "begin", _begin_writing if writes else _begin_reading)

    def open_snapshot(self, engine: Engine) -> Engine:
        """Give it as it is: transactions see one state anyway, by no name of a level."""
        return engine

    def cut_connection(self, connection: DBAPIConnection) -> None:
        """Do nothing: a file answers, or fails by itself."""
        del connection

    def driver_errors(self, engine: Engine) -> tuple[type[Exception], ...]:
        """Give none: sqlite3's errors are all translated."""
        del engine
        return ()

    def await_write_turn(self, connection: Connection) -> None:
        """Do nothing: ``BEGIN IMMEDIATE`` has waited for the turn."""
        del connection

    @contextlib.contextmanager
    def hold_migrations(self, connection: Connection) -> Iterator[None]:
        """Do nothing: the transaction has the turn to write, and changes of tables are in it."""
        del connection
        yield

    def write_rows(
        self,
        connection: Connection,
        table: Table,
        names: tuple[str, ...],
        rows: Sequence[Sequence[Any]],
        *,
        in_place: bool,
    ) -> None:
        """Run one prepared statement for all rows."""
        words = _insert_words(table, names, in_place)
        _run_quickly(connection, words, rows)

    def run_statements(self, connection: Connection, statements: Sequence[str]) -> None:
        """Run one after the other: nothing is waited for."""
        for words in statements:
            connection.exec_driver_sql(words)

    def fetch_columns(
        self, connection: Connection, query: Query, parameters: Mapping[str, int]
    ) -> Iterator[Values]:
        """Take rows as the driver makes them: to make SQLAlchemy's of them takes as long again."""
        result = connection.execute(query, parameters)
        rows: Sequence[Sequence[Any]] = result.cursor.fetchall()
        result.close()
        if not rows:
            return iter(())
        # A zip of thousands of rows would make an iterator of each.
        flat, count = list(chain.from_iterable(rows)), len(rows[0])
        return (flat[at::count] for at in range(count))

    def advance_sequences(self, connection: Connection, table: Table) -> None:
        """Do nothing: the next number is one past the greatest that is there."""
        del connection, table

    def time_of(self, microseconds: str) -> str:
        """Write a text in UTC: there is no type for times."""
        return f"strftime('%Y-%m-%d %H:%M:%f', {microseconds} / 1000000.0, 'unixepoch')"

    def store_uncompressed(self, connection: Connection, table: Table) -> None:
        """Do nothing: it compresses nothing."""
        del connection, table

    def product_name(self, connection: Connection) -> str:
        """Name it."""
        del connection
        return "SQLite"

    def measure_size(self, connection: Connection) -> tuple[int, int]:
        """Count pages: deleted ones stay in the file and are used again."""
        pages = connection.exec_driver_sql("PRAGMA page_count").scalar() or 0
        spare = connection.exec_driver_sql("PRAGMA freelist_count").scalar() or 0
        size = connection.exec_driver_sql("PRAGMA page_size").scalar() or 0
        return int((pages - spare) * size), int(spare * size)

    def file_of(self, url: URL) -> Path | None:
        """Give the file; none of a database in memory."""
        return Path(url.database) if url.database else None


def copy_file(path: Path, file: Path) -> str:
    """Copy a database that may be in use to a new ``file``; give its migration's number.

    Raises:
        sqlite3.Error: it cannot be read, or there is no room.

    """
    with (
        contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as origin,
        contextlib.closing(sqlite3.connect(file)) as copy,
    ):
        # In one step: it sees one state, and the hub goes on writing meanwhile.
        origin.backup(copy)
        # A backup is one file: WAL would leave two more beside it as soon as it is read.
        copy.execute("PRAGMA journal_mode=DELETE")
        found = copy.execute("SELECT version_num FROM alembic_version").fetchone()
        return str(found[0]) if found else ""


@cache
def _insert_words(table: Table, names: tuple[str, ...], in_place: bool) -> str:  # noqa: FBT001
    past = on_conflict(table, names) if in_place else ""
    return f"{insert_head(table, names)}({', '.join('?' * len(names))}){past}"


def _note_thread(
    dialect: EngineDialect,
    _record: ConnectionPoolEntry,
    _arguments: Sequence[Any],
    named: dict[str, Any],
) -> None:
    """Have the thread of each connection noted: also of one that cannot be opened."""
    threads = _THREADS.setdefault(dialect, WeakSet())

    def connect(*arguments: Any, **options: Any) -> aiosqlite.Connection:  # noqa: ANN401
        connection = aiosqlite.connect(*arguments, **options)
        # No public name leads to it; SQLAlchemy, which this stands in for, does the same.
        thread = connection._thread  # noqa: SLF001
        thread.daemon = True
        threads.add(thread)
        return connection

    named["async_creator_fn"] = connect


def _begin_accounts(connection: Connection) -> None:
    options = connection.get_execution_options()
    # Each statement for the driver is a way to another thread and back.
    if options.get(SINGLE, False):
        return
    # IMMEDIATE takes the turn to write at once: a transaction that read first could not take it
    # later without failing, if another has written meanwhile.
    connection.exec_driver_sql("BEGIN IMMEDIATE" if options.get(WRITES, False) else "BEGIN")


def _begin_writing(connection: Connection) -> None:
    _run_quickly(connection, "BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    _run_quickly(connection, "BEGIN")


def _run_quickly(
    connection: Connection, words: str, rows: Sequence[Sequence[Any]] | None = None
) -> None:
    """Run a statement, for each row if there are any; errors are raised as SQLAlchemy's.

    SQLAlchemy's own way takes longer than SQLite takes to begin, or to write a row.
    """
    cursor = connection.connection.cursor()
    errors = connection.dialect.loaded_dbapi.Error
    try:
        if rows is None:
            cursor.execute(words)
        else:
            cursor.executemany(words, rows)
    except errors as error:
        raise DBAPIError.instance(words, None, error, errors, dialect=connection.dialect) from error
    finally:
        cursor.close()
