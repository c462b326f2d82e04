"""Signed heads of the audit log: a chain that was made anew does not pass them."""

from __future__ import annotations

import asyncio
import base64
import logging

import pytest
from sqlalchemy import delete, select, update

from talaia.cli.auditing.main import main as verify_from_command_line
from talaia.clock import HandClock, SystemClock
from talaia.hub.auth.audit_heads import KEY_FILE, AuditHead, HeadKey, head_key, read_head
from talaia.hub.errors import CannotStart
from talaia.hub.notify.audit_heads import HEADS_FILE, AuditHeads, read_heads
from talaia.hub.store.audit import Audit, AuditEntry, AuditFilter, chain_hash
from talaia.hub.store.database import Database
from talaia.hub.store.tables import audit as table, audit_head

from ..conftest import RunningHub

KEY = HeadKey(bytes(range(32)))
OTHER = HeadKey(bytes(32))


@pytest.mark.pure
def test_head_is_read_by_its_key_alone_also_out_of_a_log_servers_line() -> None:
    head = AuditHead(7, "ab" * 32, 1_700_000_000_000_000, 2)
    line = KEY.sign_head(head)
    assert read_head(line, KEY.public) == head
    assert read_head(f"Nov 25 23:00:00 hub talaia: {line}\n", KEY.public) == head
    assert read_head(line, OTHER.public) is None
    assert read_head("Nov 25 23:00:00 hub kernel: hello", KEY.public) is None
    with pytest.raises(ValueError, match="wrong signature"):
        read_head(line.replace('"row":7', '"row":8'), KEY.public)
    forged = OTHER.sign_head(head).split(" ")
    with pytest.raises(ValueError, match="wrong signature"):
        read_head(" ".join([forged[0], line.split(" ")[1], *forged[2:]]), KEY.public)
    with pytest.raises(ValueError, match="different things of row 7"):
        read_heads([line, KEY.sign_head(AuditHead(7, "cd" * 32, 1))], KEY.public)


def test_key_is_made_once_for_its_owner_alone_and_a_broken_one_is_told(tmp_path) -> None:
    made = head_key(tmp_path)
    assert head_key(tmp_path).public == made.public
    assert len(base64.b64decode(made.public)) == 32
    assert (tmp_path / KEY_FILE).stat().st_mode & 0o777 == 0o600
    (tmp_path / KEY_FILE).write_bytes(b"short")
    with pytest.raises(CannotStart, match="no key of 32 bytes"):
        head_key(tmp_path)


async def written(database: Database, *kinds: str) -> Audit:
    log = Audit(database, SystemClock())
    for kind in kinds:
        log.append_record(kind, who="ada")
    log.stop()
    await log.run()
    return log


async def rewrite(database: Database, *, without: str) -> None:
    """Make the whole chain anew, as who has the database can."""
    async with database.write() as connection:
        rows = (await connection.execute(select(table).order_by(table.c.id))).all()
        before, last = "", 0
        for row in rows:
            if row.kind == without:
                await connection.execute(delete(table).where(table.c.id == row.id))
                continue
            entry = AuditEntry(*(getattr(row, name) for name in AuditEntry._fields))
            before, last = chain_hash(before, entry), row.id
            await connection.execute(update(table).where(table.c.id == row.id).values(hash=before))
        await connection.execute(update(audit_head).values(row_id=last, hash=before))


async def test_chain_that_was_made_anew_passes_by_itself_and_not_by_its_heads(
    database, tmp_path
) -> None:
    log = await written(database, "login", "theft", "logout")
    heads = AuditHeads(
        audit=log, key=KEY, files=[tmp_path / "heads"], syslog=False, clock=HandClock()
    )
    assert await heads.send_head() is not None
    # Nothing is new: nothing is said.
    assert await heads.send_head() is None
    said = read_heads((tmp_path / "heads").read_text().splitlines(), KEY.public)
    chain = await log.verify_chain(said)
    assert (chain.rows, chain.broken, chain.heads) == (3, 0, 1)
    await rewrite(database, without="theft")
    assert (await log.verify_chain()).broken == 0
    assert (await log.verify_chain(said)).broken in said


