"""The migration makes the tables that the program expects."""

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from talaia.clock import SystemClock
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database
from talaia.hub.store.history_tables import HISTORY_TABLES
from talaia.hub.store.tables import metadata

from .samples import ALL, batch

ASYNC = {"sqlite": "sqlite+aiosqlite", "postgresql": "postgresql+psycopg"}


async def test_migrated_tables_are_the_tables_in_the_program(url) -> None:
    name = sa.make_url(url).get_backend_name()
    if name not in ASYNC:
        pytest.skip("the hub's driver for MariaDB is another package")
    database = Database(
        sa.make_url(url).set(drivername=ASYNC[name]).render_as_string(hide_password=False)
    )
    await database.migrate()
    await database.close()
    engine = sa.create_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection)
        ours = {table.name for table in HISTORY_TABLES}
        differences = [
            each
            for each in compare_metadata(context, metadata)
            if any(table in repr(each) for table in ours)
        ]
        assert differences == []
    engine.dispose()
    store = HistoryStore(url, SystemClock())
    await store.open()
    await store.append("agv", "b", 0, ["a/x"], batch([(0, 1, 2.0)]))
    (series,) = await store.read("agv", ["a/x"], *ALL, 10)
    assert series.value.tolist() == [2.0]
    await store.close()
