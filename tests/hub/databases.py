"""A database to test with, of each kind that is there; made for one test, and dropped after it.

SQLite always; a server's where one answers on this machine, or at the URL that
TALAIA_TEST_POSTGRESQL or TALAIA_TEST_MARIADB holds.
"""

from __future__ import annotations

import functools
import os
import uuid

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


@pytest.fixture(params=["sqlite", "postgresql", "mariadb"])
def database_url(request, tmp_path):
    """Give the URL of an empty database, as a user would write it."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path}/talaia.db"
        return
    server, why = server_of(request.param)
    if why:
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)(why)
    name = f"talaia_test_{uuid.uuid4().hex[:12]}"
    engine = sa.create_engine(server, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    url = sa.make_url(server).set(database=name, drivername=request.param)
    yield url.render_as_string(hide_password=False)
    with engine.connect() as connection:
        connection.exec_driver_sql(f"DROP DATABASE {name}")
    engine.dispose()


@pytest.fixture
async def database(database_url):
    database = Database(database_url)
    await database.migrate()
    yield database
    await database.close()
