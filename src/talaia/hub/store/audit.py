"""The audit log: append-only, each row chained by hash to the one before.

What happens is handed over with `Audit.note`, which never waits: STOP must not stand behind a
disk. One task writes what has gathered, many rows in one transaction.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import logging
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import insert, select
from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.store.tables import audit

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["Audit", "Entry", "chain_hash"]

_LOG = logging.getLogger(__name__)
_MOST_WAITING = 20_000
_RETRY_S = 1.0


class Entry(NamedTuple):
    """One row: what happened, where, by whom."""

    time_us: int
    kind: str
    who: str = ""
    address: str = ""
    site: str = ""
    device: str = ""
    message: str = ""
    good: bool = True


def chain_hash(before: str, entry: Entry) -> str:
    """Give a row's hash (SHA-256, hex) from the hash of the row before and its own fields."""
    said = json.dumps([before, *entry], ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(said.encode()).hexdigest()


class Audit:
    """Takes notes at once and writes them down soon."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps each note."""
        self._database = database
        self._clock = clock
        self._waiting: deque[Entry] = deque()
        self._news = asyncio.Event()
        self._written = asyncio.Event()
        self._written.set()
        self._failing = False
        self._stopping = False

    def note(
        self,
        kind: str,
        *,
        who: str = "",
        address: str = "",
        site: str = "",
        device: str = "",
        message: str = "",
        good: bool = True,
    ) -> Entry:
        """Take a note; never waits. Texts are cut to what a column holds."""
        entry = Entry(
            self._clock.wall_ns() // 1000,
            kind[:200],
            who[:200],
            address[:200],
            site[:200],
            device[:200],
            message[:2000],
            good,
        )
        if len(self._waiting) < _MOST_WAITING:
            self._waiting.append(entry)
        self._written.clear()
        self._news.set()
        return entry

    async def run(self) -> None:
        """Write notes down until `stop`, and then what still waits."""
        while self._waiting or not self._stopping:
            await self._news.wait()
            self._news.clear()
            try:
                await self._flush()
            except (SQLAlchemyError, OSError):
                if not self._failing:
                    _LOG.exception("the audit log cannot be written; notes are kept in memory")
                self._failing = True
                if self._stopping:
                    return
                await asyncio.sleep(_RETRY_S)
                self._news.set()
            else:
                if self._failing:
                    _LOG.warning("the audit log is written again")
                self._failing = False

    def stop(self) -> None:
        """Let `run` end once everything is written."""
        self._stopping = True
        self._news.set()

    async def _flush(self) -> None:
        batch = list(self._waiting)
        if batch:
            async with self._database.write() as connection:
                await _append(connection, batch)
            for _ in batch:
                self._waiting.popleft()
        if not self._waiting:
            self._written.set()

    async def written(self) -> None:
        """Wait until everything noted so far is in the database."""
        await self._written.wait()

    async def recent(
        self, site: str, limit: int, from_us: int = 0, to_us: int = 2**53
    ) -> list[Entry]:
        """List the newest entries of a site within a window (µs), newest first."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(*_COLUMNS)
                .where(audit.c.site == site, audit.c.time_us.between(from_us, to_us))
                .order_by(audit.c.id.desc())
                .limit(limit)
            )
            return [Entry(*row) for row in rows]

    async def broken_at(self) -> int | None:
        """Walk the chain; give the number of the first row that does not fit, or None."""
        before = ""
        async with self._database.read() as connection:
            rows = await connection.stream(
                select(audit.c.id, audit.c.hash, *_COLUMNS).order_by(audit.c.id)
            )
            async for row in rows:
                if chain_hash(before, Entry(*row[2:])) != row.hash:
                    return int(row.id)
                before = row.hash
        return None


_COLUMNS = tuple(audit.c[name] for name in Entry._fields)


async def _append(connection: AsyncConnection, batch: list[Entry]) -> None:
    last = select(audit.c.hash).order_by(audit.c.id.desc()).limit(1)
    before = (await connection.execute(last)).scalar() or ""
    rows = []
    for entry in batch:
        before = chain_hash(before, entry)
        rows.append({**entry._asdict(), "hash": before})
    await connection.execute(insert(audit), rows)
