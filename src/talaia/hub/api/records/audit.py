"""The audit log as an admin reads it: filtered, as a file, and held against its own chain."""

from __future__ import annotations

import asyncio
import csv
import datetime as dt
import io
from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import StreamingResponse

from talaia.hub.api.access import address_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.common import AuditAsk, AuditChain, AuditList, AuditPage, AuditRow
from talaia.hub.errors import CannotStart
from talaia.hub.store.audit import AuditEntry, AuditFilter
from talaia.hub.store.safe_text import safe_cell

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterable, Mapping

    from talaia.hub.store.audit import Audit, AuditRecord

__all__ = ["AuditPages"]

# Characters that are gathered before they are sent.
_CHUNK = 64 * 1024
_HEAD = ("id", "time_utc", *AuditEntry._fields)  # as `_csv_cells` orders them


class AuditPages:
    """The routes of the audit log."""

    def __init__(self, audit: Audit, read_heads: Callable[[], Mapping[int, str]]) -> None:
        """Read from ``audit``; that somebody took a copy is written there, too.

        ``read_heads`` gives the signed heads that lie outside the database; it waits for a disk.
        """
        self._audit = audit
        self._read_heads = read_heads

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/audit")(self.rows)
        router.get("/api/audit/export", response_class=StreamingResponse)(self.export)
        router.get("/api/audit/verify")(self.verify)
        return router

    async def rows(self, asked: Annotated[AuditPage, Query()]) -> AuditList:
        """List what happened, newest first."""
        # Notes are written a moment later: who looks at once should find what was just done.
        await self._audit.wait_written()
        rows, more = await self._audit.find_records(_audit_filter(asked), asked.limit)
        return AuditList(rows=[_row_schema(row) for row in rows], more=more)

    async def export(
        self, request: Request, asked: Annotated[AuditAsk, Query()]
    ) -> StreamingResponse:
        """Give the rows as a CSV file, newest first. Cells that look like formulas get a '."""
        # Which rows were taken, so that the log says what has left the hub.
        said = ", ".join(f"{key}={value}" for key, value in asked.model_dump().items() if value)
        name = who_of(request).name
        self._audit.append_record(
            "audit exported", who=name, address=address_of(request), message=said
        )
        await self._audit.wait_written()
        return StreamingResponse(
            # Row by row: a log of years does not fit in memory.
            _write_csv(self._audit.iterate_records(_audit_filter(asked))),
            media_type="text/csv; charset=utf-8",
            headers={"Content-Disposition": 'attachment; filename="talaia-audit.csv"'},
        )

    async def verify(self, request: Request) -> AuditChain:
        """Say whether a row was changed or is missing, since the first one.

        The chain must pass the signed heads that this hub has kept, too.
        """
        await self._audit.wait_written()
        heads: Mapping[int, str] = {}
        problem = ""
        try:
            heads = await asyncio.to_thread(self._read_heads)
        except (OSError, ValueError, CannotStart) as error:
            problem = str(error)[:500]
        found = await self._audit.verify_chain(heads)
        said = f"{found.rows} rows, {found.heads} signed heads"
        said += f", broken at {found.broken}" if found.broken else ""
        said += f"; {problem}" if problem else ""
        self._audit.append_record(
            "audit verified",
            who=who_of(request).name,
            address=address_of(request),
            message=said,
            # What was found is itself a row, after those that were looked at.
            good=not found.broken and not problem,
        )
        return AuditChain(
            ok=not found.broken and not problem,
            rows=found.rows,
            broken=found.broken,
            heads=found.heads,
            problem=problem,
        )


def _audit_filter(asked: AuditAsk) -> AuditFilter:
    return AuditFilter(**asked.model_dump(exclude={"limit"}))


def _row_schema(row: AuditRecord) -> AuditRow:
    return AuditRow(id=str(row.id), **row.entry._asdict())


async def _write_csv(rows: AsyncIterator[AuditRecord]) -> AsyncIterator[str]:
    buffer = io.StringIO(newline="")
    lines = csv.writer(buffer)
    lines.writerow(_HEAD)
    async for row in rows:
        lines.writerow(_csv_cells(row))
        if buffer.tell() > _CHUNK:
            yield buffer.getvalue()
            buffer.seek(0)
            buffer.truncate()
    yield buffer.getvalue()


def _csv_cells(row: AuditRecord) -> Iterable[str | int]:
    entry = row.entry
    time = dt.datetime.fromtimestamp(entry.time_us / 1e6, dt.UTC).isoformat(timespec="milliseconds")
    return [
        row.id,
        time,
        # A spreadsheet would run a cell that begins like a formula.
        *(safe_cell(cell) if isinstance(cell, str) else int(cell) for cell in entry),
    ]
