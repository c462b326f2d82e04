"""The connection to the database: how it is opened, how it is brought up to date."""

from __future__ import annotations

import asyncio
import functools
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar
from weakref import WeakKeyDictionary

from sqlalchemy import Connection, event, inspect, text
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.ext.asyncio import create_async_engine

from talaia.hub.errors import StoreDown, StoreError
from talaia.hub.store.database_url import parse_database_url, say_at_connect
from talaia.hub.store.dialects.choice import dialect_of
from talaia.hub.store.dialects.dialect import SINGLE, WRITES

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from sqlalchemy import Select
    from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

    from talaia.hub.store.database_url import OnConnect, Reach

__all__ = ["Database", "last_migration", "open_migrated"]

ScalarT = TypeVar("ScalarT")

_MIGRATING: WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Lock] = WeakKeyDictionary()
_MIGRATIONS = Path(__file__).parent / "migrations"
# Whoever waits longer than this for one of the connections is told that the database is busy (s).
_POOL_S = 5


class Database:
    """Transactions that read, and transactions that write."""

    def __init__(
        self, url: str, *, on_connect: OnConnect | None = None, shares_turn: bool = False
    ) -> None:
        """Prepare for ``url``; nothing is opened yet. ``on_connect`` may refuse a connection.

        ``shares_turn``: other hubs write there, too. Where this one stands still within a
        transaction, the server ends that after some seconds, or nobody would have the turn.

        Raises:
            StoreError: the URL cannot be read, or its driver is not installed.

        """
        # The URL, and what the driver needs beside it.
        self._reach = parse_database_url(url)
        # Connections that only read, as far as it knows.
        self._engine = _make_engine(self._reach)
        if on_connect is not None:
            event.listen(self._engine.sync_engine, "connect", on_connect)
        if shares_turn:
            bound = say_at_connect(self._reach.dialect.idle_bound)
            event.listen(self._engine.sync_engine, "connect", bound)
        # The same connections; their transactions begin by waiting for the turn to write.
        self._writer = self._engine.execution_options(**{WRITES: True})
        # The same connections; for one query each, with no transaction around it.
        self._single = self._engine.execution_options(**{SINGLE: True})
        # What the engine raises when it does not do what it is asked.
        self._failures: tuple[type[Exception], ...] = (
            DBAPIError,
            SQLAlchemyError,
            OSError,
            *dialect_of(self._engine.sync_engine).driver_errors(self._engine.sync_engine),
        )

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that only reads.

        Raises:
            StoreDown: the database does not answer.

        """
        # Its end is a rollback, which a connection does anyway when it goes back to the others: a
        # commit would only be one more way to the database.
        async with self._translate_errors(), self._engine.connect() as connection:
            yield connection

    async def fetch_scalars(self, query: Select[ScalarT]) -> Sequence[ScalarT]:
        """Run one query by itself and give its first column.

        For what is asked again and again: where the engine begins no transaction by itself, none
        is begun, since one statement sees one state anyway.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._translate_errors(), self._single.connect() as connection:
            return (await connection.execute(query)).scalars().all()

    @asynccontextmanager
    async def write(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that writes; it is committed unless an exception leaves it.

        It holds the one turn to write from its first line, so that what it reads is still true
        when it writes.

        Raises:
            StoreDown: the database does not answer, or has no room.

        """
        async with self._translate_errors(), self._writer.begin() as connection:
            await connection.run_sync(_await_turn)
            yield connection

    async def migrate(self) -> None:
        """Bring the tables up to date; of programs that start at once, one does and others wait.

        Where the engine can, all steps are one transaction; MariaDB cannot, and there each step
        is one that a later start takes up again.

        Raises:
            StoreError: the database cannot be opened or a step failed.

        """
        try:
            async with _migrating_turn(), self._writer.begin() as connection:
                await connection.run_sync(_upgrade_schema)
        except self._failures as error:
            reason = getattr(error, "orig", None) or error
            raise StoreError(
                f"the database {self.address} cannot be opened: {reason}",
                dialect_of(self._engine.sync_engine).remedy,
            ) from error

    async def close(self) -> None:
        """Close every connection."""
        await self._engine.dispose()
        await dialect_of(self._engine.sync_engine).wait_closed(self._engine.sync_engine)

    @property
    def address(self) -> str:
        """Give the URL without its password, for messages."""
        return self._reach.url.render_as_string(hide_password=True)

    @asynccontextmanager
    async def _translate_errors(self) -> AsyncIterator[None]:
        try:
            yield
        except (IntegrityError, DataError):
            # It answers: what it was asked does not fit.
            raise
        except self._failures as error:
            reason = getattr(error, "orig", None) or error
            raise StoreDown(f"the database does not answer: {reason}", "try again soon") from error


def _make_engine(found: Reach) -> AsyncEngine:
    # What was open when a server was restarted is found out before it is used. A file needs none
    # of that, and has as many connections as are asked for.
    is_server = found.dialect.is_server
    more = {"pool_pre_ping": True, "pool_timeout": _POOL_S} if is_server else {}
    try:
        engine = create_async_engine(found.url, connect_args=found.arguments, **more)
    except ImportError as error:
        raise found.missing_driver(error) from error
    found.dialect.prepare_accounts(engine.sync_engine)
    return engine


def _migrating_turn() -> asyncio.Lock:
    """Give what one database of this loop has that is brought up to date.

    Alembic has one "current connection" for the whole program: of two at once, steps of one would
    be done to the other.
    """
    return _MIGRATING.setdefault(asyncio.get_running_loop(), asyncio.Lock())


def _await_turn(connection: Connection) -> None:
    dialect_of(connection).await_write_turn(connection)


def _upgrade_schema(connection: Connection) -> None:
    with dialect_of(connection).hold_migrations(connection):
        _run_migrations(connection)


def _run_migrations(connection: Connection) -> None:
    """Run what has not run yet; the caller has the turn to change tables."""
    found = _migrations_done(connection)
    if found == [last_migration()]:
        return
    # Numbers have four digits, so texts are compared as they are.
    if found and max(found) > last_migration():
        raise StoreError(
            f"the tables are of version {max(found)}, which is newer than this program's "
            f"{last_migration()}",
            "start the newer program, or restore the backup of before with: talaia restore",
        )
    # At most starts there is nothing to do, and to import Alembic takes longer than all the rest.
    from alembic import command
    from alembic.config import Config

    config = Config()
    # A single % would begin a reference there.
    config.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _migrations_done(connection: Connection) -> list[str]:
    """Give the last migration that has run; empty for a new database."""
    if not inspect(connection).has_table("alembic_version"):
        return []
    versions = connection.execute(text("SELECT version_num FROM alembic_version")).scalars()
    return list(versions)


@functools.cache
def last_migration() -> str:
    """Give the last migration's number: its file's name begins with it, and is the highest."""
    files = (_MIGRATIONS / "versions").glob("[0-9]*_*.py")
    # Names begin with four digits, so the greatest name is the last step's.
    return max(file.name.partition("_")[0] for file in files)


@asynccontextmanager
async def open_migrated(url: str) -> AsyncIterator[Database]:
    """Open a database for one command; a hub of another version may have used it last.

    Raises:
        StoreError: it cannot be opened, or a step of the migration failed.

    """
    database = Database(url)
    try:
        await database.migrate()
        yield database
    finally:
        await database.close()
