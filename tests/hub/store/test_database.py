"""The database: migrations, the audit log's chain, gateway keys."""

import asyncio
import contextlib
import signal
import sqlite3
import ssl
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pyotp
import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import event, inspect, select, text

from talaia.clock import SystemClock
from talaia.hub import accounts
from talaia.hub.auth.permissions import Permission, Right
from talaia.hub.auth.secret_box import Seal
from talaia.hub.errors import NameTaken, StoreDown, StoreError, UnknownPerson
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.store import HistoryStore
from talaia.hub.store import migrations
from talaia.hub.store.accounts.mfa import SecondFactors
from talaia.hub.store.accounts.people import People
from talaia.hub.store.accounts.roles import Roles
from talaia.hub.store.accounts.sessions import Sessions
from talaia.hub.store.audit import Audit, AuditFilter
from talaia.hub.store.database import Database, _upgrade_schema, last_migration
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.dialects.sqlite_opening import SqliteConnection
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.hub.store.tables import metadata, roles

from ..databases import database_with_tables


async def test_migrations_make_exactly_the_tables_of_the_code(database_url) -> None:
    database = Database(database_url)
    await database.migrate()

    def differences(connection):
        context = MigrationContext.configure(connection, opts={"compare_type": False})
        return compare_metadata(context, metadata)

    async with database.read() as connection:
        assert await connection.run_sync(differences) == []
    await database.close()


async def test_migrating_again_changes_nothing(database) -> None:
    await database.migrate()
    async with database.read() as connection:
        names = (await connection.execute(text("SELECT name FROM roles ORDER BY id"))).scalars()
        assert list(names) == ["guest", "operator", "admin"]


def test_the_migration_with_the_highest_number_is_the_last() -> None:
    # A start that finds its number in the database asks Alembic no more.
    last = ScriptDirectory(str(Path(migrations.__file__).parent)).get_current_head()
    assert last == last_migration()


class Interrupted(Exception):
    pass


def interrupted_after(database, changes):
    """Let the next migration end after so many changes of tables; give how many came."""
    came = []

    def before(_connection, _cursor, statement, *_rest):
        if statement.lstrip().startswith(("CREATE", "ALTER")):
            if len(came) == changes:
                raise Interrupted
            came.append(statement)

    event.listen(database._engine.sync_engine, "before_cursor_execute", before)
    return came


async def table_names(database):
    async with database.read() as connection:
        return set(await connection.run_sync(lambda sync: inspect(sync).get_table_names()))


async def test_migration_that_is_interrupted_goes_on_at_the_next_start(database_url) -> None:
    transactional = not database_url.startswith("mariadb")
    # MariaDB keeps each change: every start comes one further. The others keep none of them.
    budgets = (1, 20, 40) if transactional else (1,) * 100
    attempt = 0
    for budget in budgets:
        attempt += 1
        database = Database(database_url)
        interrupted_after(database, budget)
        try:
            await database.migrate()
        except Interrupted:
            if transactional:
                assert await table_names(database) == set()
        else:
            break
        finally:
            await database.close()
    assert transactional or attempt > 40
    database = Database(database_url)
    await database.migrate()
    assert set(metadata.tables) < await table_names(database)
    async with database.read() as connection:
        found = {
            name: (await connection.execute(text(f"SELECT COUNT(*) FROM {name}"))).scalar()  # noqa: S608 - a name of ours
            for name in ("roles", "permissions", "role_permissions", "write_turn", "audit_head")
        }
        differences = await connection.run_sync(
            lambda sync: compare_metadata(
                MigrationContext.configure(sync, opts={"compare_type": False}), metadata
            )
        )
    assert differences == []
    assert list(found.values()) == [3, 5, 7, 1, 1]
    await database.close()


KILLED = """
import asyncio, os, signal, sys
from sqlalchemy import event
from talaia.hub.store import migrations
from talaia.hub.store.database import Database, last_migration, _upgrade_schema

left = int(sys.argv[2])
database = Database(sys.argv[1])

@event.listens_for(database._engine.sync_engine, "after_cursor_execute")
def after(_connection, _cursor, statement, *_rest):
    global left
    left -= statement.lstrip().startswith(("CREATE", "ALTER"))
    if not left:
        os.kill(os.getpid(), signal.SIGKILL)

asyncio.run(database.migrate())
"""


