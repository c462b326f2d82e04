"""An alarm's way through a hub that really serves: raised, told, acknowledged, kept."""

from __future__ import annotations

import asyncio
import dataclasses
import ipaddress
import time

import pytest
from patience import PATIENCE_S

from talaia.hub.ports import AnomalyReport, AnomalySink, SightingEvent, SightingSink
from talaia.wire.browser import AlarmUpdate, EventUpdate, SightingUpdate
from talaia.wire.frames import RecordingRequest, SightingReport

from ..conftest import DESCRIPTION, RunningHub
from ..mailbox import mail_way, want_mail

LOW = """
alarms:
  low:
    name: Battery low
    kind: limit
    signal: power/voltage
    below: 11
    severity: critical
    max_age: 3600
    record: true
    advice: Bring it home.
"""


def now_us() -> int:
    return time.time_ns() // 1000


@pytest.fixture
async def watched(hub):
    """The connected gateway of a vehicle with an alarm."""
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + LOW)
    return gateway


async def test_an_alarm_is_raised_told_acknowledged_and_cleared(hub, watched):
    page = await hub.page("operator")
    await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    await watched.samples(("power/voltage", now_us(), 10.0))
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    assert (raised.severity, raised.device, raised.why) == (
        "critical",
        "power",
        "Voltage is 10 V, below 11 V",
    )
    assert (await watched.hear(RecordingRequest)).alarm
    mark = await page.hear(EventUpdate, lambda news: news.kind == "alarm raised")
    assert not mark.good
    client = await hub.client("operator")
    done = await client.post("/api/sites/agv/alarms/low/act", json={"act": "acknowledge"})
    assert done.status_code == 204, done.text
    seen = await page.hear(AlarmUpdate, lambda news: news.phase == "acknowledged")
    assert seen.acked_by == "operator"
    await watched.samples(("power/voltage", now_us(), 12.0))
    await page.hear(AlarmUpdate, lambda news: news.phase == "normal" and news.cleared_us)
    past = (await client.get("/api/sites/agv/alarms/low/history")).json()["past"]
    assert [each["what"] for each in past] == ["cleared", "acknowledged", "raised"]
    events = (await client.get("/api/sites/agv/events", params={"kind": "alarm"})).json()
    assert [each["kind"] for each in events["events"]] == [
        "alarm cleared",
        "alarm acknowledged",
        "alarm raised",
    ]


@pytest.fixture
def settings(settings):
    return dataclasses.replace(settings, notify_networks=(ipaddress.ip_network("127.0.0.0/8"),))


async def test_the_mail_of_an_alarm_reaches_a_mail_server(hub, watched, mailbox):
    await want_mail(hub, mailbox)
    await watched.samples(("power/voltage", now_us(), 10.0))
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    assert mailbox.envelopes[0].rcpt_tos == ["op@example.org"]
    said = mailbox.text()
    assert "Battery low (critical)" in said.splitlines()[0]
    assert "Voltage is 10 V, below 11 V" in said
    assert "Bring it home." in said


async def test_a_rule_is_changed_in_place_under_the_checks_of_a_new_one(hub, mailbox):
    rule = await want_mail(hub, mailbox)
    operator, admin = await hub.client("operator"), await hub.client("admin")
    (kept,) = (await operator.get("/api/me/rules")).json()["rules"]
    asked = {key: said for key, said in kept.items() if key != "id"}
    changed = {**asked, "least": "critical", "over": False, "quiet_from": 60, "quiet_to": 120}
    path = f"/api/me/rules/{rule}"
    for wrong in ({"target": "nobody"}, {"way": "99"}, {"zone": "Moon"}, {"quiet_to": 1440}):
        assert (await operator.put(path, json={**changed, **wrong})).status_code == 422, wrong
    assert (await admin.put(path, json=changed)).status_code == 404
    assert (await operator.put("/api/me/rules/99", json=changed)).status_code == 404
    assert (await operator.get("/api/me/rules")).json()["rules"] == [kept]
    done = await operator.put(path, json=changed)
    assert done.status_code == 204, done.text
    assert (await operator.get("/api/me/rules")).json()["rules"] == [{**changed, "id": rule}]
    assert (await operator.delete(path)).status_code == 204
    assert (await operator.put(path, json=changed)).status_code == 404
    noted = (await admin.get("/api/audit", params={"kind": "rule of alarms"})).json()["rows"]
    assert [(row["kind"], row["who"]) for row in noted] == [
        ("rule of alarms removed", "operator"),
        ("rule of alarms changed", "operator"),
        ("rule of alarms added", "operator"),
    ]


