"""Rows of what is lost for good."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import insert, select

from talaia.hub.history.errors import HistoryError
from talaia.hub.store import history_tables as tables

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from talaia.hub.history.writing.writer_jobs import GapJob

__all__ = ["gap_row", "write_gap"]


def gap_row(job: GapJob) -> dict[str, Any]:
    """Give what the table holds of a gap, less whose it is.

    Raises:
        HistoryError: it ends before it begins.
        UnicodeEncodeError: its reason is not Unicode.

    """
    if not 0 <= job.first <= job.last + 1 or job.from_us > job.to_us:
        raise HistoryError(
            f"a gap from {job.first} to {job.last}, {job.from_us} to {job.to_us} µs, ends "
            "before it begins"
        )
    job.reason.encode()
    return {
        "first_seq": job.first,
        "last_seq": job.last,
        "from_us": job.from_us,
        "to_us": job.to_us,
        # PostgreSQL's texts hold no zero byte.
        "reason": job.reason.replace("\0", "�"),
    }


def write_gap(connection: Connection, row: dict[str, Any]) -> None:
    """Write a gap unless it is there; the caller commits."""
    table = tables.gap
    key = ("boot_id", "first_seq", "last_seq", "from_us")
    same = [table.c[name] == row[name] for name in key]
    if connection.execute(select(table.c.boot_id).where(*same)).first() is None:
        connection.execute(insert(table), row)
