"""Backups are taken while the hub writes, and come back; what is damaged is set aside."""

import asyncio
import sqlite3
from contextlib import closing

import pytest
import sqlalchemy as sa

from talaia.cli.main import main
from talaia.clock import HandClock, SystemClock
from talaia.hub.errors import StoreError
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.backup import restore_server, take_restored, write_backup
from talaia.hub.store.database import Database
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.quarantine import set_aside_if_damaged
from talaia.hub.store.tables import metadata
from talaia.wire.frames import Ack

from ..conftest import settings_in
from ..databases import SERVERS, empty_database
from ..history.samples import ALL, batch

NOW = 1_700_000_000_000_000


async def test_a_backup_of_a_running_hub_comes_back_as_it_was(hub_that_stores, tmp_path) -> None:
    target = tmp_path.parent / f"{tmp_path.name}-backup"
    async with hub_that_stores() as hub:
        await hub.populate()
        (tmp_path / "recordings").mkdir()
        (tmp_path / "recordings" / "one.mcap").write_bytes(b"mcap")
        # On their way, and of the running program: no part of a backup.
        (tmp_path / "import").mkdir(exist_ok=True)
        (tmp_path / "import" / "one.part").write_bytes(b"half")
        (tmp_path / "hub.lock").touch()
        gateway = await hub.gateway()
        await gateway.hello()
        await gateway.samples(*[("base/speed", NOW + at, at / 10) for at in range(50)])
        await gateway.hear(Ack, lambda ack: ack.below == 50)
        assert main(["backup", str(target), "--data", str(tmp_path)]) == 0
        assert not (target / "import").exists()
        assert not (target / "hub.lock").exists()
        await gateway.samples(("base/speed", NOW + 900, 9.0))
        await gateway.hear(Ack, lambda ack: ack.below == 51)
        # A restore beside a running hub waits for its next start.
        (tmp_path / "recordings" / "one.mcap").write_bytes(b"changed")
        assert main(["restore", str(target), "--data", str(tmp_path)]) == 0
        await gateway.samples(("base/speed", NOW + 901, 9.0))
        await gateway.hear(Ack, lambda ack: ack.below == 52)
    aside = take_restored(tmp_path, SystemClock())
    assert (aside / "talaia.db").exists()
    assert (tmp_path / "recordings" / "one.mcap").read_bytes() == b"mcap"
    assert (aside / "recordings" / "one.mcap").read_bytes() == b"changed"
    assert take_restored(tmp_path, SystemClock()) is None
    async with hub_that_stores() as hub:
        client = await hub.client("operator")
        query = {"channel": "base/speed", "from_us": NOW, "to_us": NOW + 1_000}
        (series,) = (await client.get("/api/sites/agv/history", params=query)).json()["series"]
        assert series["v"] == [at / 10 for at in range(50)]


