"""The audit log: what is in it, how it is read, and that nobody can change it unseen."""

from __future__ import annotations

import asyncio
import csv
import hashlib
import io
import json

import pytest
from sqlalchemy import insert, text

from talaia.clock import SECOND, HandClock
from talaia.hub.store.audit import Audit, AuditEntry, AuditFilter
from talaia.hub.store.database import Database
from talaia.hub.store.safe_text import safe_cell, safe_text
from talaia.hub.store.tables import audit as table
from talaia.wire import browser as page_wire
from talaia.wire.frames import (
    CommandPhase,
    CommandRequest,
    CommandState,
    LeaseOp,
    LeaseRequest,
    LeaseState,
)

PASSWORD = "a password for tests"  # noqa: S105


async def written(audit: Audit) -> None:
    audit.stop()
    await audit.run()


async def filled(database) -> Audit:
    """Write ten rows, a second apart: who ada or eve, kinds in turn, every third not good."""
    clock = HandClock()
    audit = Audit(database, clock)
    for number in range(10):
        audit.append_record(
            ("login", "command asked", "command succeeded")[number % 3],
            who=("ada", "eve")[number % 2],
            site="agv",
            device=("base", "camera")[number % 2],
            message=f"row {number} é 🤖 ' \" ; --",
            good=number % 3 != 0,
        )
        clock.advance(SECOND)
    await written(audit)
    return Audit(database, clock)


# ── on every database ──


async def test_rows_are_found_by_person_device_kind_outcome_and_time(database) -> None:
    audit = await filled(database)
    began = 1_700_000_000 * 1_000_000

    async def numbers(**wanted) -> list[int]:
        rows, more = await audit.find_records(AuditFilter(**wanted), 100)
        assert not more
        return [int(row.entry.message.split()[1]) for row in rows]

    assert await numbers() == [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]
    assert await numbers(who="eve") == [9, 7, 5, 3, 1]
    assert await numbers(who="EVE") == []
    assert await numbers(device="base", good=False) == [6, 0]
    assert await numbers(kind="command") == [8, 7, 5, 4, 2, 1]
    assert await numbers(kind="command s") == [8, 5, 2]
    assert await numbers(kind="%") == []
    assert await numbers(from_us=began + 2_000_000, to_us=began + 5_000_000) == [4, 3, 2]
    assert await numbers(site="moon") == []


async def test_paging_gives_every_row_once(database) -> None:
    audit = await filled(database)
    seen, before = [], None
    while True:
        rows, more = await audit.find_records(AuditFilter(who="ada", before=before), 2)
        seen += [row.id for row in rows]
        if not more:
            break
        before = rows[-1].id
    assert len(seen) == 5
    assert seen == sorted(set(seen), reverse=True)
    assert [row.id async for row in audit.iterate_records(AuditFilter(who="ada"))] == seen


async def test_whole_log_follows_from_its_first_row(database) -> None:
    audit = await filled(database)
    assert (await audit.verify_chain())[:2] == (10, 0)


@pytest.mark.parametrize(
    ("tampering", "broken"),
    [
        ("UPDATE audit SET who = 'nobody' WHERE id = :third", "third"),
        ("UPDATE audit SET message = '' WHERE id = :third", "third"),
        ("UPDATE audit SET time_us = time_us + 1 WHERE id = :third", "third"),
        ("UPDATE audit SET source = 'gateway' WHERE id = :third", "third"),
        ("UPDATE audit SET source = '' WHERE id = :third", "third"),
        ("DELETE FROM audit WHERE id = :third", "fourth"),
        ("DELETE FROM audit WHERE id = :last", "last"),
        ("DELETE FROM audit", "last"),
    ],
)
async def test_row_that_was_changed_or_cut_out_is_named(database, tampering, broken) -> None:
    audit = await filled(database)
    ids = [row.id for row in reversed((await audit.find_records(AuditFilter(), 100))[0])]
    at = {"third": ids[2], "fourth": ids[3], "last": ids[-1]}
    async with database.write() as connection:
        used = {name: value for name, value in at.items() if f":{name}" in tampering}
        await connection.execute(text(tampering), used)
    assert (await audit.verify_chain()).broken == at[broken]


