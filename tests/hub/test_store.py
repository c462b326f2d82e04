"""The database: migrations, the audit log's chain, gateway keys."""

import asyncio
import ssl
import sys
import threading

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import inspect, text

from talaia.clock import SystemClock
from talaia.hub import accounts
from talaia.hub.errors import NameTaken, StoreError, UnknownPerson
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.audit import Audit
from talaia.hub.store.database import Database
from talaia.hub.store.people import People
from talaia.hub.store.reach import reach
from talaia.hub.store.sessions import Sessions
from talaia.hub.store.sites import SiteRegistry
from talaia.hub.store.tables import metadata


@pytest.fixture
async def database(tmp_path):
    database = Database(f"sqlite+aiosqlite:///{tmp_path / 'talaia.db'}")
    await database.migrate()
    yield database
    await database.close()


async def test_migrations_make_exactly_the_tables_of_the_code(database) -> None:
    def differences(connection):
        context = MigrationContext.configure(connection, opts={"compare_type": False})
        return compare_metadata(context, metadata)

    async with database.read() as connection:
        ours = set(metadata.tables)
        found = await connection.run_sync(differences)
    assert [each for each in found if getattr(each[1], "name", "") in ours] == []


async def test_migrating_again_changes_nothing(database) -> None:
    await database.migrate()
    async with database.read() as connection:
        names = (await connection.execute(text("SELECT name FROM roles ORDER BY id"))).scalars()
        assert list(names) == ["guest", "operator", "admin"]


async def test_change_of_tables_that_fails_leaves_nothing_behind(database) -> None:
    async def half() -> None:
        async with database.write() as connection:
            await connection.execute(text("CREATE TABLE half (id INTEGER)"))
            raise RuntimeError

    with pytest.raises(RuntimeError):
        await half()
    async with database.read() as connection:
        names = await connection.run_sync(lambda sync: inspect(sync).get_table_names())
    assert "half" not in names


async def test_sqlite_is_opened_so_that_a_commit_lasts(database) -> None:
    async with database.read() as connection:
        found = [
            (await connection.execute(text(f"PRAGMA {name}"))).scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys")
        ]
    assert found == ["wal", 2, 1]


async def test_database_that_cannot_be_opened_says_which_and_why(tmp_path) -> None:
    database = Database(f"sqlite+aiosqlite:///{tmp_path / 'missing' / 'talaia.db'}")
    with pytest.raises(StoreError, match=r"missing/talaia\.db cannot be opened"):
        await database.migrate()
    await database.close()
    # The driver's thread says goodbye to the loop after a connection that failed.
    for thread in threading.enumerate():
        if "_connection_worker_thread" in thread.name:
            await asyncio.to_thread(thread.join, 5)


@pytest.mark.parametrize(
    ("given", "waiting", "blocking"),
    [
        ("sqlite:////d/t.db", "sqlite+aiosqlite:////d/t.db", "sqlite:////d/t.db"),
        ("postgresql://u:p@h/d", "postgresql+asyncpg://u:p@h/d", "postgresql+pg8000://u:p@h/d"),
        ("postgres://h/d", "postgresql+asyncpg://h/d", "postgresql+pg8000://h/d"),
        (
            "mariadb://u@h:3307/d",
            "mysql+aiomysql://u@h:3307/d?charset=utf8mb4",
            "mysql+pymysql://u@h:3307/d?charset=utf8mb4",
        ),
        (
            "mysql+pymysql://h/d",
            "mysql+aiomysql://h/d?charset=utf8mb4",
            "mysql+pymysql://h/d?charset=utf8mb4",
        ),
    ],
)
def test_one_plain_url_gives_the_driver_of_the_accounts_and_of_the_history(
    given, waiting, blocking
) -> None:
    assert reach(given).url.render_as_string(hide_password=False) == waiting
    assert reach(given, blocking=True).url.render_as_string(hide_password=False) == blocking


@pytest.mark.parametrize(
    "url",
    ["nonsense", "oracle://h/d", "postgresql://h", "mariadb://h/", "postgresql://h/d?sslmode=odd"],
)
def test_url_that_cannot_be_used_is_refused_with_what_to_write(url) -> None:
    with pytest.raises(StoreError, match=r"write it like|sslmode"):
        Database(url)
    with pytest.raises(HistoryError, match=r"write it like|sslmode"):
        HistoryStore(url, SystemClock())