def test_a_backup_is_never_written_over_and_never_half(tmp_path, capsys) -> None:
    (tmp_path / "there").mkdir()
    assert main(["backup", str(tmp_path / "there"), "--data", str(tmp_path)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["backup", str(tmp_path / "new"), "--data", str(tmp_path)]) == 2
    assert "there is no database" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
    assert main(["restore", str(tmp_path / "there"), "--data", str(tmp_path)]) == 2
    assert "is no backup" in capsys.readouterr().err


async def test_a_damaged_backup_is_not_restored(tmp_path, capsys) -> None:
    database = Database(f"sqlite+aiosqlite:///{tmp_path}/talaia.db")
    await database.migrate()
    await database.close()
    write_backup(f"sqlite:///{tmp_path}/talaia.db", tmp_path, tmp_path / "b", HandClock())
    file = tmp_path / "b" / "talaia.db"
    file.write_bytes(file.read_bytes()[:8192] + b"junk" * 5_000)
    assert main(["restore", str(tmp_path / "b"), "--data", str(tmp_path / "other")]) == 2
    assert "damaged" in capsys.readouterr().err
    assert not (tmp_path / "other" / "restore").exists()


async def migrate(url):
    database = Database(url)
    await database.migrate()
    await database.close()


@pytest.mark.parametrize("kind", sorted(SERVERS))
async def test_a_server_s_database_is_backed_up_and_restored_into_another(kind, tmp_path) -> None:
    with empty_database(kind) as first, empty_database(kind) as second:
        urls = [first, second]
        for url in urls:
            await migrate(url)
        store = HistoryStore(urls[0], SystemClock())
        await store.open()
        rows = [(0, NOW + at, at / 7) for at in range(9_000)] + [(1, NOW, "word ´'\\%")]
        await store.append_samples("agv", "b", 0, addresses=["a/x", "a/y"], columns=batch(rows))
        await store.append_samples(
            "agv", "b", 9_001, addresses=["a/x"], columns=batch([(0, NOW, float("nan"))])
        )
        target = write_backup(
            urls[0], tmp_path, tmp_path.parent / f"{tmp_path.name}-b", SystemClock()
        )
        wanted = await store.read_series("agv", ["a/x", "a/y"], *ALL, width=10_000)
        await store.close()
        assert restore_server(target, urls[1]) > 0
        for url in (urls[1], f"sqlite:///{target}/talaia.db"):
            store = HistoryStore(url, SystemClock())
            await store.open()
            found = await store.read_series("agv", ["a/x", "a/y"], *ALL, width=10_000)
            for one, other in zip(found, wanted, strict=True):
                assert one.value.tobytes() == other.value.tobytes()
                assert one.texts == other.texts
            assert await store.stored_below("agv", "b") == 9_002
            await store.close()
        # What has people in it is not written over.
        engine = sa.create_engine(parse_database_url(urls[1], blocking=True).url)
        users = metadata.tables["users"]
        with engine.begin() as connection:
            fill(connection, users)
        engine.dispose()
        with pytest.raises(StoreError, match="people"):
            restore_server(target, urls[1])


def fill(connection, *tables):
    """Put one row of plain values into each table."""
    for table in tables:
        row = {}
        for column in table.columns:
            if column.foreign_keys or column.primary_key or column.type.python_type in (int, bool):
                row[column.name] = 1
            elif column.type.python_type is bytes:
                row[column.name] = b"x"
            else:
                row[column.name] = "x"
        connection.execute(table.insert(), row)


async def test_a_damaged_database_is_set_aside_and_nothing_beside_it_is_touched(tmp_path) -> None:
    path = tmp_path / "talaia.db"
    url = f"sqlite:///{path}"
    assert set_aside_if_damaged(url, HandClock()) is None
    database = Database(f"sqlite+aiosqlite:///{path}")
    await database.migrate()
    await database.close()
    assert set_aside_if_damaged(url, HandClock()) is None
    recording = tmp_path / "recordings" / "one.mcap"
    recording.parent.mkdir()
    recording.write_bytes(b"mcap")
    body = path.read_bytes()
    for junk in (b"not a database at all" * 99, body[:4096] + b"\xff" * (len(body) - 4096)):
        path.write_bytes(junk)
        aside = set_aside_if_damaged(url, HandClock())
        assert aside is not None
        assert aside.read_bytes() == junk
        assert not path.exists()
        aside.unlink()
    assert recording.read_bytes() == b"mcap"


@pytest.mark.parametrize(("table", "aside"), [("users", True), ("history_body", False)])
async def test_of_a_large_database_what_all_else_needs_is_looked_at(tmp_path, table, aside) -> None:
    path = tmp_path / "talaia.db"
    url = f"sqlite:///{path}"
    await migrate(url)
    store = HistoryStore(url, SystemClock())
    await store.open()
    await store.append_samples(
        "agv",
        "b",
        0,
        addresses=["a/x"],
        columns=batch([(0, NOW + at, at / 7) for at in range(9_000)]),
    )
    await store.close()
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        (size,) = database.execute("PRAGMA page_size").fetchone()
        query = "SELECT rootpage FROM sqlite_master WHERE name = ?"
        (page,) = database.execute(query, (table,)).fetchone()
    assert set_aside_if_damaged(url, HandClock(), read_through=0) is None
    body = bytearray(path.read_bytes())
    body[(page - 1) * size : page * size] = b"\xff" * size
    path.write_bytes(body)
    assert (set_aside_if_damaged(url, HandClock(), read_through=0) is not None) == aside
    # A small one is read through.
    assert (set_aside_if_damaged(url, HandClock()) is not None) != aside


async def test_a_backup_in_the_middle_of_a_load_holds_all_up_to_one_moment(
    database_url, tmp_path
) -> None:
    await migrate(database_url)
    store = HistoryStore(database_url, SystemClock())
    await store.open()
    stored, begun, ended = 0, asyncio.Event(), asyncio.Event()

    async def load() -> None:
        nonlocal stored
        while not ended.is_set():
            rows = [(0, NOW + stored + at, float(stored + at)) for at in range(500)]
            await store.append_samples("agv", "b", stored, addresses=["a/x"], columns=batch(rows))
            stored += 500
            if stored >= 5_000:
                begun.set()

    loading = asyncio.create_task(load())
    await begun.wait()
    before = stored
    data = tmp_path / "data"
    data.mkdir()
    target = await asyncio.to_thread(
        write_backup, database_url, data, tmp_path / "b", SystemClock()
    )
    after = stored
    ended.set()
    await loading
    await store.close()
    copy = HistoryStore(f"sqlite:///{target}/talaia.db", SystemClock())
    await copy.open()
    below = await copy.stored_below("agv", "b")
    (series,) = await copy.read_series("agv", ["a/x"], *ALL, width=1_000_000)
    await copy.close()
    # What is on its way when the backup begins may be in it; what was stored before is.
    assert before <= below <= after + 500
    assert series.value.tolist() == [float(at) for at in range(below)]


def test_a_database_that_is_busy_is_not_taken_for_a_damaged_one(tmp_path) -> None:
    path = tmp_path / "talaia.db"
    holder = sqlite3.connect(path, isolation_level=None)
    holder.execute("CREATE TABLE a (b)")
    holder.execute("BEGIN EXCLUSIVE")
    assert set_aside_if_damaged(f"sqlite:///{path}?timeout=0", HandClock()) is None
    assert path.exists()
    holder.close()


async def test_what_is_on_another_server_is_told_and_not_in_the_backup(tmp_path, capsys) -> None:
    settings = settings_in(tmp_path)
    database = Database(settings.url)
    homes = HistoryHomes(database)
    for site, server in (("agv", "east"), ("lab", "east"), ("hall", OWN)):
        await homes.add_home(site, server)
    await database.close()
    target = tmp_path.parent / f"{tmp_path.name}-backup"
    assert main(["backup", str(target), "--data", str(tmp_path)]) == 0
    assert "not in it: the history of agv, lab, on the server 'east'" in capsys.readouterr().out