@pytest.mark.parametrize("changes", [7, 31])
async def test_kill_minus_nine_in_a_migration_is_survived(database_url, changes) -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", KILLED, database_url, str(changes)
    )
    assert await process.wait() == -signal.SIGKILL
    database = Database(database_url)
    await database.migrate()
    people = People(database, SystemClock())
    assert await people.add_person("ada", "hash", "admin")
    await database.close()


async def test_of_programs_that_start_at_once_one_makes_the_tables(database_url) -> None:
    databases = [Database(database_url) for _ in range(4)]
    await asyncio.gather(*(database.migrate() for database in databases))
    async with databases[0].read() as connection:
        assert (await connection.execute(text("SELECT COUNT(*) FROM roles"))).scalar() == 3
    for database in databases:
        await database.close()


async def test_who_migrates_next_sees_the_last_step_of_the_one_before(database_url) -> None:
    first, second = Database(database_url), Database(database_url)
    async with first._writer.begin() as connection:
        await connection.run_sync(_upgrade_schema)
        if "mariadb" in database_url:
            # The others hold their lock for as long as the transaction.
            await second.migrate()
    await second.migrate()
    for database in (first, second):
        await database.close()


async def test_rows_that_came_with_numbers_do_not_stand_in_the_way_of_new_ones(database) -> None:
    roles = Roles(database)
    assert await roles.add_role("night", [Permission(Right.VIEW, "agv", "base")]) > 3


async def test_names_that_differ_by_an_accent_are_different_people(database) -> None:
    people = People(database, SystemClock())
    for name in ("ada", "àda", "дана", "😀 pilot"):
        await people.add_person(name, "hash", "guest")
        assert (await people.find_by_name(name)).name == name
    assert await people.find_by_name("ada  ") is None
    assert await people.find_by_name("ada\0") is None


async def test_change_of_rows_that_fails_leaves_nothing_behind(database) -> None:
    async def half() -> None:
        async with database.write() as connection:
            await connection.execute(text("INSERT INTO write_turn (id) VALUES (7)"))
            raise Interrupted

    with pytest.raises(Interrupted):
        await half()
    async with database.read() as connection:
        assert (await connection.execute(text("SELECT COUNT(*) FROM write_turn"))).scalar() == 1


async def test_who_writes_holds_the_turn_until_the_end(database) -> None:
    """Ten read a number and write one more; without a turn, some would overwrite each other."""

    async def one_more() -> None:
        async with database.write() as connection:
            rows = await connection.execute(text("SELECT MAX(id) FROM write_turn"))
            await asyncio.sleep(0)
            highest = rows.scalar()
            await connection.execute(
                text("INSERT INTO write_turn (id) VALUES (:id)"), {"id": highest + 1}
            )

    await asyncio.gather(*(one_more() for _ in range(10)))
    async with database.read() as connection:
        assert (await connection.execute(text("SELECT MAX(id) FROM write_turn"))).scalar() == 11


async def test_write_that_is_cut_off_anywhere_keeps_no_other_from_writing(database) -> None:
    """As a request that takes too long is; somebody still holds what cut it off."""
    cut = []

    async def write(times: int) -> None:
        async with database.write() as connection:
            for _ in range(times):
                await connection.execute(text("UPDATE write_turn SET id = id"))
                await connection.execute(text("SELECT id FROM write_turn"))

    for steps in range(50):
        task = asyncio.create_task(write(5))
        for _ in range(steps):
            await asyncio.sleep(0)
        task.cancel()
        cut += await asyncio.gather(task, return_exceptions=True)
        # A database that is locked answers StoreDown after ten seconds.
        await write(1)
    assert asyncio.CancelledError in {type(each) for each in cut}


async def test_server_that_is_not_there_is_named_without_its_password() -> None:
    for engine in ("postgresql", "mariadb"):
        database = Database(f"{engine}://u:secret@127.0.0.1:9/talaia")
        with pytest.raises(StoreError, match=r"127.0.0.1:9/talaia.* cannot be opened") as raised:
            await database.migrate()
        assert "secret" not in str(raised.value)
        with pytest.raises(StoreDown):
            async with database.read():
                pass
        await database.close()