async def test_what_a_changed_rule_has_gathered_is_told_once_and_to_the_new_address(
    hub, watched, mailbox
):
    rule = await want_mail(hub, mailbox, group_s=2)
    operator = await hub.client("operator")
    (kept,) = (await operator.get("/api/me/rules")).json()["rules"]
    page = await hub.page("operator")
    await watched.samples(("power/voltage", now_us(), 10.0))
    await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    asked = {key: said for key, said in kept.items() if key != "id"}
    moved = {**asked, "target": "new@example.org", "group_s": 0}
    assert (await operator.put(f"/api/me/rules/{rule}", json=moved)).status_code == 204
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    mailbox.news.clear()
    await watched.samples(("power/voltage", now_us(), 12.0))
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    assert [each.rcpt_tos for each in mailbox.envelopes] == [["new@example.org"]] * 2
    assert "Voltage is 10 V, below 11 V" in mailbox.text(0)
    assert "Voltage is 10 V, below 11 V" not in mailbox.text(1)


SOMEBODY = """
alarms:
  somebody:
    name: Somebody is there
    kind: detection
    stream: camera/front
    label: person
    count: 2
    confidence: 0.6
    severity: critical
    advice: Call the guard.
"""


async def test_two_people_before_a_camera_bring_one_mail(hub, mailbox):
    await want_mail(hub, mailbox, over=False)
    gateway = await hub.gateway()
    page = await hub.page("operator")
    assert "        detect:" in DESCRIPTION
    await gateway.hello(DESCRIPTION + SOMEBODY)
    began = now_us()

    async def see(many: int, *, ended_us: int = 0) -> None:
        seen = SightingReport(
            stream="camera/front", label="person", many=many, confidence=0.8, began_us=began,
            ended_us=ended_us,
        )  # fmt: skip
        await gateway.say(seen)
        await page.hear(SightingUpdate)

    await see(1)
    assert not any(getattr(each, "phase", "") == "active" for each in page.heard)
    await see(2)
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    assert (raised.device, raised.why) == ("camera", "2 × person seen (80% sure)")
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    said = mailbox.text()
    assert "Somebody is there (critical)" in said.splitlines()[0]
    assert "2 × person seen" in said
    assert "Call the guard." in said
    await see(2, ended_us=began + 5_000_000)
    await page.hear(AlarmUpdate, lambda news: news.cleared_us)
    # Said once more, and better known, since the link was cut before it was surely heard.
    await gateway.say(
        SightingReport(
            stream="camera/front", label="person", many=2, confidence=0.8, began_us=began,
            ended_us=began + 6_000_000,
        )
    )  # fmt: skip
    began += 60_000_000
    await see(1, ended_us=began + 1)
    client = await hub.client("operator")
    past = (await client.get("/api/sites/agv/alarms/somebody/history")).json()["past"]
    assert [each["what"] for each in past] == ["cleared", "raised"]
    assert len(mailbox.envelopes) == 1


async def test_an_alarm_that_could_not_be_delivered_says_so_on_the_page(hub, watched, mailbox):
    await want_mail(hub, mailbox)
    mailbox.answer = "550 nobody of that name here"
    page = await hub.page("operator")
    await watched.samples(("power/voltage", now_us(), 10.0))
    news = await page.hear(AlarmUpdate, lambda news: news.undelivered)
    assert "550 nobody of that name here" in news.undelivered


async def test_a_test_message_shows_the_real_error(hub, mailbox):
    rule = await want_mail(hub, mailbox)
    operator = await hub.client("operator")
    mailbox.answer = "550 nobody of that name here"
    refused = (await operator.post(f"/api/me/rules/{rule}/test")).json()
    assert not refused["sent"]
    assert "550 nobody of that name here" in refused["problem"]
    mailbox.answer = "250 OK"
    assert (await operator.post(f"/api/me/rules/{rule}/test")).json() == {
        "sent": True,
        "problem": "",
    }


async def test_a_server_that_only_the_hub_can_reach_is_refused(hub, mailbox):
    hub.hub.notifications.sender._networks.clear()
    rule = await want_mail(hub, mailbox)
    went = (await (await hub.client("operator")).post(f"/api/me/rules/{rule}/test")).json()
    assert "no public address" in went["problem"]
    assert not mailbox.envelopes


