"""A database to test with, of each kind that is there; made for one test, and dropped after it.

SQLite always; a server's where one answers on this machine, or at the URL that
TALAIA_TEST_POSTGRESQL or TALAIA_TEST_MARIADB holds.

To make the tables takes longer than most tests: they are made once for each run, and copied; and
MariaDB, which makes each table of a copy anew, gets its copies back for the next test. That tables
are made from nothing is `test_database`'s and `test_run_on_databases`'s to see.

A run that is killed drops nothing. So each run holds a lock on the server for as long as it lives,
and has the lock's number in the names of its databases; what belongs to a lock that nobody holds
is dropped by the next run.
"""

from __future__ import annotations

import asyncio
import atexit
import contextlib
import functools
import os
import re
import secrets
import shutil
import tempfile
from pathlib import Path

import pytest
import sqlalchemy as sa

from talaia.hub.store.database import Database

SERVERS = {
    "postgresql": "postgresql+pg8000://postgres@127.0.0.1/postgres",
    "mariadb": "mysql+pymysql://root@127.0.0.1/mysql",
}


@functools.cache
def server_of(kind: str) -> tuple[str, str]:
    url = os.environ.get(f"TALAIA_TEST_{kind.upper()}") or SERVERS[kind]
    engine = sa.create_engine(url)
    try:
        engine.connect().close()
    except (sa.exc.SQLAlchemyError, OSError) as error:
        return "", f"no {kind} answers at {url}: {str(error).splitlines()[0]}"
    finally:
        engine.dispose()
    return url, ""


_LOCK = {
    "postgresql": ("SELECT pg_try_advisory_lock(%s)", "SELECT pg_advisory_unlock(%s)"),
    "mariadb": ("SELECT GET_LOCK(%s, 0)", "SELECT RELEASE_LOCK(%s)"),
}
_LIST = {"postgresql": "SELECT datname FROM pg_database", "mariadb": "SHOW DATABASES"}
_NAME = re.compile(r"talaia_run_([0-9a-f]{8})_[0-9a-f]{8}")


class Run:
    """What one run of the tests has on a server.

    Attributes:
        number: the lock that it holds; eight hex digits in the names of its databases.

    """

    def __init__(self, kind: str, url: str) -> None:
        """Take a lock on the server of this kind at ``url``, and tidy up."""
        self._kind = kind
        self._engine = sa.create_engine(url, isolation_level="AUTOCOMMIT", pool_size=1)
        # The lock is the connection's: it goes with the process, however that ends.
        self._connection = self._engine.connect()
        # Databases that tests have returned, as the origin is.
        self._returned: list[str] = []
        self.number = secrets.token_hex(4)
        assert self.hold(self.number)
        self.tidy()

    def hold(self, number: str) -> bool:
        """Take a lock; False when a living run has it."""
        return bool(self.execute(_LOCK[self._kind][0], self._key(number)).scalar())

    def tidy(self) -> None:
        """Drop the databases of runs that have ended."""
        for name in self.names():
            match = _NAME.fullmatch(name)
            if match and match[1] != self.number and self.hold(match[1]):
                # Another run that tidies up may be quicker.
                self.execute(f"DROP DATABASE IF EXISTS {name}")
                self.execute(_LOCK[self._kind][1], self._key(match[1]))

    def names(self) -> list[str]:
        """List the server's databases."""
        return [row[0] for row in self.execute(_LIST[self._kind])]

    def make(self) -> str:
        """Make an empty database."""
        name = self._new_name()
        self.execute(f"CREATE DATABASE {name}")
        return name

    def _new_name(self) -> str:
        return f"talaia_run_{self.number}_{secrets.token_hex(4)}"

    def copy(self, origin: str) -> str:
        """Make a database with the tables of another, and what is in them."""
        if self._kind == "postgresql":
            name = self._new_name()
            self.execute(f"CREATE DATABASE {name} TEMPLATE {origin}")
            return name
        name = self.make()
        # Whatever refers to a table may come before it.
        self.execute("SET foreign_key_checks = 0")
        self.execute(f"USE {name}")
        for (table,) in self.execute(f"SHOW TABLES FROM {origin}").all():
            self.execute(
                self.execute(f"SHOW CREATE TABLE {origin}.{table}").one()[1].replace("%", "%%")
            )
            self.execute(f"INSERT INTO {table} SELECT * FROM {origin}.{table}")  # noqa: S608 - names of ours
        return name

    def lend(self, origin: str) -> str:
        """Give a database that is as ``origin``: one that was returned, or a new copy."""
        return self._returned.pop() if self._returned else self.copy(origin)

    def take_back(self, name: str, origin: str) -> None:
        """Keep a database for the next test, as ``origin`` again; drop it where that cannot be."""
        # PostgreSQL copies a database as files, which is no more work than to tidy one up.
        if self._kind == "mariadb" and self._restore(name, origin):
            self._returned.append(name)
        else:
            self.drop(name)

    def _restore(self, name: str, origin: str) -> bool:
        """Make a database hold what ``origin`` holds; False where it has other tables."""
        counters = self.counters(name)
        before = self.counters(origin)
        if counters.keys() != before.keys():
            return False
        filled = (
            f"SELECT '{table}', EXISTS(SELECT 1 FROM {name}.{table}),"  # noqa: S608 - names of ours
            f" EXISTS(SELECT 1 FROM {origin}.{table})"
            for table in counters
        )
        self.execute("SET foreign_key_checks = 0")
        self.execute("START TRANSACTION")
        for table, here, there in self.execute(" UNION ALL ".join(filled)).all():
            if here:
                self.execute(f"DELETE FROM {name}.{table}")  # noqa: S608 - names of ours
            if there:
                self.execute(f"INSERT INTO {name}.{table} SELECT * FROM {origin}.{table}")  # noqa: S608 - names of ours
        self.execute("COMMIT")
        for table, number in before.items():
            if counters[table] != number:
                self.execute(f"ALTER TABLE {name}.{table} AUTO_INCREMENT = {number}")
        return True

    def counters(self, name: str) -> dict[str, int | None]:
        """Give the number that the next row of each table gets; None where rows have none."""
        rows = self.execute(
            "SELECT table_name, auto_increment FROM information_schema.tables"
            " WHERE table_schema = %s",
            name,
        )
        return dict(rows.all())

    def drop_returned(self) -> None:
        """Drop what waits for a next test."""
        while self._returned:
            self.drop(self._returned.pop())

    def drop(self, name: str) -> None:
        self.execute(f"DROP DATABASE IF EXISTS {name}")

    def end(self) -> None:
        """End as a run ends that is killed: nothing is dropped."""
        # A server takes a moment to see that a connection is gone; a test does not wait for it.
        self.execute(_LOCK[self._kind][1], self._key(self.number))
        self._connection.close()
        self._engine.dispose()

    def _key(self, number: str) -> int | str:
        return int(number, 16) if self._kind == "postgresql" else f"talaia_run_{number}"

    def execute(self, statement: str, *parts: object) -> sa.CursorResult:
        return self._connection.exec_driver_sql(statement, parts)


