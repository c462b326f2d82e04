"""Every version of a description at the hub, and changes on their way to a gateway."""

from __future__ import annotations

import asyncio
import hashlib
from itertools import count

import numpy as np
import pytest
from patience import PATIENCE_S

from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire.browser import EventUpdate, SiteUpdate
from talaia.wire.columns import Columns, pack_columns
from talaia.wire.frames import (
    Ack,
    ChangePhase,
    ChangeRequest,
    ChangeState,
    DescriptionProblem,
    DescriptionUpdate,
    Hello,
    SampleBatch,
    Welcome,
)
from talaia.wire.sealing import MAX_TEXT, compress_text, decompress_text, digest_of, seal_of

FIRST = """# The workshop's robot.
talaia: 1
site: agv
name: Robot
ros2: {}
devices:
  base:
    name: Base
    signals:
      speed:  # by the wheels
        name: Speed
        unit: m/s
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
"""
SECOND = FIRST.replace("speed:  #", "velocity:  #").replace(
    "unit: m/s", "unit: m/s\n        was: speed"
)
AT = "/api/sites/agv/descriptions"


def told(
    text: str, *, renamed: dict[str, str] | None = None, change: str = ""
) -> DescriptionUpdate:
    site = load_site(text)
    return DescriptionUpdate(
        description=compress_text(dump_site(site)),
        catalogue=digest_of(text)[:8],
        addresses=[each.address for each in site.channels()],
        renamed=renamed or {},
        source=compress_text(text),
        id=change,
        who="admin" if change else "",
    )


async def greet(gateway, text: str = FIRST, accepts: str = "readings") -> None:
    hello = Hello(
        site="agv",
        boot="boot-1",
        description=dump_site(load_site(text)),
        catalogue=digest_of(text)[:8],
        source=compress_text(text),
        accepts=accepts,
    )
    await gateway.say(hello)
    await gateway.hear(Welcome)


async def sample(gateway, text: str, sequence: int, value: float) -> None:
    columns = Columns(
        np.array([0], np.uint16), np.array([sequence + 1], np.int64), np.array([value]), {}
    )
    frame = SampleBatch(
        boot="boot-1",
        first=sequence,
        catalogue=digest_of(text)[:8],
        **pack_columns(columns)._asdict(),
    )
    await gateway.say(frame)


async def versions(client) -> list[dict]:
    return (await client.get(AT)).json()["versions"]


