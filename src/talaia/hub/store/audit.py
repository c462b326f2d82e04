"""The audit log: append-only, each row chained by hash to the one before.

What happens is handed over with `Audit.append_record`, which never waits: STOP must not stand
behind a disk. One task writes what has gathered, many rows in one transaction.

The hash of the newest row stands in a table of its own besides. Whoever appends locks that row, so
that two hubs on one database make one chain; and rows that were cut off at the end show.

Long, because one chain holds what is written, read and verified here.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import logging
from collections import deque
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import func, insert, not_, or_, select, update

from talaia.hub.errors import StoreDown
from talaia.hub.store.safe_text import safe_text
from talaia.hub.store.tables import audit, audit_head

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Collection, Mapping, Sequence

    from sqlalchemy import ColumnElement
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = [
    "PART_OF_ANOMALY",
    "Audit",
    "AuditEntry",
    "AuditFilter",
    "AuditRecord",
    "Chain",
    "append_entries",
    "chain_hash",
]

# Kinds of lines about what joins an episode of anomalies, which has a line of its own.
PART_OF_ANOMALY = "anomaly part"
_LOG = logging.getLogger(__name__)
# More are lost while the database is away: memory is bounded.
_MOST_WAITING = 20_000
# Between two attempts while the database fails (s).
_RETRY_S = 1.0
# Rows that are read at a time.
_PAGE = 1000
# The number of the only row of `audit_head`.
_HEAD = 1
_NO_HEADS: Mapping[int, str] = MappingProxyType({})


class AuditEntry(NamedTuple):
    """One row: what happened, where, by whom, and whose word it is.

    Attributes:
        source: ``hub``: it did or saw it itself; ``gateway``: the site's gateway says so; empty in
            rows that are older than this column.

    """

    time_us: int
    kind: str
    who: str = ""
    address: str = ""
    site: str = ""
    device: str = ""
    message: str = ""
    good: bool = True
    source: str = "hub"


class AuditRecord(NamedTuple):
    """An entry with its number; numbers rise, and may leave some out."""

    id: int
    entry: AuditEntry


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditFilter:
    """Which rows are meant; what is None does not matter.

    Attributes:
        kind: the beginning of the kind: ``command`` finds all about commands; of several kinds,
            with commas between.
        from_us: not before. to_us: before.
        before: only rows with a smaller number.
        devices: only about one of these; not of the site as a whole.
        without: the beginning of kinds that are left out, with commas between.
        text: these words stand in the kind, the person, the device or the message, in any case.

    """

    who: str | None = None
    site: str | None = None
    device: str | None = None
    kind: str | None = None
    good: bool | None = None
    from_us: int | None = None
    to_us: int | None = None
    before: int | None = None
    devices: Collection[str] | None = None
    without: str | None = None
    text: str | None = None

    def sql_conditions(self) -> list[ColumnElement[bool]]:
        """Say it in SQL."""
        said = [
            audit.c[field.name] == getattr(self, field.name)
            for field in fields(self)
            if field.name in {"who", "site", "device", "good"}
            and getattr(self, field.name) is not None
        ]
        if self.kind is not None:
            # Nothing but commas matches no kind, rather than every one.
            kinds = [kind for kind in self.kind.split(",") if kind] or [self.kind]
            # What people type holds no wildcards: `%` and `_` stand for themselves.
            said.append(or_(*(audit.c.kind.startswith(kind, autoescape=True) for kind in kinds)))
        if self.from_us is not None:
            said.append(audit.c.time_us >= self.from_us)
        if self.to_us is not None:
            said.append(audit.c.time_us < self.to_us)
        if self.before is not None:
            said.append(audit.c.id < self.before)
        if self.devices is not None:
            said.append(audit.c.device.in_(sorted(self.devices)))
        if self.without is not None:
            said += [
                not_(audit.c.kind.startswith(kind, autoescape=True))
                for kind in self.without.split(",")
            ]
        if self.text:
            wanted = self.text.lower()
            columns = (audit.c.kind, audit.c.who, audit.c.device, audit.c.message)
            said.append(
                or_(*(func.lower(column).contains(wanted, autoescape=True) for column in columns))
            )
        return said


class Chain(NamedTuple):
    """What a walk along the chain has found.

    Attributes:
        rows: that follow each from the one before.
        broken: the number of the first that does not, or that a signed head names otherwise; or 0.
        heads: signed heads that the chain passes.

    """

    rows: int
    broken: int
    heads: int = 0


def chain_hash(before: str, entry: AuditEntry) -> str:
    """Give a row's hash (SHA-256, hex) from the hash of the row before and its own fields."""
    # Only one way to write an entry: another spelling would be another hash.
    # Rows of before the last column were chained without it.
    columns = entry if entry.source else entry[:-1]
    said = json.dumps([before, *columns], ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(said.encode()).hexdigest()


class Audit:
    """Takes notes at once and writes them down soon."""

    def __init__(self, database: Database, clock: Clock, most_waiting: int = _MOST_WAITING) -> None:
        """Work on ``database``; ``clock`` stamps each note; ``most_waiting`` are in memory."""
        self._most_waiting = most_waiting
        self._database = database
        self._clock = clock
        # Not in the database yet. What is written stays until the commit is sure: the same rows
        # are tried again after a failure.
        self._waiting: deque[AuditEntry] = deque()
        # Set when there is something to write, or it is time to stop.
        self._news = asyncio.Event()
        # Set while nothing waits.
        self._written = asyncio.Event()
        self._written.set()
        # The last try failed; of the next ones nothing is logged.
        self._failing = False
        # What waits is written, once; the hub must be able to end without its database.
        self._stopping = False
        # Notes for which memory had no room: of those that are not told of yet, and of all.
        self._untold = 0
        self.lost = 0

    def append_record(
        self,
        kind: str,
        *,
        who: str = "",
        address: str = "",
        site: str = "",
        device: str = "",
        message: str = "",
        good: bool = True,
        source: str = "hub",
    ) -> AuditEntry:
        """Take a note; never waits. ``source`` is `AuditEntry.source`.

        Texts are cut to what a column holds. Characters that are not seen, a new line too, are
        written as escapes, so that nobody can make one row look like two.
        """
        entry = AuditEntry(
            self._clock.wall_ns() // 1000,
            safe_text(kind, 200),
            safe_text(who, 200),
            safe_text(address, 200),
            safe_text(site, 200),
            safe_text(device, 200),
            safe_text(message, 2000),
            good,
            source,
        )
        if len(self._waiting) < self._most_waiting:
            self._waiting.append(entry)
        else:
            if not self._untold:
                _LOG.error("the audit log loses notes: %d wait already", self._most_waiting)
            self._untold += 1
            self.lost += 1
        self._written.clear()
        self._news.set()
        return entry

    async def run(self) -> None:
        """Write notes down until `stop`, and then what still waits."""
        while self._waiting or not self._stopping:
            await self._news.wait()
            self._news.clear()
            try:
                await self._flush_entries()
            except StoreDown:
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

    async def _flush_entries(self) -> None:
        batch = list(self._waiting)
        if batch:
            async with self._database.write() as connection:
                await append_entries(connection, batch)
            # They are still in front: others were only appended meanwhile.
            for _ in batch:
                self._waiting.popleft()
        if self._untold:
            lost, self._untold = self._untold, 0
            said = f"{lost} notes were not kept, for the database was away too long"
            self.append_record("notes lost", message=said, good=False)
        if not self._waiting:
            self._written.set()

    async def wait_written(self) -> None:
        """Wait until everything noted so far is in the database."""
        await self._written.wait()

    async def find_records(self, wanted: AuditFilter, limit: int) -> tuple[list[AuditRecord], bool]:
        """List the newest rows that are meant, newest first; tell whether there are more."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(audit.c.id, *_COLUMNS)
                .where(*wanted.sql_conditions())
                .order_by(audit.c.id.desc())
                # One more than asked for tells whether there are more.
                .limit(limit + 1)
            )
            found = [AuditRecord(row[0], AuditEntry(*row[1:])) for row in rows]
        return found[:limit], len(found) > limit

    async def iterate_records(self, wanted: AuditFilter) -> AsyncIterator[AuditRecord]:
        """Go through all rows that are meant, newest first, with few of them in memory."""
        more = True
        while more:
            rows, more = await self.find_records(wanted, _PAGE)
            for row in rows:
                yield row
            if rows:
                # By number, not by offset: what is added meanwhile shifts nothing.
                wanted = replace(wanted, before=rows[-1].id)

    async def read_head(self) -> tuple[int, str]:
        """Give the number and the hash of the newest row; 0 where there is none."""
        async with self._database.read() as connection:
            query = select(audit_head.c.row_id, audit_head.c.hash)
            head = (await connection.execute(query)).first()
        return (int(head.row_id or 0), str(head.hash)) if head else (0, "")

    async def verify_chain(self, heads: Mapping[int, str] = _NO_HEADS) -> Chain:
        """Walk the chain from its beginning to its end, with few rows in memory.

        ``heads`` are hashes that rows had at some time, by their numbers: whoever has made the
        chain anew has others.
        """
        before, last, count = "", 0, 0
        passed: set[int] = set()
        async with self._database.read() as connection:
            # Asked first: what is appended during the walk lies behind it.
            head = (
                await connection.execute(select(audit_head.c.row_id, audit_head.c.hash))
            ).first()
        end, end_hash = (head.row_id, head.hash) if head else (0, "")
        while True:
            async with self._database.read() as connection:
                found = await connection.execute(
                    select(audit.c.id, audit.c.hash, *_COLUMNS)
                    .where(audit.c.id > last, audit.c.id <= end)
                    .order_by(audit.c.id)
                    .limit(_PAGE)
                )
                rows = found.all()
            for row in rows:
                fits = chain_hash(before, AuditEntry(*row[2:])) == row.hash
                if not fits or heads.get(row.id, row.hash) != row.hash:
                    return Chain(count, int(row.id), len(passed))
                before, last, count = row.hash, row.id, count + 1
                if row.id in heads:
                    passed.add(row.id)
            if not rows:
                break
            # A long log must not keep the others waiting.
            await asyncio.sleep(0)
        # Another end than the head's: rows at the end were cut off.
        if before != end_hash:
            return Chain(count, end or 1, len(passed))
        # Signed heads of rows that are not there, though all that are fit.
        missing = heads.keys() - passed
        return Chain(count, min(missing, default=0), len(passed))


_COLUMNS = tuple(audit.c[name] for name in AuditEntry._fields)


async def append_entries(connection: AsyncConnection, batch: Sequence[AuditEntry]) -> None:
    """Write rows in a transaction that writes; their texts must have passed `safe_text`."""
    # Locked before it is read, or two hubs would build on the same row.
    head = select(audit_head.c.hash).where(audit_head.c.id == _HEAD).with_for_update()
    before = (await connection.execute(head)).scalar_one()
    rows = []
    for entry in batch:
        before = chain_hash(before, entry)
        rows.append({**entry._asdict(), "hash": before})
    await connection.execute(insert(audit), rows)
    last = select(func.max(audit.c.id)).scalar_subquery()
    await connection.execute(
        update(audit_head).where(audit_head.c.id == _HEAD).values(row_id=last, hash=before)
    )
