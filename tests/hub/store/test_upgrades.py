"""Databases of earlier versions go on, those of later ones are told, and a backup leads back."""

import sqlite3
from contextlib import closing

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from sqlalchemy import create_engine, inspect

from talaia.cli.main import main
from talaia.clock import HandClock
from talaia.hub.auth.passwords import Passwords
from talaia.hub.errors import StoreError
from talaia.hub.store import database as database_module
from talaia.hub.store.backup import take_restored
from talaia.hub.store.database import Database
from talaia.hub.store.tables import metadata

from ..chromium import PASSWORD
from ..conftest import MemoryHistory, RunningHub

# The first, one in the middle of each larger change, and the last but one.
REVISIONS = ("0001", "0010", "0020", "0030", "0040")


def make_older(file, revision: str, hashed: str) -> None:
    """Make a database as the program of that time left it, with a person and a site in it."""
    file.unlink(missing_ok=True)
    config = Config()
    config.set_main_option("script_location", str(database_module._MIGRATIONS))
    engine = create_engine(f"sqlite:///{file}")
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
        role = connection.scalar(sa.text("SELECT id FROM roles WHERE name = 'operator'"))
        who = {"id": 7, "name": "ada", "name_key": "ada", "role_id": role}
        insert_row(connection, "users", password_hash=hashed, **who)
        insert_row(connection, "sites", site="agv", description="talaia: 1")
    engine.dispose()


def insert_row(connection: sa.Connection, table: str, **values: object) -> None:
    """Insert a row; columns of that time that are not named get a zero or an empty text."""
    columns = {}
    for column in inspect(connection).get_columns(table):
        if column["name"] in values:
            columns[column["name"]] = values[column["name"]]
        elif not column["nullable"] and column["default"] is None:
            is_text = isinstance(column["type"], sa.String | sa.Text)
            columns[column["name"]] = "" if is_text else 0
    assert set(values) <= set(columns), (set(values) - set(columns), table)
    reflected = sa.Table(table, sa.MetaData(), autoload_with=connection)
    connection.execute(reflected.insert().values(**columns))


@pytest.mark.parametrize("revision", REVISIONS)
async def test_a_hub_goes_on_with_the_database_of_an_earlier_version(
    settings, tmp_path, revision
) -> None:
    make_older(tmp_path / "talaia.db", revision, await Passwords(4).hash_password(PASSWORD))
    async with RunningHub(settings, MemoryHistory()) as hub:
        # A person of then signs in with the password of then.
        client = await hub.client("ada")
        assert (await client.get("/api/me")).json()["name"] == "ada"
        assert (await client.get("/api/sites")).status_code == 200
    with closing(sqlite3.connect(tmp_path / "talaia.db")) as database:
        there = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
        assert set(metadata.tables) <= there
        assert database.execute("SELECT description FROM sites").fetchall() == [("talaia: 1",)]
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)


async def test_a_database_of_a_later_version_is_left_as_it_is_and_told(database_url) -> None:
    database = Database(database_url)
    await database.migrate()
    async with database.write() as connection:
        await connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(StoreError, match=r"version 9999.*newer than this program") as refused:
        await database.migrate()
    assert "talaia restore" in str(refused.value)
    async with database.read() as connection:
        assert await connection.scalar(sa.text("SELECT version_num FROM alembic_version")) == "9999"
    await database.close()


async def test_the_backup_of_before_leads_back(tmp_path, capsys) -> None:
    data, backup = tmp_path / "data", tmp_path / "before"
    data.mkdir()
    make_older(data / "talaia.db", "0040", await Passwords(4).hash_password(PASSWORD))
    assert main(["backup", str(backup), "--data", str(data)]) == 0
    database = Database(f"sqlite:///{data}/talaia.db")
    await database.migrate()
    await database.close()
    with closing(sqlite3.connect(data / "talaia.db")) as upgraded:
        assert upgraded.execute("SELECT version_num FROM alembic_version").fetchone() > ("0040",)
    assert main(["restore", str(backup), "--data", str(data)]) == 0
    # What a hub does when it starts next, of whatever version it is.
    take_restored(data, HandClock())
    with closing(sqlite3.connect(data / "talaia.db")) as restored:
        assert restored.execute("SELECT version_num FROM alembic_version").fetchone() == ("0040",)
        assert restored.execute("SELECT name FROM users").fetchall() == [("ada",)]
