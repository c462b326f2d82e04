"""A backup: a folder with one SQLite file and whatever else stands in the data folder.

It is taken while the hub runs. A database on a server is copied, table by table and as it is at
one moment, into a SQLite file of the same form, so that a backup can be restored into any of the
databases. A restored data folder takes effect when the hub starts next: until then it waits in a
folder of its own, and the hub that may be running is not disturbed.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import create_engine, inspect, make_url, select
from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import StoreError
from talaia.hub.lock import LOCK
from talaia.hub.store.dialects.sqlite import copy_file
from talaia.hub.store.dump import VERSION_TABLE, copy_tables, open_plain
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from talaia.clock import Clock

__all__ = [
    "DATABASE",
    "WAITING",
    "histories_elsewhere",
    "restore_folder",
    "restore_server",
    "take_restored",
    "write_backup",
]

_LOG = logging.getLogger(__name__)
DATABASE = "talaia.db"
WAITING = "restore"
_MANIFEST = "backup.json"
# Not copied: the lock of who runs now, imports on their way, whose files people still have, and
# copies of what is in a bucket.
_NOT_KEPT = frozenset((LOCK, "import", "copies"))
# How a backup's folder is laid out; other numbers are refused.
_FORM = 1


def write_backup(url: str, data: Path, target: Path, clock: Clock) -> Path:
    """Write a backup into the folder ``target``, which must not be there yet.

    Args:
        url: the database's URL, as a person writes it.
        data: the hub's data folder.
        target: appears as a whole once the backup is complete.
        clock: stamps it.

    Raises:
        StoreError: it cannot be written, or the database cannot be read.

    """
    if target.exists():
        raise StoreError(f"{target} is there already", "name a folder that is not there yet")
    # Under another name first: a folder that has its final name is whole.
    partial = target.with_name(target.name + ".partial")
    try:
        if partial.exists():
            shutil.rmtree(partial)
        partial.mkdir(mode=0o700, parents=True)
        version = _copy_database(url, partial / DATABASE)
        _copy_rest(data, partial)
        about = {"form": _FORM, "time_us": clock.wall_ns() // 1000, "database": version}
        (partial / _MANIFEST).write_text(json.dumps(about) + "\n")
        # On disk before it gets that name.
        _sync_folder(partial)
        partial.rename(target)
    except (OSError, sqlite3.Error, SQLAlchemyError) as error:
        reason = getattr(error, "orig", None) or error
        raise StoreError(f"the backup cannot be written: {reason}") from error
    return target


def histories_elsewhere(backup: Path) -> dict[str, list[str]]:
    """Give by server the sites whose history was on it, and is not in a backup."""
    with closing(sqlite3.connect(f"file:{backup / DATABASE}?mode=ro", uri=True)) as database:
        found: dict[str, list[str]] = {}
        # A version before this one has no such table, and all histories in its own database.
        known = "SELECT name FROM sqlite_master WHERE type = 'table' AND name = 'history_homes'"
        if database.execute(known).fetchone() is None:
            return found
        rows = database.execute("SELECT server, site FROM history_homes ORDER BY server, site")
        for server, site in rows:
            if server != OWN:
                found.setdefault(server, []).append(site)
    return found


def restore_folder(source: Path, data: Path) -> Path:
    """Put a backup where the hub takes it over at its next start.

    Raises:
        StoreError: it is no backup, is damaged, or cannot be copied.

    """
    _check_backup(source)
    waiting = data / WAITING
    partial = data / f"{WAITING}.partial"
    try:
        for folder in (partial, waiting):
            if folder.exists():
                shutil.rmtree(folder)
        shutil.copytree(source, partial)
        _sync_folder(partial)
        partial.rename(waiting)
    except OSError as error:
        raise StoreError(f"the backup cannot be copied into {data}: {error}") from error
    return waiting


def take_restored(data: Path, clock: Clock) -> Path | None:
    """Take over a restored data folder if one waits; what was there before is kept aside.

    Returns:
        The folder that holds what was there before.

    Raises:
        StoreError: files cannot be moved.

    """
    waiting = data / WAITING
    if not (waiting / _MANIFEST).exists():
        return None
    aside = data / f"before-restore-{clock.wall_ns() // 1_000_000_000}"
    try:
        aside.mkdir(mode=0o700, exist_ok=True)
        names = {file.name for file in waiting.iterdir()} - {_MANIFEST}
        # A journal of the old database must never be applied to the restored one.
        names |= {DATABASE + end for end in ("-wal", "-shm")}
        for name in sorted(names):
            # A start that was broken off here goes on at the next: what is moved is not here.
            if (data / name).exists() and not (aside / name).exists():
                (data / name).rename(aside / name)
            if (waiting / name).exists():
                (waiting / name).rename(data / name)
        shutil.rmtree(waiting)
    except OSError as error:
        raise StoreError(f"the restored files cannot be moved into {data}: {error}") from error
    _LOG.warning("a backup was restored; what was there before is in %s", aside)
    return aside


def restore_server(source: Path, url: str) -> int:
    """Load a backup into a server's database that is migrated and has no people yet.

    Returns:
        How many rows there are.

    Raises:
        StoreError: it is no backup, of another version, or the database is in use.

    """
    _check_backup(source)
    origin = open_plain(f"sqlite:///{source / DATABASE}")
    target = open_plain(url)
    try:
        with origin.connect() as reading, target.begin() as writing:
            theirs, ours = _schema_version(reading), _schema_version(writing)
            if theirs != ours:
                raise StoreError(
                    f"the backup's tables are of version {theirs}, this program's of {ours}",
                    "restore it with the program that wrote it, then update",
                )
            # A wrong URL must not destroy a database that is in use.
            if writing.execute(select(metadata.tables["users"]).limit(1)).first() is not None:
                raise StoreError(
                    f"the database {make_url(url).render_as_string()} has people in it already",
                    "restore into an empty database, and start the hub with that",
                )
            rows = copy_tables(reading, writing)
            # Views are made anew when the hub starts.
            writing.execute(metadata.tables["history_sensor"].delete())
            return rows
    except SQLAlchemyError as error:
        reason = getattr(error, "orig", None) or error
        raise StoreError(f"the backup cannot be restored: {reason}") from error
    finally:
        origin.dispose()
        target.dispose()


def _copy_database(url: str, file: Path) -> str:
    parsed = make_url(url)
    if parsed.get_backend_name() == "sqlite":
        path = Path(parsed.database or "")
        if not path.exists():
            raise StoreError(f"there is no database {path}", "check --data")
        return copy_file(path, file)
    source = open_plain(url)
    target = create_engine(f"sqlite:///{file}")
    try:
        with source.connect() as reading, target.begin() as writing:
            metadata.create_all(writing)
            VERSION_TABLE.create(writing)
            copy_tables(reading, writing)
            return _schema_version(reading)
    finally:
        source.dispose()
        target.dispose()


def _schema_version(connection: Connection) -> str:
    if not inspect(connection).has_table(VERSION_TABLE.name):
        raise StoreError("the database has no tables of ours", "start the hub with it once")
    return str(connection.scalar(select(VERSION_TABLE.c.version_num)) or "")


def _copy_rest(data: Path, target: Path) -> None:
    for path in sorted(data.iterdir()):
        # The target may lie within the data folder, and must not be copied into itself.
        ours = path.name.startswith((DATABASE, WAITING, "before-restore-"))
        ours = ours or path.name in _NOT_KEPT
        if ours or path.resolve() in {target.resolve(), *target.resolve().parents}:
            continue
        if path.is_dir():
            shutil.copytree(path, target / path.name, copy_function=_copy_file)
        elif path.is_file():
            shutil.copy2(path, target / path.name)


def _copy_file(source: str, target: str) -> str:
    try:
        return shutil.copy2(source, target)
    except FileNotFoundError:
        # The hub runs: a recording that was deleted meanwhile is none to keep.
        return target


def _check_backup(source: Path) -> None:
    try:
        about = json.loads((source / _MANIFEST).read_text())
        form = about["form"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise StoreError(
            f"{source} is no backup: {error}", "name a folder that `talaia backup` has written"
        ) from error
    if form != _FORM:
        raise StoreError(f"the backup {source} has form {form}, this program reads {_FORM}")
    try:
        # To look at a backup must not change it.
        with closing(sqlite3.connect(f"file:{source / DATABASE}?mode=ro", uri=True)) as database:
            (said,) = database.execute("PRAGMA quick_check(1)").fetchone()
    except sqlite3.Error as error:
        raise StoreError(f"the backup's database is damaged: {error}") from error
    if said != "ok":
        raise StoreError(f"the backup's database is damaged: {said}")


def _sync_folder(folder: Path) -> None:
    for path in [*folder.rglob("*"), folder]:
        number = os.open(path, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