async def test_secrets_of_a_way_are_never_given_back_nor_sent_to_another_server(hub):
    admin = await hub.client("admin")
    way = {**mail_way(25), "security": "tls", "user": "me", "secrets": {"password": "hush hush"}}
    number = (await admin.post("/api/ways", json=way)).json()["id"]
    listed = await admin.get("/api/ways")
    assert "hush hush" not in listed.text
    assert listed.json()["ways"][0]["secrets"] == ["password"]
    way.pop("secrets")
    assert (await admin.put(f"/api/ways/{number}", json=way)).status_code == 204
    assert (await admin.get("/api/ways")).json()["ways"][0]["secrets"] == ["password"]
    assert (
        await admin.put(f"/api/ways/{number}", json={**way, "host": "evil.test"})
    ).status_code == 204
    assert (await admin.get("/api/ways")).json()["ways"][0]["secrets"] == []


async def test_what_comes_in_a_burst_is_one_message(hub, mailbox):
    many = "".join(
        f"  low{n}: {{name: Low {n}, kind: limit, signal: power/voltage, below: 11, max_age: 99}}\n"
        for n in range(5)
    )
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + "\nalarms:\n" + many)
    await want_mail(hub, mailbox, group_s=1)
    await gateway.samples(("power/voltage", now_us(), 10.0))
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    assert all(f"Low {n}" in mailbox.text() for n in range(5))
    assert len(mailbox.envelopes) == 1


async def test_an_alarm_and_who_acknowledged_it_survive_a_restart(settings, history):
    async with RunningHub(settings, history) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(DESCRIPTION + LOW)
        page = await hub.page("operator")
        await gateway.samples(("power/voltage", now_us(), 10.0))
        await page.hear(AlarmUpdate, lambda news: news.phase == "active")
        client = await hub.client("operator")
        await client.post("/api/sites/agv/alarms/low/act", json={"act": "acknowledge"})
    async with RunningHub(settings, history) as again:
        page = await again.page("operator")
        news = await page.hear(AlarmUpdate)
        assert (news.phase, news.acked_by) == ("acknowledged", "operator")
        past = await (await again.client("operator")).get("/api/sites/agv/alarms/low/history")
        assert [each["what"] for each in past.json()["past"]] == ["acknowledged", "raised"]


async def test_an_alarm_made_in_the_page_works_and_one_that_does_not_fit_says_where(hub, gateway):
    admin, page = await hub.client("admin"), await hub.page("operator")
    fast = {
        "name": "Fast",
        "kind": "expression",
        "expression": "abs({base/speed}) > 1 and {power/voltage} > 0",
        "max_age": 3600,
    }
    wrong = await admin.put(
        "/api/sites/agv/alarms/fast", json={**fast, "expression": "{base/sped} > 1"}
    )
    assert wrong.status_code == 422
    assert "at letter 1: there is no signal 'base/sped'" in wrong.json()["message"]
    made = await admin.put("/api/sites/agv/alarms/fast", json=fast)
    assert made.status_code == 204, made.text
    await gateway.samples(("base/speed", now_us(), -2.0))
    why = "Voltage has never been heard of"
    unknown = await page.hear(AlarmUpdate, lambda news: news.unknown_why == why)
    assert (unknown.phase, unknown.known) == ("normal", False)
    await gateway.samples(("power/voltage", now_us(), 12.0))
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    # About two devices: of the whole site.
    assert raised.device == ""
    assert (await admin.delete("/api/sites/agv/alarms/fast")).status_code == 204
    await page.hear(AlarmUpdate, lambda news: news.gone)


async def test_detectors_raise_alarms_by_one_line(hub):
    described = """
alarms:
  someone:
    {name: Someone, kind: detection, stream: camera/front, label: person, confidence: 0.6}
  odd: {name: Odd speed, kind: anomaly, signal: base/speed, score: 0.7, max_age: 3600}
"""
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + described)
    page = await hub.page("operator")
    seeing: SightingSink = hub.hub.alarms.engine
    feeling: AnomalySink = hub.hub.alarms.engine
    seen = SightingEvent("agv", "camera/front", "person", 1, 0.9, 1_000, None)
    seeing.report_sighting(seen._replace(confidence=0.5))
    seeing.report_sighting(seen)
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    assert (raised.alarm, raised.why) == ("someone", "person seen (90% sure)")
    seeing.report_sighting(seen._replace(ended_us=2_000))
    await page.hear(AlarmUpdate, lambda news: news.phase == "cleared")
    # Told only when it was over, it has been there all the same.
    await gateway.samples(("base/speed", now_us(), 0.1))
    odd = AnomalyReport("agv", "base/speed", "baseline", 5_000, 6_000, 0.9, "far from its median")
    feeling.report_anomaly(odd._replace(score=0.2))
    feeling.report_anomaly(odd)
    raised = await page.hear(AlarmUpdate, lambda news: news.alarm == "odd" and news.raised_us)
    assert "far from its median" in raised.why