@functools.cache
def run_of(kind: str) -> Run:
    return Run(kind, server_of(kind)[0])


def servers_url(kind: str, name: str) -> str:
    """Give a database's URL, as a user would write it; without TLS, which costs a start 15 ms."""
    url = sa.make_url(server_of(kind)[0]).set(
        database=name, drivername=kind, query={"sslmode": "disable"}
    )
    return url.render_as_string(hide_password=False)


def needed_run_of(kind: str) -> Run:
    """Give this run on a server, or skip."""
    _, why = server_of(kind)
    if why:
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)(why)
    return run_of(kind)


@contextlib.contextmanager
def empty_database(kind: str):
    """Make a database on a server, or skip; give its URL."""
    run = needed_run_of(kind)
    name = run.make()
    try:
        yield servers_url(kind, name)
    finally:
        run.drop(name)


@contextlib.contextmanager
def database_with_tables(kind: str, folder: Path):
    """Make a database with all tables and nothing in them, or skip; give its URL."""
    if kind == "sqlite":
        shutil.copy(origin_of(kind), folder / "talaia.db")
        yield f"sqlite:///{folder}/talaia.db"
        return
    run, origin = needed_run_of(kind), origin_of(kind)
    name = run.lend(origin)
    try:
        yield servers_url(kind, name)
    finally:
        run.take_back(name, origin)


@functools.cache
def origin_of(kind: str) -> str:
    """Make what is copied: the name of a server's database, or SQLite's file."""
    if kind == "sqlite":
        folder = tempfile.mkdtemp(prefix="talaia-test-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        found = f"{folder}/talaia.db"
        make_tables(f"sqlite:///{found}")
    else:
        found = run_of(kind).make()
        atexit.register(run_of(kind).drop, found)
        atexit.register(run_of(kind).drop_returned)
        make_tables(servers_url(kind, found))
    return found


def make_tables(url: str) -> None:
    async def make() -> None:
        database = Database(url)
        await database.migrate()
        await database.close()

    asyncio.run(make())


@pytest.fixture(params=["sqlite", "postgresql", "mariadb"])
def database_url(request, tmp_path):
    """Give a database's URL, as a user would write it: empty, but where `database` is asked."""
    if "database" in request.fixturenames:
        with database_with_tables(request.param, tmp_path) as url:
            yield url
    elif request.param == "sqlite":
        yield f"sqlite:///{tmp_path}/talaia.db"
    else:
        with empty_database(request.param) as url:
            yield url


@pytest.fixture
async def database(database_url):
    """Give a database that has all tables."""
    database = Database(database_url)
    yield database
    await database.close()