@pytest.fixture
async def sqlite(tmp_path):
    database = Database(f"sqlite:///{tmp_path / 'alone.db'}")
    await database.migrate()
    yield database
    await database.close()


async def test_change_of_tables_that_fails_leaves_nothing_behind(sqlite) -> None:
    async def half() -> None:
        async with sqlite.write() as connection:
            await connection.execute(text("CREATE TABLE half (id INTEGER)"))
            raise RuntimeError

    with pytest.raises(RuntimeError):
        await half()
    assert "half" not in await table_names(sqlite)


async def test_sqlite_is_opened_so_that_a_commit_lasts(sqlite) -> None:
    async with sqlite.read() as connection:
        found = [
            (await connection.execute(text(f"PRAGMA {name}"))).scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys")
        ]
    assert found == ["wal", 2, 1]


class RefusedTwice(sqlite3.Cursor):
    """A cursor of a file that others are opening, too."""

    refusals = 0

    def execute(self, words):
        if words == "PRAGMA journal_mode=WAL" and self.refusals < 2:
            self.refusals += 1
            error = sqlite3.OperationalError("database is locked")
            error.sqlite_errorcode = sqlite3.SQLITE_BUSY
            raise error
        return super().execute(words)


class OfRefusedCursors(SqliteConnection):
    def cursor(self):
        self.used = RefusedTwice(self)
        return self.used


def test_who_opens_a_new_file_beside_others_tries_again(tmp_path) -> None:
    with contextlib.closing(OfRefusedCursors(tmp_path / "new.db")) as connection:
        assert connection.used.refusals == 2
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)


def test_file_that_is_no_database_is_refused_as_it_is_opened(tmp_path) -> None:
    (tmp_path / "notes.txt").write_text("no database at all, " * 100)
    with pytest.raises(sqlite3.DatabaseError, match="not a database"):
        SqliteConnection(tmp_path / "notes.txt")


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
    assert parse_database_url(given).url.render_as_string(hide_password=False) == waiting
    assert (
        parse_database_url(given, blocking=True).url.render_as_string(hide_password=False)
        == blocking
    )


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
        found = parse_database_url(f"{url}?sslmode=verify-full")
        assert found.arguments[key].verify_mode is ssl.CERT_REQUIRED
        assert found.arguments[key].check_hostname
        assert "sslmode" not in found.url.query
    found = parse_database_url("postgresql://h/d?sslmode=require", blocking=True)
    assert found.arguments["ssl_context"].verify_mode is ssl.CERT_NONE


@pytest.mark.parametrize("kind", ["postgresql", "mariadb"])
async def test_tls_that_is_not_wanted_is_not_tried(kind, tmp_path) -> None:
    with database_with_tables(kind, tmp_path) as url:
        question = {
            "postgresql": "SELECT ssl::text FROM pg_stat_ssl WHERE pid = pg_backend_pid()",
            "mariadb": "SHOW SESSION STATUS LIKE 'Ssl_version'",
        }[kind]
        database = Database(url)
        async with database.read() as connection:
            waiting = (await connection.exec_driver_sql(question)).one()
        await database.close()
        found = parse_database_url(url, blocking=True)
        engine = sa.create_engine(found.url, connect_args=found.arguments)
        with engine.connect() as connection:
            blocking = connection.exec_driver_sql(question).one()
        engine.dispose()
    assert {waiting[-1], blocking[-1]} <= {"false", ""}


async def written(audit: Audit, *kinds: str) -> None:
    for kind in kinds:
        audit.append_record(kind, site="agv", message="line one\nline two")
    audit.stop()
    await audit.run()


async def test_notes_are_written_in_order_and_chained(database) -> None:
    await written(Audit(database, SystemClock()), "a", "b", "c")
    await written(Audit(database, SystemClock()), "d")
    audit = Audit(database, SystemClock())
    assert [
        row.entry.kind for row in (await audit.find_records(AuditFilter(site="agv"), 3))[0]
    ] == [
        "d",
        "c",
        "b",
    ]
    assert (await audit.verify_chain())[:2] == (4, 0)


