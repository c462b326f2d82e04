"""A history to test with, on each database that is there.

SQLite always; a server's if TALAIA_TEST_POSTGRESQL or TALAIA_TEST_MARIADB holds its URL, for
example ``postgresql+psycopg://user@127.0.0.1/test`` and ``mysql+pymysql://user@127.0.0.1/test``.
Each test gets a database of its own there, and drops it.
"""

import os
from contextlib import asynccontextmanager

import pytest
import sqlalchemy as sa

from talaia.clock import SystemClock
from talaia.hub.history.limits import Limits
from talaia.hub.history.store import HistoryStore

# So small that a few hundred samples go through all that a year of them goes through.
SMALL = Limits(block=32, recent=16, journal=200, delete=2, raw=200, texts=300, linger_s=0.0)


@asynccontextmanager
async def opened(url, limits=SMALL):
    store = HistoryStore(url, SystemClock(), limits)
    await store.create_tables()
    await store.open()
    try:
        yield store
    finally:
        await store.close()


@pytest.fixture(params=["sqlite", "postgresql", "mariadb"])
def url(request, tmp_path):
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path}/history.db"
        return
    server = os.environ.get(f"TALAIA_TEST_{request.param.upper()}")
    if not server:
        pytest.skip(f"TALAIA_TEST_{request.param.upper()} names no server")
    name = f"talaia_test_{os.getpid()}"
    engine = sa.create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE IF EXISTS {name}")
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    yield sa.make_url(server).set(database=name).render_as_string(hide_password=False)
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE {name}")
    engine.dispose()