async def test_rows_of_before_their_source_was_written_down_are_still_in_the_chain(
    database,
) -> None:
    old = AuditEntry(1_000_000, "login", who="ada", source="")
    # As it was chained then: eight columns.
    said = json.dumps(["", *old[:8]], ensure_ascii=True, separators=(",", ":"))
    digest = hashlib.sha256(said.encode()).hexdigest()
    async with database.write() as connection:
        await connection.execute(insert(table), {**old._asdict(), "hash": digest})
        await connection.execute(
            text("UPDATE audit_head SET hash = :digest, row_id = (SELECT MAX(id) FROM audit)"),
            {"digest": digest},
        )
    audit = Audit(database, HandClock())
    audit.append_record("robot_log", source="gateway")
    await written(audit)
    assert (await audit.verify_chain())[:2] == (2, 0)
    rows, _ = await audit.find_records(AuditFilter(), 10)
    assert [row.entry.source for row in rows] == ["gateway", ""]


async def test_two_hubs_on_one_database_write_one_chain(database, database_url) -> None:
    other = Database(database_url)
    try:
        audits = [Audit(database, HandClock()), Audit(other, HandClock())]
        for number in range(20):
            audits[number % 2].append_record(f"row {number}")
        await asyncio.gather(*(written(audit) for audit in audits))
        assert (await audits[0].verify_chain())[:2] == (20, 0)
    finally:
        await other.close()


async def test_text_that_no_database_takes_is_written_all_the_same(database) -> None:
    audit = Audit(database, HandClock())
    audit.append_record("odd \x00 \ud800 \x1b[2J", who="a\nb\r\tc\u202e\u2028", message="x" * 9000)
    audit.append_record("next")
    await written(audit)
    rows, _ = await audit.find_records(AuditFilter(), 10)
    assert rows[1].entry.kind == r"odd \x00 \ud800 \x1b[2J"
    assert rows[1].entry.who == r"a\nb\r\tc\u202e\u2028"
    assert len(rows[1].entry.message) == 2000
    assert (await audit.verify_chain())[:2] == (2, 0)


def test_what_can_be_seen_stays_as_it_is() -> None:
    said = "Ada Lovelace, é, 望楼, 🤖, <b>, ' \" ; -- \\ %00"
    assert safe_text(said, 200) == said
    assert safe_text("abc\n", 4) == "abc\\"


# ── over HTTP ──


async def kinds(hub, **wanted) -> list[tuple[str, str]]:
    """Give kind and who of the rows, oldest first."""
    await hub.hub.audit.log.wait_written()
    admin = await hub.client("admin")
    rows = (await admin.get("/api/audit", params=wanted)).json()["rows"]
    return [(row["kind"], row["who"]) for row in reversed(rows)]


async def test_sign_in_right_and_wrong_is_written_down_without_the_password(hub) -> None:
    nobody = await hub.client()
    secret = "hunter2 hunter2"  # noqa: S105
    for name, password in (("operator", secret), ("no\nbody", secret), ("operator", PASSWORD)):
        await nobody.post("/api/login", json={"name": name, "password": password})
    await nobody.post("/api/logout")
    found = await kinds(hub, kind="log")
    assert found[:2] == [("login failed", "operator"), ("login failed", r"no\nbody")]
    assert ("login", "operator") in found
    assert ("logout", "operator") in found
    admin = await hub.client("admin")
    assert secret not in (await admin.get("/api/audit")).text


async def test_lease_and_every_command_with_its_result_are_written_down(hub, gateway) -> None:
    page = await hub.page("operator")
    await page.say(page_wire.PageLease(site="agv", device="base", op=LeaseOp.TAKE))
    asked = await gateway.hear(LeaseRequest)
    await gateway.say(
        LeaseState(device="base", session=asked.session, who="operator", epoch=1, remains_ms=900)
    )
    await page.say(
        page_wire.PageCommand(
            site="agv", device="base", command="wander", id="c1", args={"active": True}
        )
    )
    ask = await gateway.hear(CommandRequest)
    await gateway.say(
        CommandState(
            id=ask.id,
            device="base",
            command="wander",
            phase=CommandPhase.FAILED,
            message="the wheel\nis off",
            who="operator",
        )
    )
    await page.hear(page_wire.CommandUpdate, lambda news: news.phase is CommandPhase.FAILED)
    await gateway.say(LeaseState(device="base"))
    await page.hear(page_wire.LeaseUpdate, lambda news: not news.holder)
    assert await kinds(hub, device="base") == [
        ("lease taken", "operator"),
        ("command asked", "operator"),
        ("command failed", "operator"),
        ("lease freed", "operator"),
    ]
    admin = await hub.client("admin")
    rows = (await admin.get("/api/audit", params={"kind": "command failed"})).json()["rows"]
    assert rows[0]["message"] == r"wander c1 the wheel\nis off"
    assert rows[0]["good"] is False


