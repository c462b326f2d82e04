"""A fault that strikes several signals is one alarm, one message and one line, over a restart."""

from __future__ import annotations

import asyncio

from patience import PATIENCE_S

from talaia.hub.anomaly.causes import ONE_CAUSE_US
from talaia.hub.anomaly.shared_causes import AGAIN_US
from talaia.wire.browser import AlarmUpdate

from ...conftest import DESCRIPTION, MemoryHistory, RunningHub

NOW = 1_795_000_000_000_000
SECOND = 1_000_000


def watched(description: str, signal: str, most: float) -> str:
    line = f"      {signal}:\n"
    assert line in description
    more = f"        anomalies: [{{detector: limits, maximum: {most}, rest: 1}}]\n"
    return description.replace(line, line + more, 1)


FAULTY = watched(watched(watched(DESCRIPTION, "speed", 2), "turn_rate", 1), "voltage", 14)
FAULTY += """
alarms:
  base_odd: {name: The base is unusual, kind: anomaly, device: base}
  power_odd: {name: The power is unusual, kind: anomaly, device: power}
"""


async def until(is_so) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


def alarm_of(hub, alarm: str):
    return hub.hub.alarms.engine.find_alarm("agv", alarm)


def cause_of(hub, part: str):
    return hub.hub.anomalies.causes._of["agv"].open[part]


async def lines(client, kind: str = "") -> list[tuple[str, str]]:
    query = {"kind": kind} if kind else {}
    said = (await client.get("/api/sites/agv/events", params=query)).json()
    return [(row["kind"], row["message"]) for row in said["events"]]


def calm(at: int, count: int) -> list[tuple[str, int, float]]:
    return [
        (address, NOW + second * SECOND, 0.1)
        for second in range(at, at + count)
        for address in ("base/speed", "base/turn_rate")
    ]


async def test_a_fault_is_one_alarm_that_grows_is_acknowledged_as_one_and_ends_as_one(
    settings,
) -> None:
    async with RunningHub(settings, MemoryHistory()) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello(FAULTY)
        page, client = await hub.page("operator"), await hub.client("operator")
        await gateway.samples(("base/speed", NOW, 9.0))
        raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
        assert (raised.alarm, raised.why[:7]) == ("base_odd", "Speed: ")
        await gateway.samples(("base/turn_rate", NOW + SECOND, 5.0))
        grown = await page.hear(AlarmUpdate, lambda news: len(news.shares) == 2)
        assert grown.why.startswith("Speed 50 %, Turn rate 50 %: ")
        assert [(one.signal, one.on) for one in grown.shares] == [
            ("base/speed", True),
            ("base/turn_rate", True),
        ]
        answer = await client.post(
            "/api/sites/agv/alarms/base_odd/act", json={"act": "acknowledge"}
        )
        assert answer.is_success
        # Another device is another alarm.
        await gateway.samples(("power/voltage", NOW + SECOND, 20.0))
        await page.hear(
            AlarmUpdate, lambda news: (news.alarm, news.phase) == ("power_odd", "active")
        )
        keys = hub.keys
        began = cause_of(hub, "base").began_us

    # The hub is started anew in the middle of it; its detectors find one of the two again.
    async with RunningHub(settings, MemoryHistory()) as hub:
        hub.keys = keys
        assert alarm_of(hub, "base_odd").state.phase == "acknowledged"
        await until(lambda: len(alarm_of(hub, "base_odd").shares) == 2)
        gateway = await hub.gateway()
        await gateway.hello(FAULTY, boot="boot-2")
        client = await hub.client("operator")
        await gateway.samples(("base/turn_rate", NOW + 9 * SECOND, 5.0))
        await until(lambda: not cause_of(hub, "base").members[1].unsure)
        assert (cause_of(hub, "base").began_us, cause_of(hub, "base").members[1].times) == (
            began,
            1,
        )
        assert alarm_of(hub, "base_odd").state.phase == "acknowledged"
        # What is not found again within some minutes has ended; the rest ends when it is calm.
        causes = hub.hub.anomalies.causes
        causes._sure_us -= AGAIN_US
        await gateway.samples(*calm(20, 12))
        await until(lambda: not cause_of(hub, "base").on)
        cause_of(hub, "base").newest_us -= ONE_CAUSE_US
        await until(lambda: alarm_of(hub, "base_odd").state.phase == "normal")
        assert [on for _, _, on in alarm_of(hub, "base_odd").shares] == [False, False]
        told = (await client.get("/api/sites/agv/alarms/base_odd/history")).json()
        kinds = [one["what"] for one in told["past"]]
        assert sorted(kinds) == ["acknowledged", "cleared", "raised"]
        shown = await lines(client)
        assert [kind for kind, _ in shown].count("anomaly began") == 2
        assert not [kind for kind, _ in shown if kind.startswith("anomaly part")]
        asked = [kind for kind, _ in await lines(client, "anomaly")]
        assert asked.count("anomaly part began") >= 1
