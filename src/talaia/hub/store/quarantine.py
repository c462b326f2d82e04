"""A database file that is damaged is set aside at the start, never deleted and never repaired."""

from __future__ import annotations

import logging
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import make_url

if TYPE_CHECKING:
    from talaia.clock import Clock

__all__ = ["set_aside_if_damaged"]

_LOG = logging.getLogger(__name__)
# A larger file takes too long to be read through at each start. Of it all but these tables is
# looked at: without the rest nothing works, while what is damaged in these is a part of the
# samples or of the log, and the others are still to be had.
_READ_THROUGH = 64 * 1024 * 1024
_BULKY = frozenset(
    {"audit", "history_block", "history_body", "history_hot", "history_recent", "history_rollup"}
)
# "malformed" and "not a database"; anything else (no right, no room) is not the file's fault.
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB}


def set_aside_if_damaged(url: str, clock: Clock, read_through: int = _READ_THROUGH) -> Path | None:
    """Rename a damaged SQLite database, so that the hub can start with a new one.

    Nothing else is touched: what stands beside it (recordings, backups) is as it was.

    Args:
        url: the database's.
        clock: stamps the new name.
        read_through: a file of so many bytes is looked at as a whole.

    Returns:
        Where it is now; None if it is sound, not there, or on a server.

    """
    parsed = make_url(url)
    if parsed.get_backend_name() != "sqlite" or not parsed.database:
        return None
    path = Path(parsed.database)
    if not path.is_file():
        return None
    problem = _find_problem(path, read_through)
    if not problem:
        return None
    aside = path.with_name(f"{path.name}.damaged-{clock.wall_ns() // 1_000_000_000}")
    for end in ("-wal", "-shm", ""):
        part = path.with_name(path.name + end)
        if part.exists():
            part.rename(aside.with_name(aside.name + end))
    _LOG.error(
        "the database %s is damaged (%s); it is kept as %s and a new, empty one is begun. "
        "`talaia restore` brings back a backup; `sqlite3 FILE .recover` saves what can be read",
        path,
        problem,
        aside,
    )
    return aside


def _find_problem(path: Path, read_through: int) -> str:
    try:
        with closing(sqlite3.connect(path)) as database:
            listed = database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
            tables = sorted({name for (name,) in listed} - _BULKY)
            if path.stat().st_size <= read_through:
                return _check_table(database, "1")
            for table in tables:
                # A damaged file may name its tables anything: a quote is doubled.
                if problem := _check_table(database, f"'{table.replace(chr(39), chr(39) * 2)}'"):
                    return problem
    except sqlite3.DatabaseError as error:
        # The low byte of an extended code is its kind.
        return str(error) if error.sqlite_errorcode & 0xFF in _DAMAGED else ""
    return ""


def _check_table(database: sqlite3.Connection, about: str) -> str:
    """Check a table, or with ``1`` all of it up to the first mistake; empty when it is sound."""
    for (said,) in database.execute(f"PRAGMA quick_check({about})"):
        if said != "ok":
            return str(said).replace("\n", " ")
    return ""
