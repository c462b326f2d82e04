"""Groups of signals at the hub: judged together, told with their shares, taught by a stretch."""

from __future__ import annotations

import asyncio
import random

import pytest
from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.hub.api.schemas.anomaly_schemas import AnomalyList
from talaia.hub.live.detection.anomaly_service import AnomalyService
from talaia.wire.browser import AlarmUpdate, AnomalyUpdate, EventUpdate, Subscribe, Subscribed

from ...conftest import DESCRIPTION

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
LEARNED = 100
GROUP = f"""
anomaly_groups:
  body:
    name: The body
    signals: [base/speed, base/turn_rate, power/voltage]
    learn: {LEARNED}
  driving:
    signals: [base/speed, base/turn_rate]
    state: base/wandering
    learn: 60
alarms:
  unusual:
    name: Something about the body
    kind: anomaly
    signal: /body
"""


# A device beside the others with a single number, before what follows the devices.
MAINS = """
devices:
  mains:
    name: Mains
    signals:
      voltage:
        name: Voltage
        source: {topic: /mains, type: std_msgs/msg/Float32, field: data}
"""
ALONE = DESCRIPTION.replace("\ndevices:\n", MAINS, 1) + "\nservices: {anomaly_detection: true}\n"


def samples(count: int, first: int = 0, **change: float) -> list[tuple[str, int, float]]:
    """Make what a robot sends in so many seconds; ``change`` is added to a signal."""
    chance, rows = random.Random(first), []  # noqa: S311 - noise
    for at in range(first, first + count):
        load = chance.gauss(0.0, 1.0)
        for address, key, value in (
            ("base/speed", "speed", 0.5 + 0.05 * load),
            ("base/turn_rate", "turn", chance.gauss(0.0, 0.01)),
            ("power/voltage", "voltage", 12.0 - 0.1 * load + chance.gauss(0.0, 0.01)),
        ):
            rows.append((address, NOW + at * SECOND, value + change.get(key, 0.0)))
    return rows


@pytest.fixture
async def grouped(hub):
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + GROUP)
    yield gateway
    await gateway.close()


def runner_of(hub, key: str = "body"):
    return hub.hub.anomalies.detectors.find_group("agv", f"/{key}")


async def until(is_so) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


async def overview(client) -> dict[str, object]:
    said = AnomalyList.model_validate((await client.get("/api/sites/agv/anomalies")).json())
    return {each.address: each for each in said.detectors}


async def test_an_anomaly_across_signals_is_told_with_the_shares_of_those_that_made_it_so(
    hub, grouped
) -> None:
    page, guest = await hub.page("operator"), await hub.page("guest")
    await grouped.samples(*samples(LEARNED + 1))
    learned = await page.hear(AnomalyUpdate, lambda news: news.address == "/body")
    assert (learned.learning, learned.on) == (0, False)
    await grouped.samples(*samples(60, LEARNED + 1, voltage=-1.5))
    began = await page.hear(AnomalyUpdate, lambda news: news.on and news.address == "/body")
    assert (began.detector, began.device) == ("group", "")
    first = began.shares[0]
    assert (first.signal, first.share > 0.5, first.spreads < -3) == ("power/voltage", True, True)
    assert sum(each.share for each in began.shares) == pytest.approx(1.0)
    event = await page.hear(EventUpdate, lambda news: news.kind == "anomaly began")
    assert event.message.startswith("The body: together 3 signals are")
    assert "below its level" in event.message
    raised = await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    assert raised.why.startswith("The body is unusual: together 3 signals")
    await grouped.samples(*samples(400, LEARNED + 61))
    ended = await page.hear(AnomalyUpdate, lambda news: news.to_us and news.address == "/body")
    assert ended.shares[0].signal == "power/voltage"
    shown = (await overview(await hub.client("operator")))["/body"]
    assert (shown.title, shown.signals[2]) == ("The body", "power/voltage")
    assert shown.shares[0].signal == "power/voltage"
    # One of its signals is not for a guest, who is told of none of it.
    assert not [each for each in guest.heard if isinstance(each, AnomalyUpdate)]
    assert "/body" not in await overview(await hub.client("guest"))


