"""Signed heads of the audit log at another hub: what was made anew is discovered by them."""

from __future__ import annotations

import asyncio
import json
from dataclasses import replace

import pytest

from talaia.cli.auditing.main import main as verify_from_command_line
from talaia.clock import HandClock
from talaia.hub.auth.audit_heads import AuditHead, HeadKey
from talaia.hub.errors import CannotStart
from talaia.hub.notify.audit_heads import HEADS_FILE
from talaia.hub.notify.audit_hub import HeadForwarder
from talaia.hub.notify.audit_hub_settings import AuditHubSettings, read_audit_hub_settings
from talaia.hub.store.audit import Audit
from talaia.hub.store.database import Database
from talaia.hub.store.witnessed_hubs import WitnessedHubs

from ..auth.test_audit_heads import rewrite
from ..conftest import RunningHub

KEY = HeadKey(bytes(range(32)))
OTHER = HeadKey(bytes(32))
DAY = 86_400_000_000


def head(row: int, digit: str = "a", key: HeadKey = KEY) -> str:
    return key.sign_head(AuditHead(row, digit * 64, 1_700_000_000_000_000 + row))


async def added(client, name: str = "Mountain", **more: object) -> dict[str, str]:
    answer = await client.post("/api/audit/hubs", json={"name": name, **more})
    assert answer.status_code == 200, answer.text
    return answer.json()


async def leave(client, token: str, *lines: str, key: HeadKey = KEY):
    said = {"token": token, "key": key.public, "lines": list(lines)}
    return await client.post("/api/heads", json=said)


async def shown(admin) -> dict:
    (hub,) = (await admin.get("/api/audit/hubs")).json()["hubs"]
    return hub


async def kinds_of(hub, kind: str) -> list[str]:
    admin = await hub.client("admin")
    rows = (await admin.get("/api/audit", params={"kind": kind})).json()["rows"]
    return [row["message"] for row in rows]


def forwarder(folder, url: str, token: str, log: Audit, **more: str) -> HeadForwarder:
    (folder / "token").write_text(f"{token}\n")
    settings = AuditHubSettings(url=url, token_file=str(folder / "token"), **more)
    return HeadForwarder(
        folder=folder, settings=settings, public=KEY.public, audit=log, clock=HandClock()
    )


async def test_log_that_was_made_anew_does_not_pass_what_another_hub_has_kept(
    hub, settings, history, tmp_path, capsys
) -> None:
    admin = await hub.client("admin")
    made = await added(admin)
    (tmp_path / "token").write_text(made["token"])
    file = tmp_path / "audit-hub.yaml"
    file.write_text(json.dumps({"url": hub.origin, "token_file": "token"}))
    own = tmp_path / "own"
    own.mkdir()
    mine = replace(
        settings, data=own, database_url=f"sqlite:///{own / 'talaia.db'}", audit_hub=file
    )
    async with RunningHub(mine, history) as sender:
        await sender.populate()
        await sender.hub.audit.log.wait_written()
        await sender.hub.audit.heads.send_head()
        assert await sender.hub.audit.forwarder.send_new()
    assert (await shown(admin))["row"] > 0
    kept = await admin.get(f"/api/audit/hubs/{made['id']}/heads")
    assert "attachment" in kept.headers["content-disposition"]
    (tmp_path / "kept.log").write_text(kept.text)
    asked = ["verify", "--data", str(own), "--heads", str(tmp_path / "kept.log")]
    monkey = pytest.MonkeyPatch()
    monkey.setenv("TALAIA_DATABASE_URL", mine.database_url)
    try:
        assert await asyncio.to_thread(verify_from_command_line, asked) == 0
        database = Database(mine.url)
        await rewrite(database, without="hub started")
        await database.close()
        assert await asyncio.to_thread(verify_from_command_line, asked) == 1
    finally:
        monkey.undo()
    assert "not the one that was signed" in capsys.readouterr().out


async def test_another_hub_leaves_heads_by_its_token_alone_and_that_opens_nothing_else(hub) -> None:
    admin, nobody = await hub.client("admin"), await hub.client()
    made = await added(admin)
    assert (await leave(nobody, "tal_heads_" + "x" * 43, head(1))).status_code == 401
    assert (await leave(nobody, made["token"], head(1), head(2))).json() == {"kept": 2}
    # Once more, as who is not sure does.
    assert (await leave(nobody, made["token"], head(2), head(3))).status_code == 200
    seen = await shown(admin)
    assert (seen["heads"], seen["row"], seen["problem"]) == (3, 3, "")
    for path in ("/api/me", "/api/audit", "/api/audit/hubs"):
        bearer = {"Authorization": f"Bearer {made['token']}"}
        assert (await nobody.get(path, headers=bearer)).status_code == 401
    assert (await nobody.post("/api/displays/open", json={"token": made["token"]})).is_error
    operator = await hub.client("operator")
    assert (await operator.get(f"/api/audit/hubs/{made['id']}/heads")).status_code == 403
    assert (await admin.delete(f"/api/audit/hubs/{made['id']}")).status_code == 204
    assert (await leave(nobody, made["token"], head(4))).status_code == 401


