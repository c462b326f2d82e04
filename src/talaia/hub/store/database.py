"""The connection to the database: how it is opened, how it is brought up to date."""

from __future__ import annotations

import functools
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, event, func, inspect, select, text
from sqlalchemy.exc import DataError, DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.ext.asyncio import create_async_engine

from talaia.hub.errors import StoreDown, StoreError
from talaia.hub.store.database_url import reach
from talaia.hub.store.sqlite import SqliteConnection, open_sqlite
from talaia.hub.store.tables import write_turn

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from sqlalchemy.engine.interfaces import DBAPIConnection
    from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

    from talaia.hub.store.database_url import Reach

__all__ = ["Database"]

_MIGRATIONS = Path(__file__).parent / "migrations"
_WRITES = "talaia_writes"
# Whoever waits longer than this for one of the connections is told that the database is busy (s).
_POOL_S = 5
# PostgreSQL's locks have numbers: "talaia" and what it is for.
_LOCK = 0x74616C61
_LOCK_NAME = "talaia migrations in "
_MIGRATE_S = 120


class Database:
    """Transactions that read, and transactions that write."""

    def __init__(self, url: str) -> None:
        """Prepare for ``url``; nothing is opened yet.

        Raises:
            StoreError: the URL cannot be read, or its driver is not installed.

        """
        self._reach = reach(url)
        self._engine = _engine(self._reach)
        self._writer = self._engine.execution_options(**{_WRITES: True})
        self._failures = _failures(self._engine)

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that only reads.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._translated(), self._engine.begin() as connection:
            yield connection

    @asynccontextmanager
    async def write(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that writes; it is committed unless an exception leaves it.

        It holds the one turn to write from its first line, so that what it reads is still true
        when it writes.

        Raises:
            StoreDown: the database does not answer, or has no room.

        """
        async with self._translated(), self._writer.begin() as connection:
            await connection.run_sync(_take_turn)
            yield connection

    async def migrate(self) -> None:
        """Bring the tables up to date; of programs that start at once, one does and others wait.

        Where the engine can, all steps are one transaction; MariaDB cannot, and there each step
        is one that a later start takes up again.

        Raises:
            StoreError: the database cannot be opened or a step failed.

        """
        try:
            async with self._writer.begin() as connection:
                await connection.run_sync(_upgrade)
        except self._failures as error:
            reason = getattr(error, "orig", None) or error
            raise StoreError(
                f"the database {self.address} cannot be opened: {reason}", _remedy(self._engine)
            ) from error

    async def close(self) -> None:
        """Close every connection."""
        await self._engine.dispose()

    @property
    def address(self) -> str:
        """Give the URL without its password, for messages."""
        return self._reach.url.render_as_string(hide_password=True)

    @asynccontextmanager
    async def _translated(self) -> AsyncIterator[None]:
        try:
            yield
        except (IntegrityError, DataError):
            # It answers: what it was asked does not fit.
            raise
        except self._failures as error:
            reason = getattr(error, "orig", None) or error
            raise StoreDown(f"the database does not answer: {reason}", "try again soon") from error


def _engine(found: Reach) -> AsyncEngine:
    server = found.url.get_backend_name() != "sqlite"
    more = {"pool_pre_ping": True, "pool_timeout": _POOL_S} if server else {}
    arguments = found.arguments if server else {**found.arguments, "factory": SqliteConnection}
    try:
        engine = create_async_engine(found.url, connect_args=arguments, **more)
    except ImportError as error:
        raise found.missing(error) from error
    if not server:
        event.listen(engine.sync_engine, "connect", open_sqlite("foreign_keys=ON"))
        event.listen(engine.sync_engine, "begin", _begin_sqlite)
    elif found.url.get_backend_name() == "mysql":
        event.listen(engine.sync_engine, "connect", _let_bytes_pass)
    return engine


def _failures(engine: AsyncEngine) -> tuple[type[Exception], ...]:
    """Give what the engine raises when it does not do what it is asked."""
    # asyncpg's own errors come through unchanged while a connection is made.
    driver = getattr(engine.dialect.dbapi, "asyncpg", None)
    own = (driver.PostgresError, driver.InterfaceError) if driver is not None else ()
    return (DBAPIError, SQLAlchemyError, OSError, *own)


def _remedy(engine: AsyncEngine) -> str:
    if engine.dialect.name == "sqlite":
        return "check that its folder exists and is writable"
    return "check that the server runs, and that the database and its user are there"


def _let_bytes_pass(connection: DBAPIConnection, _record: object) -> None:
    """Write bytes as MariaDB reads them: aiomysql 0.3 has lost how.

    It imports from PyMySQL what is not there any more since its 1.2:
    https://github.com/PyMySQL/PyMySQL/issues/1274.
    """
    driver: Any = connection.driver_connection
    escape = driver.escape

    def with_bytes(value: object) -> str:
        said: str = f"_binary X'{value.hex()}'" if isinstance(value, bytes) else escape(value)
        return said

    driver.escape = with_bytes


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get(_WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _take_turn(connection: Connection) -> None:
    match connection.dialect.name:
        case "postgresql":
            connection.execute(select(func.pg_advisory_xact_lock(_LOCK)))
        case "mysql":
            connection.execute(select(write_turn.c.id).with_for_update())
        case _:
            # SQLite's turn began with the transaction.
            return


def _upgrade(connection: Connection) -> None:
    if connection.dialect.name != "mysql":
        _take_turn(connection)
        _run_migrations(connection)
        return
    # Its row locks end with the first change of a table; this one lasts.
    name = {"name": _LOCK_NAME + (connection.engine.url.database or "")}
    got = connection.execute(text("SELECT GET_LOCK(:name, :wait)"), {**name, "wait": _MIGRATE_S})
    if got.scalar() != 1:
        raise StoreDown("another program is changing the tables", "try again soon")
    try:
        _run_migrations(connection)
    finally:
        connection.execute(text("SELECT RELEASE_LOCK(:name)"), name)


def _run_migrations(connection: Connection) -> None:
    """Run what has not run yet; the caller has the turn to change tables."""
    if _is_current(connection):
        return
    # At most starts there is nothing to do, and to import Alembic takes longer than all the rest.
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")


def _is_current(connection: Connection) -> bool:
    """Tell whether the last migration has run."""
    if not inspect(connection).has_table("alembic_version"):
        return False
    versions = connection.execute(text("SELECT version_num FROM alembic_version")).scalars()
    return list(versions) == [_last_migration()]


@functools.cache
def _last_migration() -> str:
    """Give the last migration's number: its file's name begins with it, and is the highest."""
    files = (_MIGRATIONS / "versions").glob("[0-9]*_*.py")
    return max(file.name.partition("_")[0] for file in files)
