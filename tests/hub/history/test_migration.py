"""The migration makes the tables that the program expects."""

import importlib

import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.operations import Operations

from talaia.clock import SystemClock
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database
from talaia.hub.store.history_tables import HISTORY_TABLES
from talaia.hub.store.tables import metadata

from .samples import ALL, batch

VERSIONS = "talaia.hub.store.migrations.versions"
NAMES = ("0002_history", "0010_history_views", "0014_sensor_kinds", "0045_history_servers")
steps = [importlib.import_module(f"{VERSIONS}.{name}") for name in NAMES]


def test_migrated_tables_are_the_tables_in_the_program(url) -> None:
    engine = sa.create_engine(url)
    ours = {table.name for table in HISTORY_TABLES}
    with engine.begin() as connection:
        context = MigrationContext.configure(connection)
        with Operations.context(context):
            for step in steps:
                step.upgrade()
        differences = compare_metadata(context, metadata)
        assert not [each for each in differences if any(name in repr(each) for name in ours)]
        with Operations.context(context):
            for step in reversed(steps):
                step.downgrade()
        assert not ours & set(sa.inspect(connection).get_table_names())
    engine.dispose()


async def test_history_opens_in_a_database_that_the_hub_has_migrated(tmp_path) -> None:
    database = Database(f"sqlite+aiosqlite:///{tmp_path}/talaia.db")
    await database.migrate()
    await database.close()
    store = HistoryStore(f"sqlite:///{tmp_path}/talaia.db", SystemClock())
    await store.open()
    await store.append_samples("agv", "b", 0, addresses=["a/x"], columns=batch([(0, 1, 2.0)]))
    (series,) = await store.read_series("agv", ["a/x"], *ALL, width=10)
    assert series.value.tolist() == [2.0]
    await store.close()