async def test_its_score_is_a_channel_for_those_who_see_all_of_its_signals(
    hub, grouped, history
) -> None:
    page, guest = await hub.page("operator"), await hub.page("guest")
    for each, refused in ((page, []), (guest, ["/body~group"])):
        await each.say(Subscribe(sub=1, site="agv", channels=["/body~group"], every_ms=0))
        assert (await each.hear(Subscribed)).refused == refused
    await grouped.samples(*samples(3))
    await until(lambda: history.has_channel("agv", "/body~group"))
    query = {"channel": "/body~group", "from_us": NOW, "to_us": NOW + 9 * SECOND}
    for name, status in (("operator", 200), ("guest", 404)):
        client = await hub.client(name)
        answer = await client.get("/api/sites/agv/history", params=query)
        assert answer.status_code == status
    stored = (await (await hub.client("operator")).get("/api/sites/agv/history/stored")).json()
    assert "/body~group" not in str(stored)


async def test_a_group_learns_from_a_stretch_that_a_person_calls_usual(hub, grouped) -> None:
    await grouped.samples(*samples(300))
    client = await hub.client("operator")
    asked = {"address": "/body", "from_us": NOW, "to_us": NOW + 300 * SECOND, "comment": "Tuesday"}
    guest = await hub.client("guest")
    path = "/api/sites/agv/anomalies/learned"
    assert (await guest.post(path, json=asked)).status_code == 403
    await until(lambda: runner_of(hub).detector.heard == 299)
    answer = await client.post(path, json=asked)
    assert answer.json() == {"rows": 300, "modes": [], "still": []}
    assert runner_of(hub).learning == 0
    assert runner_of(hub).detector.learn_rows == LEARNED
    page = await hub.page("operator")
    await grouped.samples(*samples(60, 300, voltage=-1.5))
    await page.hear(AnomalyUpdate, lambda news: news.on and news.address == "/body")
    audit = await hub.client("admin")
    said = (await audit.get("/api/audit", params={"limit": 50})).text
    assert "The body: 300 steps: Tuesday" in said


async def test_a_group_by_states_learns_each_of_them_and_says_which_it_could_not(
    hub, grouped
) -> None:
    rows = [("base/wandering", NOW, 0.0), *samples(150)]
    await grouped.samples(*rows)
    await until(lambda: runner_of(hub, "driving").detector.heard == 149)
    assert runner_of(hub, "driving").mode == "off"
    client = await hub.client("operator")
    asked = {"address": "/driving", "from_us": NOW, "to_us": NOW + 150 * SECOND}
    answer = await client.post("/api/sites/agv/anomalies/learned", json=asked)
    assert answer.json() == {"rows": 150, "modes": ["off"], "still": ["on"]}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"to_us": NOW + 20 * SECOND}, "at least 60 steps of 1 s with samples, found 20"),
        ({"from_us": NOW - 400_000 * SECOND}, "expected at most 8.3 h to learn from"),
        ({"to_us": 2**60}, "to_us not in the future"),
        ({"from_us": NOW + 90 * SECOND, "to_us": NOW}, "expected from_us before to_us"),
        ({"address": "/nothing"}, "no such group"),
    ],
)
async def test_a_stretch_that_nothing_can_be_learned_from_is_refused(
    hub, grouped, change, says
) -> None:
    await grouped.samples(*samples(90))
    await until(lambda: runner_of(hub).detector.heard == 89)
    client = await hub.client("operator")
    asked = {"address": "/body", "from_us": NOW, "to_us": NOW + 90 * SECOND} | change
    answer = await client.post("/api/sites/agv/anomalies/learned", json=asked)
    assert answer.status_code in (404, 422)
    assert says in answer.text


