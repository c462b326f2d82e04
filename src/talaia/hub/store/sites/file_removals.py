"""What is still to be removed from a store of files; it outlives the hub."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from sqlalchemy import delete, insert, select

from talaia.hub.store.file_tables import file_removals as table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.store.database import Database

__all__ = ["FileRemovals"]


class FileRemovals:
    """Keys of files, those first that have waited longest."""

    def __init__(self, database: Database) -> None:
        """Work on ``database``."""
        self._database = database

    async def add_keys(self, keys: Sequence[str]) -> None:
        """Write down that these are to be removed.

        Raises:
            StoreDown: the database does not answer; none is written down.

        """
        since_us = time.time_ns() // 1000
        async with self._database.write() as connection:
            await connection.execute(delete(table).where(table.c.file_key.in_(keys)))
            await connection.execute(
                insert(table), [{"file_key": key, "since_us": since_us} for key in keys]
            )

    async def list_keys(self, most: int | None = None) -> list[str]:
        """List what is to be removed, at most so many.

        Raises:
            StoreDown: the database does not answer.

        """
        query = select(table.c.file_key).order_by(table.c.since_us, table.c.file_key).limit(most)
        async with self._database.read() as connection:
            return list((await connection.execute(query)).scalars())

    async def forget_keys(self, keys: Sequence[str]) -> None:
        """Write down that these are not to be removed: they are, or are there anew.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.write() as connection:
            await connection.execute(delete(table).where(table.c.file_key.in_(keys)))