async def test_what_does_not_fit_together_is_kept_and_told_once(hub) -> None:
    admin, nobody = await hub.client("admin"), await hub.client()
    made = await added(admin)
    await leave(nobody, made["token"], head(5), head(9))
    assert (await leave(nobody, made["token"], head(7, "b"))).status_code == 200
    assert (await leave(nobody, made["token"], head(9, "b"))).status_code == 200
    assert "row 9 it named row 7" in (await shown(admin))["problem"]
    lines = (await admin.get(f"/api/audit/hubs/{made['id']}/heads")).text.splitlines()
    assert lines == [head(5), head(9), head(7, "b"), head(9, "b")]
    assert len(await kinds_of(hub, "other hub's log does not fit")) == 1
    valley = await added(admin, "Valley")
    await leave(nobody, valley["token"], head(5), head(5, "b"))
    hubs = {each["name"]: each for each in (await admin.get("/api/audit/hubs")).json()["hubs"]}
    assert "different things of row 5" in hubs["Valley"]["problem"]


async def test_lines_of_another_key_and_forged_ones_are_refused_whole_and_told(hub) -> None:
    admin, nobody = await hub.client("admin"), await hub.client()
    made = await added(admin)
    assert (await leave(nobody, made["token"], head(1))).status_code == 200
    forged = head(2).replace('"row":2', '"row":3')
    for answer in (
        await leave(nobody, made["token"], head(2, key=OTHER), key=OTHER),
        await leave(nobody, made["token"], head(2), forged),
        await leave(nobody, made["token"], "no head"),
    ):
        assert (answer.status_code, answer.json()["code"]) == (422, "heads")
    seen = await shown(admin)
    assert seen["heads"] == 1
    assert "another key" in seen["problem"]
    assert len(await kinds_of(hub, "other hub's log does not fit")) == 1


async def test_heads_are_kept_for_their_time_and_the_newest_for_good(settings) -> None:
    database = Database(settings.url)
    clock = HandClock()
    hubs = WitnessedHubs(database, clock)
    number, _ = await hubs.add_hub("Mountain", 30)
    await hubs.keep_heads(number, KEY.public, [head(1), head(2)])
    clock.advance(29 * DAY * 1000)
    await hubs.keep_heads(number, KEY.public, [])
    assert (await hubs.list_hubs())[0].heads == 2
    clock.advance(2 * DAY * 1000)
    await hubs.keep_heads(number, KEY.public, [])
    assert [line async for line in hubs.iterate_lines(number)] == [head(2)]
    await database.close()


async def test_heads_gather_while_the_other_hub_is_away_and_the_loss_is_told_once(
    hub, settings, tmp_path
) -> None:
    admin = await hub.client("admin")
    made = await added(admin)
    log = hub.hub.audit.log
    (tmp_path / HEADS_FILE).write_text("".join(f"{head(row)}\n" for row in (1, 2)))
    # Nobody listens there, and then it is known by another key.
    away = forwarder(tmp_path, "https://127.0.0.1:1", made["token"], log)
    assert not await away.send_new()
    assert not await away.send_new()
    assert len(await kinds_of(hub, "heads not sent")) == 1
    (tmp_path / "token").write_text("tal_heads_wrong")
    back = forwarder(tmp_path, hub.origin, "tal_heads_wrong", log)
    assert not await back.send_new()
    (tmp_path / "token").write_text(made["token"])
    # A torn line and one of a key of before are passed over.
    with (tmp_path / HEADS_FILE).open("a") as file:
        file.write(f"{head(3)[:90]}{head(4)}\n{head(4, key=OTHER)}\n{head(5)}\n")
    assert await back.send_new()
    assert len(await kinds_of(hub, "heads sent again")) == 1
    seen = await shown(admin)
    assert (seen["heads"], seen["row"], seen["problem"]) == (3, 5, "")


@pytest.mark.pure
@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"url": "http://other.example"}, "no https address"),
        ({"url": "https://other.example/audit"}, "no https address"),
        ({"fingerprint": "ab:cd"}, "64 digits"),
        ({"tokenfile": "x"}, "tokenfile"),
    ],
)
def test_file_that_asks_for_what_is_not_safe_is_refused_by_name(tmp_path, more, said) -> None:
    file = tmp_path / "audit-hub.yaml"
    asked = {"url": "https://other.example:8443", "token_file": "token", **more}
    file.write_text(json.dumps(asked))
    with pytest.raises(CannotStart, match=said):
        read_audit_hub_settings(file)
