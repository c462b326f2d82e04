"""A history to test with, on each database that is there.

SQLite always; a server's where one answers on this machine, or at the URL that
TALAIA_TEST_POSTGRESQL or TALAIA_TEST_MARIADB holds. Each test gets a database of its own there,
and drops it.
"""

import functools
import os
from contextlib import asynccontextmanager

import pytest
import sqlalchemy as sa

from talaia.clock import SystemClock
from talaia.hub.history.limits import Limits
from talaia.hub.history.store import HistoryStore

# So small that a few hundred samples go through all that a year of them goes through.
SMALL = Limits(
    block=32, recent=16, journal=200, delete=2, raw=200, texts=300, linger_s=0.0, show_s=0.0
)


@asynccontextmanager
async def opened(url, limits=SMALL):
    store = HistoryStore(url, SystemClock(), limits)
    await store.create_tables()
    await store.open()
    try:
        yield store
    finally:
        await store.close()


SERVERS = {
    "postgresql": "postgresql+pg8000://postgres@127.0.0.1/postgres",
    "mariadb": "mysql+pymysql://root@127.0.0.1/mysql",
}


@functools.cache
def server_of(kind):
    """Give the URL of a server that answers, or why there is none."""
    url = os.environ.get(f"TALAIA_TEST_{kind.upper()}") or SERVERS[kind]
    engine = sa.create_engine(url)
    try:
        engine.connect().close()
    except (sa.exc.SQLAlchemyError, OSError) as error:
        return "", f"no {kind} answers at {url}: {str(error).splitlines()[0]}"
    finally:
        engine.dispose()
    return url, ""


@pytest.fixture(params=["sqlite", "postgresql", "mariadb"])
def url(request, tmp_path):
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path}/history.db"
        return
    server, why = server_of(request.param)
    if why:
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)(why)
    name = f"talaia_test_{os.getpid()}"
    engine = sa.create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE IF EXISTS {name}")
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    yield sa.make_url(server).set(database=name).render_as_string(hide_password=False)
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE {name}")
    engine.dispose()