async def test_every_version_is_kept_with_who_when_and_from_which_gateway(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    page = await hub.page("admin")
    await greet(gateway)
    before = await page.hear(SiteUpdate, lambda news: news.online)
    await gateway.say(told(SECOND, renamed={"base/speed": "base/velocity"}))
    # By this pages know that they have to ask for it anew.
    await page.hear(SiteUpdate, lambda news: news.catalogue != before.catalogue)
    event = await page.hear(EventUpdate, lambda news: news.kind == "description changed")
    assert event.message == "version 2 of the description"
    found = await versions(admin)
    assert [each["number"] for each in found] == [2, 1]
    assert [each["current"] for each in found] == [True, False]
    assert found[0]["digest"] == digest_of(SECOND)
    assert found[0]["gateway"] > 0
    assert found[0]["note"] == "changed at the gateway"
    text = (await admin.get(f"{AT}/1")).json()
    assert text["text"] == FIRST


async def test_same_description_again_is_no_new_version(hub) -> None:
    admin = await hub.client("admin")
    for _ in range(2):
        gateway = await hub.gateway()
        await greet(gateway)
        await gateway.close()
    assert len(await versions(admin)) == 1


async def test_difference_names_parts_and_gives_lines(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    page = await hub.page("admin")
    await greet(gateway)
    await gateway.say(told(SECOND, renamed={"base/speed": "base/velocity"}))
    await page.hear(EventUpdate, lambda news: news.kind == "description changed")
    answer = (await admin.get(f"{AT}/1/difference", params={"to": 2})).json()
    renamed = {
        "kind": "renamed", "path": "$.devices.base.signals.velocity",
        "before": "base/speed", "after": "base/velocity",
    }  # fmt: skip
    assert renamed in answer["parts"]
    assert "-      speed:  # by the wheels" in answer["lines"]
    assert "+      velocity:  # by the wheels" in answer["lines"]


async def test_samples_go_on_while_the_description_changes_and_a_renamed_one_keeps_its_history(
    hub, history
) -> None:
    gateway = await hub.gateway()
    await greet(gateway)
    numbers = count()
    await sample(gateway, FIRST, next(numbers), 1.0)
    await gateway.say(told(SECOND, renamed={"base/speed": "base/velocity"}))
    # One that was under way, by the list before, and one by the new list, at once.
    await sample(gateway, FIRST, next(numbers), 2.0)
    await sample(gateway, SECOND, next(numbers), 3.0)
    await gateway.hear(Ack, lambda ack: ack.below == 3)
    rows = history.samples["agv", "boot-1"]
    assert [rows[at][0] for at in range(3)] == ["base/velocity"] * 3
    assert [rows[at][2] for at in range(3)] == [1.0, 2.0, 3.0]


async def test_change_is_sealed_and_the_gateways_own_refusal_is_shown_with_its_place(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    wanted = FIRST.replace("name: Speed", "name: Pace")
    asking = asyncio.create_task(admin.post(AT, json={"text": wanted, "base": digest_of(FIRST)}))
    asked = await gateway.hear(ChangeRequest)
    assert decompress_text(asked.source) == wanted
    key_hash = hashlib.sha256(hub.keys["agv"].encode()).hexdigest()
    assert asked.seal == seal_of(
        key_hash, change_id=asked.id, who="admin", base=digest_of(FIRST), text=wanted
    )
    problem = DescriptionProblem(
        where="$.devices.base.signals.speed.name", problem="not that", remedy="no"
    )
    await gateway.say(
        ChangeState(id=asked.id, phase=ChangePhase.REFUSED, message="not now", problems=[problem])
    )
    answer = (await asking).json()
    assert answer["phase"] == "refused"
    assert answer["message"] == "not now"
    assert answer["findings"][0]["line"] == 11


async def test_going_back_asks_the_gateway_for_the_old_text_and_keeps_who_did_it(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    page = await hub.page("admin")
    await greet(gateway)
    await gateway.say(told(SECOND, renamed={"base/speed": "base/velocity"}))
    await page.hear(EventUpdate, lambda news: news.kind == "description changed")
    asking = asyncio.create_task(admin.post(f"{AT}/1/restore", json={"base": digest_of(SECOND)}))
    asked = await gateway.hear(ChangeRequest)
    assert decompress_text(asked.source) == FIRST
    back = told(FIRST, renamed={"base/velocity": "base/speed"}, change=asked.id)
    await gateway.say(back)
    await page.hear(EventUpdate, lambda news: news.kind == "description changed")
    await gateway.say(ChangeState(id=asked.id, phase=ChangePhase.APPLIED))
    assert (await asking).json()["phase"] == "applied"
    newest = (await versions(admin))[0]
    assert (newest["number"], newest["who"], newest["note"]) == (3, "admin", "back to version 1")


async def test_change_of_what_is_not_there_any_more_is_refused_before_it_is_sent(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    answer = await admin.post(AT, json={"text": SECOND, "base": digest_of(SECOND)})
    assert answer.status_code == 409
    assert answer.json()["code"] == "changed"
    wrong = FIRST.replace("unit: m/s", "decimals: many")
    answer = (await admin.post(AT, json={"text": wrong, "base": digest_of(FIRST)})).json()
    assert answer["phase"] == "refused"
    assert (answer["findings"][0]["line"], answer["findings"][0]["column"]) == (12, 9)


async def test_lost_link_leaves_nobody_waiting(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    wanted = FIRST.replace("name: Speed", "name: Pace")
    asking = asyncio.create_task(admin.post(AT, json={"text": wanted, "base": digest_of(FIRST)}))
    await gateway.hear(ChangeRequest)
    await gateway.close()
    assert (await asking).json()["phase"] == "unknown"


async def test_form_edit_keeps_comments_and_order(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    checked = (await admin.post(f"{AT}/check", json={"text": FIRST})).json()
    site = checked["site"]
    site["devices"]["base"]["signals"]["speed"]["maximum"] = 2.0
    edited = (await admin.post(f"{AT}/edit", json={"text": FIRST, "site": site})).json()
    assert edited["findings"] == []
    assert edited["text"].startswith("# The workshop's robot.")
    assert "speed:  # by the wheels" in edited["text"]
    assert "maximum: 2.0" in edited["text"]


@pytest.mark.parametrize("number", ["{}", "[1, {}]", "{{? {} : 1}}"])
async def test_number_of_thousands_of_digits_is_a_finding_with_its_place(hub, number) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    text = FIRST.replace("talaia: 1", f"talaia: {number.format('0x' + 'f' * 5_000)}")
    assert text != FIRST
    answer = await admin.post(f"{AT}/check", json={"text": text})
    assert answer.status_code == 200, answer.text
    assert "64 bits" in answer.json()["findings"][0]["problem"]
    assert answer.json()["findings"][0]["line"]


async def test_description_as_large_as_one_may_be_is_read_and_a_larger_one_is_not(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    # A line break takes two bytes in JSON: the body is larger than the text.
    large = FIRST + "#\n" * ((MAX_TEXT - len(FIRST.encode())) // 2)
    # What it was made from is not what counts: read whole, and refused for that alone.
    answer = await admin.post(AT, json={"text": large, "base": "0" * 64})
    assert answer.status_code == 409, answer.text
    answer = await admin.post(AT, json={"text": large + "###", "base": "0" * 64})
    assert answer.status_code == 422
    # Of all other routes the limit stays as it was.
    answer = await admin.post("/api/gateways/codes", json={"site": "agv", "name": large})
    assert answer.status_code == 413


async def test_problem_of_the_gateways_own_file_is_shown(hub) -> None:
    gateway, admin = await hub.gateway(), await hub.client("admin")
    await greet(gateway)
    problem = DescriptionProblem(
        where="$.devices", problem="there is no device", remedy="describe one"
    )
    await gateway.say(
        ChangeState(phase=ChangePhase.REFUSED, message="cannot be used", problems=[problem])
    )
    async with asyncio.timeout(PATIENCE_S):
        while not (shown := (await admin.get(AT)).json())["problem"]:  # noqa: ASYNC110
            await asyncio.sleep(0.02)
    assert shown["findings"][0]["problem"] == "there is no device"