async def test_what_an_admin_changes_is_written_down(hub, gateway) -> None:
    admin = await hub.client("admin")
    made = (await admin.post("/api/gateways/codes", json={"site": "agv"})).json()
    await admin.delete(f"/api/gateways/codes/{made['id']}")
    listed = (await admin.get("/api/gateways")).json()["gateways"]
    await admin.post(f"/api/gateways/{listed[0]['id']}/reconnect", json={"device": "base"})
    await admin.post(f"/api/gateways/{listed[0]['id']}/revoke")
    await gateway.closed()
    found = [kind for kind, who in await kinds(hub, who="admin") if kind != "login"]
    assert found == [
        "gateway code made",
        "gateway code withdrawn",
        "device reconnect asked",
        "gateway revoked",
    ]
    assert made["code"] not in (await admin.get("/api/audit")).text


async def test_chain_is_verified_for_an_admin_and_a_break_is_named(hub) -> None:
    admin = await hub.client("admin")
    sound = (await admin.get("/api/audit/verify")).json()
    assert sound["ok"]
    assert sound["broken"] == 0
    assert sound["rows"] >= 2
    async with hub.hub.core.database.write() as connection:
        await connection.execute(text("UPDATE audit SET good = NOT good WHERE id = 2"))
    found = (await admin.get("/api/audit/verify")).json()
    assert (found["ok"], found["rows"], found["broken"]) == (False, 1, 2)


FORMULAS = ["=cmd|' /C calc'!A0", "+1+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "=HYPERLINK(1)"]


@pytest.mark.parametrize("said", FORMULAS)
def test_no_cell_is_a_formula(said) -> None:
    assert safe_cell(said) == f"'{said}"


async def test_export_is_a_file_that_no_spreadsheet_works_out(hub) -> None:
    for said in (*FORMULAS, 'a "quoted", cell', "<script>alert(1)</script>"):
        hub.hub.audit.log.append_record("test", who=said, message=said)
    admin = await hub.client("admin")
    answer = await admin.get("/api/audit/export", params={"kind": "test"})
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    assert answer.headers["content-disposition"] == 'attachment; filename="talaia-audit.csv"'
    assert answer.headers["x-content-type-options"] == "nosniff"
    rows = list(csv.DictReader(io.StringIO(answer.text, newline="")))
    assert len(rows) == len(FORMULAS) + 2
    assert rows[0]["who"] == "<script>alert(1)</script>"
    assert rows[1]["message"] == 'a "quoted", cell'
    for row in rows:
        assert not any(cell.startswith(tuple("=+-@\t\r")) for cell in row.values())
        assert row["time_utc"].endswith("+00:00")
    await hub.hub.audit.log.wait_written()
    assert ("audit exported", "admin") in await kinds(hub)


async def test_export_of_a_long_log_comes_in_pieces_and_whole(hub) -> None:
    for number in range(5_000):
        hub.hub.audit.log.append_record("many", message=f"row {number}")
    admin = await hub.client("admin")
    pieces = []
    async with admin.stream("GET", "/api/audit/export", params={"kind": "many"}) as answer:
        assert "content-length" not in answer.headers
        pieces = [piece async for piece in answer.aiter_raw()]
    lines = b"".join(pieces).decode().splitlines()
    assert len(lines) == 5_001
    assert len({line.split(",")[0] for line in lines}) == 5_001


@pytest.mark.parametrize("path", ["/api/audit", "/api/audit/export", "/api/audit/verify"])
async def test_log_is_for_admins_only(hub, path) -> None:
    assert (await (await hub.client()).get(path)).status_code == 401
    for name in ("guest", "operator"):
        assert (await (await hub.client(name)).get(path)).status_code == 403


HOSTILE = ["' OR 1=1 --", '"; DROP TABLE audit; --', "%00", "\x00", "*", "_", "%", "\\", "1e309"]
NAMES = ["who", "site", "device", "kind", "good", "from_us", "to_us", "before", "limit", "sort"]


async def test_hostile_filter_finds_nothing_and_breaks_nothing(hub) -> None:
    admin = await hub.client("admin")
    for name in NAMES:
        for value in HOSTILE:
            answer = await admin.get("/api/audit", params={name: value})
            assert answer.status_code == 422 or answer.json()["rows"] == [], (name, value)
    assert (await admin.get("/api/audit")).json()["rows"]