@pytest.mark.parametrize(
    ("url", "extra"),
    [("postgresql://h/d", "postgresql"), ("mysql://h/d", "mariadb"), ("mariadb://h/d", "mariadb")],
)
def test_driver_that_is_not_installed_is_named_with_what_installs_it(
    monkeypatch, url, extra
) -> None:
    for driver in ("asyncpg", "pg8000", "aiomysql", "pymysql"):
        monkeypatch.setitem(sys.modules, driver, None)
    with pytest.raises(StoreError, match=rf"pip install 'talaia\[{extra}\]'"):
        Database(url)
    with pytest.raises(HistoryError, match=rf"pip install 'talaia\[{extra}\]'"):
        HistoryStore(url, SystemClock())


def test_tls_to_a_server_is_asked_for_in_one_way_for_every_driver() -> None:
    for url, key in (("postgresql://h/d", "ssl"), ("mariadb://h/d", "ssl")):
        found = reach(f"{url}?sslmode=verify-full")
        assert found.arguments[key].verify_mode is ssl.CERT_REQUIRED
        assert found.arguments[key].check_hostname
        assert "sslmode" not in found.url.query
    found = reach("postgresql://h/d?sslmode=require", blocking=True)
    assert found.arguments["ssl_context"].verify_mode is ssl.CERT_NONE


async def written(audit: Audit, *kinds: str) -> None:
    for kind in kinds:
        audit.note(kind, site="agv", message="line one\nline two")
    audit.stop()
    await audit.run()


async def test_notes_are_written_in_order_and_chained(database) -> None:
    await written(Audit(database, SystemClock()), "a", "b", "c")
    await written(Audit(database, SystemClock()), "d")
    audit = Audit(database, SystemClock())
    assert [entry.kind for entry in await audit.recent("agv", 3)] == ["d", "c", "b"]
    assert await audit.verify() == (4, 0)


@pytest.mark.parametrize(
    "tampering",
    ["UPDATE audit SET who = 'eve' WHERE id = 2", "DELETE FROM audit WHERE id = 2"],
)
async def test_changed_or_missing_row_breaks_the_chain(database, tampering) -> None:
    audit = Audit(database, SystemClock())
    await written(audit, "a", "b", "c")
    async with database.write() as connection:
        await connection.execute(text(tampering))
    assert (await audit.verify()).broken in {2, 3}


async def test_note_never_waits_and_is_cut_to_its_column(database) -> None:
    audit = Audit(database, SystemClock())
    entry = audit.note("k" * 500, message="m" * 5000)
    assert (len(entry.kind), len(entry.message)) == (200, 2000)
    writing = asyncio.create_task(audit.run())
    await audit.written()
    audit.stop()
    await writing


async def test_new_key_of_a_gateway_makes_the_old_one_void(database) -> None:
    registry = SiteRegistry(database, SystemClock())
    first = await registry.new_key("agv")
    second = await registry.new_key("agv")
    assert await registry.gateway_of(first) is None
    assert (await registry.gateway_of(second)).site == "agv"


async def test_no_secret_stands_in_the_database(settings) -> None:
    await accounts.create_user(settings, "ada", "my own secret", "admin")
    key = await accounts.create_gateway(settings, "agv")
    with pytest.raises(NameTaken):
        await accounts.create_user(settings, "ADA", "another secret", "guest")
    stored = b"".join(path.read_bytes() for path in settings.data.glob("talaia.db*"))
    assert b"my own secret" not in stored
    assert key.encode() not in stored


async def test_new_password_ends_the_persons_sessions_and_the_old_password(settings) -> None:
    clock = SystemClock()
    await accounts.create_user(settings, "Ada", "the first password", "operator")
    database = Database(settings.url)
    try:
        person = await People(database, clock).find("ada")
        assert person is not None
        sessions = Sessions(database, clock, settings)
        token, _ = await sessions.begin(person.id, "127.0.0.1")
        await accounts.set_password(settings, "ADA", "quite another password")
        assert await sessions.who(token) is None
        changed = await People(database, clock).find("ada")
        assert changed is not None
        assert changed.password_hash != person.password_hash
    finally:
        await database.close()


async def test_new_password_for_nobody_is_refused(settings) -> None:
    with pytest.raises(UnknownPerson, match="no person named"):
        await accounts.set_password(settings, "nobody", "quite another password")