async def test_not_an_anomaly_ends_it_and_what_was_learned_survives_the_hub(hub, grouped) -> None:
    page, client = await hub.page("operator"), await hub.client("operator")
    await grouped.samples(*samples(LEARNED + 1))
    await grouped.samples(*samples(60, LEARNED + 1, voltage=-1.5))
    await page.hear(AnomalyUpdate, lambda news: news.on and news.address == "/body")
    watching = hub.hub.anomalies.detectors
    asked = {"address": "/body", "detector": "group"}
    answer = await client.post("/api/sites/agv/anomalies/forgiven", json=asked)
    assert answer.json() == {"learned": True}
    marked = await page.hear(AnomalyUpdate, lambda news: news.forgiven)
    assert not marked.on
    await watching.close()
    after = AnomalyService(
        sites=hub.hub.core.sites,
        history=hub.history,
        learned=watching._learned,
        fanout=hub.hub.core.fanout,
        clock=SystemClock(),
    )
    live = hub.hub.core.sites.find_site("agv")
    await after._restore_learned(live, after._watch_of(live))
    kept = after.find_group("agv", "/body").detector.members[0]
    assert kept.limit == runner_of(hub).detector.members[0].limit > 0.0
    assert kept.covariance.tolist() == runner_of(hub).detector.members[0].covariance.tolist()


async def test_another_name_or_bar_keeps_what_was_learned_and_other_signals_do_not(
    hub, grouped
) -> None:
    await grouped.samples(*samples(LEARNED + 1))
    await until(lambda: runner_of(hub).learning == 0)
    await grouped.close()
    renamed = GROUP.replace("The body", "Corpus").replace("learn: 100", "learn: 100\n    bar: 0.6")
    again = await hub.gateway()
    await again.hello(DESCRIPTION + renamed, boot="boot-2")
    await until(lambda: runner_of(hub).group.name == "Corpus")
    assert (runner_of(hub).learning, runner_of(hub).episodes.bar) == (0, 0.6)
    await again.close()
    other = await hub.gateway()
    await other.hello(DESCRIPTION + GROUP.replace(", power/voltage", ""), boot="boot-3")
    await until(lambda: len(runner_of(hub).members) == 2)
    assert runner_of(hub).learning == LEARNED
    await other.close()


async def test_the_switch_makes_a_group_of_each_device_that_has_several_numbers(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + "\nservices: {anomaly_detection: true}\n")
    client = await hub.client("operator")
    found = await overview(client)
    groups = {address: each for address, each in found.items() if each.detector == "group"}
    assert sorted(groups) == ["/base", "/power", "/sensors"]
    assert groups["/power"].signals == ["power/charge", "power/voltage"]
    await gateway.close()


async def test_a_device_with_one_number_is_a_group_that_nothing_can_be_learned_or_tried_of(
    hub,
) -> None:
    gateway = await hub.gateway()
    await gateway.hello(ALONE)
    client = await hub.client("operator")
    found = await overview(client)
    assert found["/mains"].signals == ["mains/voltage"]
    window = {"from_us": NOW, "to_us": NOW + 90 * SECOND}
    asked = {"address": "/mains", "detector": "group"} | window
    tried = await client.post("/api/sites/agv/anomalies/tests", json=asked)
    learned = await client.post(
        "/api/sites/agv/anomalies/learned", json={"address": "/mains"} | window
    )
    for answer in (tried, learned):
        assert answer.status_code == 422
        assert "has one number, which is judged against others under a budget" in answer.text
    await gateway.close()


async def test_numbers_of_other_devices_explain_those_of_a_group_of_the_switch(hub) -> None:
    gateway = await hub.gateway()
    switch = "services: {anomaly_detection: true, false_alarms_a_week: 1}"
    await gateway.hello(f"{DESCRIPTION}{GROUP}\n{switch}\n")
    power, body = runner_of(hub, "power"), runner_of(hub, "body")
    assert set(power.members) == {"power/charge", "power/voltage"}
    assert "base/speed" in power.group.beside
    assert not set(power.group.beside) & set(power.members)
    # What a person chose is looked at by itself.
    assert body.group.beside == ()
    client = await hub.client("operator")
    await client.put("/api/sites/agv/anomalies/budget", json={"a_week": 2})
    assert power.tail is not None
    await gateway.samples(*samples(30))
    await until(lambda: power.residuals.heard >= 20)
    speed = power.watched.index("base/speed")
    assert power.residuals.held.values[speed] == pytest.approx(0.5, abs=0.3)
    await gateway.close()
