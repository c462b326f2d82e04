"""The connection to the database: how it is opened, how it is brought up to date."""

from __future__ import annotations

from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection, event, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError
from sqlalchemy.ext.asyncio import create_async_engine

from talaia.hub.errors import StoreError
from talaia.hub.store.sqlite import open_sqlite

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

__all__ = ["Database"]

_MIGRATIONS = Path(__file__).parent / "migrations"
_WRITES = "talaia_writes"


class Database:
    """Transactions that read, and transactions that write."""

    def __init__(self, url: str) -> None:
        """Prepare for ``url``; nothing is opened yet.

        Raises:
            StoreError: the URL cannot be read, or its driver is not installed.

        """
        self._url = url
        try:
            self._engine = _engine(url)
        except (ArgumentError, ImportError) as error:
            raise StoreError(
                f"the database URL cannot be used: {error}",
                "write it like sqlite+aiosqlite:////path/talaia.db",
            ) from error
        self._writer = self._engine.execution_options(**{_WRITES: True})

    @asynccontextmanager
    async def read(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that only reads."""
        async with self._engine.begin() as connection:
            yield connection

    @asynccontextmanager
    async def write(self) -> AsyncIterator[AsyncConnection]:
        """Open a transaction that writes; it is committed unless an exception leaves it.

        In SQLite it holds the write lock from its first line, so that what it reads is still
        true when it writes.
        """
        async with self._writer.begin() as connection:
            yield connection

    async def migrate(self) -> None:
        """Bring the tables up to date, all steps in one transaction where the engine can.

        Raises:
            StoreError: the database cannot be opened or a step failed.

        """
        try:
            async with self.write() as connection:
                await connection.run_sync(_upgrade)
        except (SQLAlchemyError, OSError) as error:
            reason = getattr(error, "orig", None) or error
            raise StoreError(
                f"the database {self.address} cannot be opened: {reason}",
                "check that its folder exists and is writable",
            ) from error

    async def close(self) -> None:
        """Close every connection."""
        await self._engine.dispose()

    @property
    def address(self) -> str:
        """Give the URL without its password, for messages."""
        return make_url(self._url).render_as_string(hide_password=True)


def _engine(url: str) -> AsyncEngine:
    engine = create_async_engine(url, pool_pre_ping=not url.startswith("sqlite"))
    if engine.dialect.name == "sqlite":
        event.listen(engine.sync_engine, "connect", open_sqlite("foreign_keys=ON"))
        event.listen(engine.sync_engine, "begin", _begin_sqlite)
    return engine


def _begin_sqlite(connection: Connection) -> None:
    writes = connection.get_execution_options().get(_WRITES, False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")


def _upgrade(connection: Connection) -> None:
    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