async def test_rows_that_were_cut_off_with_the_end_of_the_chain_show_by_a_head(
    database, tmp_path
) -> None:
    log = await written(database, "login", "theft")
    heads = AuditHeads(
        audit=log, key=KEY, files=[tmp_path / "heads"], syslog=False, clock=HandClock()
    )
    await heads.send_head()
    await rewrite(database, without="theft")
    said = read_heads((tmp_path / "heads").read_text().splitlines(), KEY.public)
    assert (await log.verify_chain()).broken == 0
    assert (await log.verify_chain(said)).broken == max(said)


async def test_notes_that_memory_had_no_room_for_are_counted_and_told(database, caplog) -> None:
    log = Audit(database, SystemClock(), most_waiting=3)
    with caplog.at_level(logging.ERROR):
        for number in range(5):
            log.append_record(f"note {number}")
    assert "loses notes" in caplog.text
    assert log.lost == 2
    log.stop()
    await log.run()
    rows, _ = await log.find_records(AuditFilter(kind="notes lost"), 10)
    assert [row.entry.message for row in rows] == [
        "2 notes were not kept, for the database was away too long"
    ]


async def test_hub_signs_when_it_ends_and_finds_later_what_was_changed(settings, history) -> None:
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        await hub.client("admin")
    assert (settings.data / HEADS_FILE).read_text()
    async with RunningHub(settings, history) as hub:
        admin = await hub.client("admin")
        found = (await admin.get("/api/audit/verify")).json()
        assert found["ok"]
        assert found["heads"] >= 1
    database = Database(settings.url)
    await rewrite(database, without="login")
    await database.close()
    async with RunningHub(settings, history) as hub:
        admin = await hub.client("admin")
        found = (await admin.get("/api/audit/verify")).json()
        assert (found["ok"], found["broken"] > 0) == (False, True)


def test_command_line_says_whether_the_log_is_as_it_was(settings, tmp_path, capsys) -> None:
    async def write(*kinds: str) -> None:
        database = Database(settings.url)
        log = await written(database, *kinds)
        heads = AuditHeads(
            audit=log,
            key=head_key(settings.data),
            files=[tmp_path / "elsewhere"],
            syslog=False,
            clock=SystemClock(),
        )
        await heads.send_head()
        await database.close()

    async def forge() -> None:
        database = Database(settings.url)
        await rewrite(database, without="theft")
        await database.close()

    asyncio.run(write("login", "theft", "logout"))
    asked = ["verify", "--data", str(settings.data), "--heads", str(tmp_path / "elsewhere")]
    assert verify_from_command_line(asked) == 0
    assert "1 signed heads fit" in capsys.readouterr().out
    asyncio.run(forge())
    assert verify_from_command_line(asked) == 1
    assert "not the one that was signed" in capsys.readouterr().out


async def test_target_that_is_away_is_told_once_gone_and_once_back_and_keeps_heads_from_no_other(
    database, tmp_path, caplog
) -> None:
    log = Audit(database, HandClock())
    mounted = tmp_path / "mounted"
    files = [mounted / "heads.log", tmp_path / "other.log"]
    heads = AuditHeads(audit=log, key=KEY, files=files, syslog=False, clock=HandClock())
    writing = asyncio.create_task(log.run())

    async def send(kind: str) -> None:
        log.append_record(kind)
        await log.wait_written()
        await heads.send_head()
        await log.wait_written()

    for hour in range(3):
        await send(f"hour {hour}")
    mounted.mkdir()
    # Nothing new has happened: it goes where it has not gone yet, and nowhere twice.
    await heads.send_head()
    await heads.send_head()
    await log.wait_written()
    lines = files[1].read_text().splitlines()
    assert len(lines) == len(set(lines)) >= 3
    rows, _ = await log.find_records(AuditFilter(kind="heads "), 10)
    assert [(row.entry.kind, row.entry.good) for row in rows] == [
        ("heads sent again", True),
        ("heads not sent", False),
    ]
    told = [each.levelname for each in caplog.records if "heads of the audit log" in each.message]
    assert told == ["ERROR", "WARNING"]
    log.stop()
    await writing