@pytest.mark.parametrize(
    "tampering",
    ["UPDATE audit SET who = 'eve' WHERE id = 2", "DELETE FROM audit WHERE id = 2"],
)
async def test_changed_or_missing_row_breaks_the_chain(database, tampering) -> None:
    audit = Audit(database, SystemClock())
    await written(audit, "a", "b", "c")
    async with database.write() as connection:
        await connection.execute(text(tampering))
    assert (await audit.verify_chain()).broken in {2, 3}


async def test_note_never_waits_and_is_cut_to_its_column(database) -> None:
    audit = Audit(database, SystemClock())
    entry = audit.append_record("k" * 500, message="m" * 5000)
    assert (len(entry.kind), len(entry.message)) == (200, 2000)
    writing = asyncio.create_task(audit.run())
    await audit.wait_written()
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
        person = await People(database, clock).find_by_name("ada")
        assert person is not None
        sessions = Sessions(database, clock, settings)
        token, _ = await sessions.start_session(person.id, "127.0.0.1")
        await accounts.set_password(settings, "ADA", "quite another password")
        assert await sessions.find_session(token) is None
        changed = await People(database, clock).find_by_name("ada")
        assert changed is not None
        assert changed.password_hash != person.password_hash
    finally:
        await database.close()


async def test_lost_second_factor_is_removed_from_the_command_line(settings, database_url) -> None:
    settings = replace(settings, database_url=database_url)
    await accounts.create_user(settings, "ada", "three unrelated words", "admin")
    assert not await accounts.remove_factor(settings, "ada")
    clock, database = SystemClock(), Database(database_url)
    factors = SecondFactors(database, clock, lambda: Seal(b"k" * 32))
    person = await People(database, clock).find_by_name("ada")
    totp = pyotp.TOTP(await factors.offer_factor(person.id))
    assert await factors.confirm_factor(person.id, totp.at(clock.wall_ns() // 10**9))
    assert (await People(database, clock).find_by_name("ada")).factor
    assert await accounts.remove_factor(settings, "ADA")
    assert not (await People(database, clock).find_by_name("ada")).factor
    rows, _ = await Audit(database, clock).find_records(AuditFilter(), 10)
    assert [row.entry.kind for row in rows][:2] == ["person's second factor removed"] * 2
    assert {row.entry.who for row in rows} == {"(command line)"}
    await database.close()
    with pytest.raises(UnknownPerson):
        await accounts.remove_factor(settings, "nobody")


async def test_new_password_for_nobody_is_refused(settings) -> None:
    with pytest.raises(UnknownPerson, match="no person named"):
        await accounts.set_password(settings, "nobody", "quite another password")


async def test_a_query_by_itself_begins_no_transaction_on_sqlite_and_leaves_none_anywhere(
    database,
) -> None:
    ran = []

    def before(_connection, _cursor, statement, *_rest):
        ran.append(statement.split(maxsplit=1)[0])

    engine = database._engine.sync_engine
    event.listen(engine, "before_cursor_execute", before)
    assert list(await database.fetch_scalars(select(roles.c.name).order_by(roles.c.id))) == [
        "guest",
        "operator",
        "admin",
    ]
    event.remove(engine, "before_cursor_execute", before)
    assert ran == ["SELECT"]
    # Whoever writes next does not find its connection in the middle of something.
    async with database.write() as connection:
        await connection.execute(roles.update().values(name=roles.c.name + "s"))
    assert "guests" in await database.fetch_scalars(select(roles.c.name))


async def test_a_query_by_itself_tells_that_the_database_is_away(tmp_path) -> None:
    database = Database(f"sqlite:///{tmp_path / 'no' / 'such' / 'folder'}/hub.db")
    with pytest.raises(StoreDown):
        await database.fetch_scalars(select(roles.c.name))
    await database.close()


async def test_nothing_of_a_closed_database_runs_on(tmp_path) -> None:
    before = set(threading.enumerate())
    left = []
    # Most threads would have ended anyway; of so many, some have not.
    for _ in range(100):
        away = Database(f"sqlite:///{tmp_path / 'no' / 'such' / 'folder'}/hub.db")
        with pytest.raises(StoreDown):
            await away.fetch_scalars(select(roles.c.name))
        await away.close()
        left += [thread for thread in threading.enumerate() if thread not in before]
    # The executor's keep on, for whoever asks next.
    assert not [thread.name for thread in left if not thread.name.startswith("asyncio_")]
