"""Detectors at the hub: fed by the link, told as events, kept in history, taught by people."""

from __future__ import annotations

import asyncio

import pytest

from talaia.clock import SystemClock
from talaia.hub.api.anomaly_shapes import AnomalyList
from talaia.hub.live.watching import Watching
from talaia.wire.browser import EventNews

from .conftest import DEADLINE_S, DESCRIPTION

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
SPEED = "      speed:\n"
WATCHED = DESCRIPTION.replace(
    SPEED,
    SPEED + "        anomalies: [{detector: limits, maximum: 2, rest: 5}, {detector: iqr}]\n",
    1,
)
assert WATCHED != DESCRIPTION


@pytest.fixture
async def watched(hub):
    gateway = await hub.gateway()
    await gateway.hello(WATCHED)
    yield gateway
    await gateway.close()


async def until(is_so) -> None:
    async with asyncio.timeout(DEADLINE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


async def test_an_anomaly_is_told_when_it_begins_and_when_it_ends(hub, watched) -> None:
    page = await hub.page("operator")
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    began = await page.hear(EventNews, lambda news: news.kind == "anomaly began")
    assert began.device == "base"
    assert began.message.endswith("2.5 m/s is above the most of 2 m/s")
    assert began.time_us == NOW + SECOND
    assert not began.good
    rows = [("base/speed", NOW + (2 + at) * SECOND, 0.5) for at in range(12)]
    await watched.samples(*rows)
    ended = await page.hear(EventNews, lambda news: news.kind == "anomaly ended")
    assert ended.time_us == NOW + SECOND
    assert ended.good


async def test_scores_are_kept_as_a_channel_beside_the_signal(hub, watched, history) -> None:
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    await until(lambda: history.knows("agv", "base/speed~limits"))
    kept = [
        row[1:3]
        for (_, boot), stored in history.samples.items()
        if boot.startswith("scores-")
        for row in stored.values()
        if row[0] == "base/speed~limits"
    ]
    assert kept == [(NOW, 0.0), (NOW + SECOND, 1.0)]


async def test_samples_out_of_order_are_counted_and_not_looked_at(hub, watched) -> None:
    await watched.samples(("base/speed", NOW, 0.5))
    await watched.samples(("base/speed", NOW - SECOND, 9.0))
    await until(lambda: hub.hub._watching.of("agv")[0].late == 1)
    assert hub.hub._watching.of("agv")[0].episodes.began_us == -1


async def test_a_person_says_not_an_anomaly_and_the_detector_learns(hub, watched) -> None:
    rows = [("base/speed", NOW + at * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(60)]
    await watched.samples(*rows, ("base/speed", NOW + 60 * SECOND, 0.9))
    of = hub.hub._watching.of
    await until(lambda: of("agv") and of("agv")[1].episodes.began_us > 0)
    page = await hub.page("operator")
    client = await hub.client("operator")
    answer = await client.post(
        "/api/sites/agv/anomalies/forgiven", json={"address": "base/speed", "detector": "iqr"}
    )
    assert answer.json() == {"learned": True}
    overview = AnomalyList.model_validate((await client.get("/api/sites/agv/anomalies")).json())
    assert [each.detector for each in overview.detectors] == ["limits", "iqr"]
    assert overview.detectors[1].began_us == -1
    await page.hear(EventNews, lambda news: news.kind == "anomaly ended")
    assert of("agv")[1].detector.k > 1.5


async def test_what_was_learned_survives_the_hub(hub, watched) -> None:
    rows = [("base/speed", NOW + at * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(60)]
    await watched.samples(*rows)
    watching = hub.hub._watching
    await until(lambda: len(watching.of("agv")[1].detector.recent.came) == 60)
    await watching.close()
    kept = await watching._learned.of("agv")
    assert set(kept) == {("base/speed", "limits"), ("base/speed", "iqr")}
    live = hub.hub._sites.get("agv")
    after = Watching(hub.hub._sites, hub.history, watching._learned, SystemClock())
    await after._wake(live, after._watch(live))
    assert after.of("agv")[1].detector.recent == watching.of("agv")[1].detector.recent


async def test_a_guest_sees_public_detectors_and_teaches_none(hub, watched) -> None:
    client = await hub.client("guest")
    said = AnomalyList.model_validate((await client.get("/api/sites/agv/anomalies")).json())
    assert len(said.detectors) == 2
    assert not said.may_forgive
    asked = {"address": "base/speed", "detector": "iqr"}
    assert (await client.post("/api/sites/agv/anomalies/forgiven", json=asked)).status_code == 403


async def test_a_detector_that_fails_begins_anew_and_the_others_go_on(hub, watched) -> None:
    watching = hub.hub._watching
    live = hub.hub._sites.get("agv")
    limits, broken = watching._watch(live).every()

    def fail(_time_us: int, _value: float) -> float:
        raise ValueError("broken on purpose")

    broken.see = fail
    await watched.samples(("base/speed", NOW, 9.0))
    await until(lambda: limits.episodes.began_us == NOW)
    await until(lambda: watching.of("agv")[1] is not broken)


async def test_what_finds_no_room_is_skipped_and_counted(hub, watched) -> None:
    watching = hub.hub._watching
    watching._count = 20_000
    await watched.samples(("base/speed", NOW, 9.0))
    await until(lambda: watching.skipped == 1)
    watching._count = 0


SERVED = WATCHED + "\nservices: {anomaly_detection: true}\n"


@pytest.fixture
async def served(hub):
    gateway = await hub.gateway()
    await gateway.hello(SERVED)
    yield gateway
    await gateway.close()


async def test_service_watches_primary_numbers_that_have_no_detector_of_their_own(
    hub, served
) -> None:
    found = {}
    for each in hub.hub._watching.of("agv"):
        found.setdefault(each.address, []).append(str(each.watch.detector))
    assert found["base/speed"] == ["limits", "iqr"]
    assert found["power/voltage"] == ["together"]
    # A state, a position, and a number that is not on the first page.
    assert not {"base/wandering", "base/pose", "base/pose.x", "sensors/speed1"} & set(found)


async def test_without_the_service_nothing_but_the_described_is_watched(hub, watched) -> None:
    assert {each.address for each in hub.hub._watching.of("agv")} == {"base/speed"}


async def test_service_looks_at_one_sample_a_second_of_a_fast_signal(hub, served) -> None:
    looked = {"base/turn_rate": [], "base/speed": []}
    for each in hub.hub._watching.of("agv"):
        if each.address in looked and each.watch.detector != "iqr":
            each.see = lambda time_us, _value, seen=looked[each.address]: seen.append(time_us)
    rows = [("base/turn_rate", NOW + at * SECOND // 100, 0.1) for at in range(300)]
    for at in range(0, 300, 5):
        await served.samples(*rows[at : at + 5])
    # What is described itself is looked at as it comes.
    await served.samples(*[("base/speed", NOW + at * SECOND // 100, 0.5) for at in range(50)])
    await until(lambda: len(looked["base/speed"]) == 50)
    assert [each - NOW for each in looked["base/turn_rate"]] == [0, 900_000, 1_800_000, 2_700_000]


async def test_service_tells_what_it_finds(hub, served) -> None:
    page = await hub.page("operator")
    rows = [("power/voltage", NOW + at * SECOND, 12.0 + 0.01 * (at % 7)) for at in range(400)]
    await served.samples(*rows)
    await served.samples(
        *[("power/voltage", NOW + (400 + at) * SECOND, 9.0 + 0.01 * (at % 7)) for at in range(30)]
    )
    began = await page.hear(EventNews, lambda news: news.kind == "anomaly began")
    assert began.device == "power"
    assert began.time_us >= NOW + 400 * SECOND
