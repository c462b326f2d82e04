"""Detectors at the hub: fed by the link, told as events, kept in history, taught by people."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.hub.api.schemas.anomaly_schemas import AnomalyList
from talaia.hub.live.detection.anomaly_service import AnomalyService
from talaia.wire.browser import AnomalyUpdate, EventUpdate, Subscribe, Subscribed, Values
from talaia.wire.columns import unpack_columns

from ...conftest import DESCRIPTION

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
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


async def test_an_anomaly_is_told_when_it_begins_and_when_it_ends(hub, watched) -> None:
    page = await hub.page("operator")
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    began = await page.hear(EventUpdate, lambda news: news.kind == "anomaly began")
    assert began.device == "base"
    assert began.message.endswith("2.5 m/s is above the most of 2 m/s")
    assert began.time_us == NOW + SECOND
    assert not began.good
    rows = [("base/speed", NOW + (2 + at) * SECOND, 0.5) for at in range(12)]
    await watched.samples(*rows)
    ended = await page.hear(EventUpdate, lambda news: news.kind == "anomaly ended")
    assert ended.time_us == NOW + SECOND
    assert ended.good


async def test_scores_are_kept_as_a_channel_beside_the_signal(hub, watched, history) -> None:
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    await until(lambda: history.has_channel("agv", "base/speed~limits"))
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
    await until(lambda: hub.hub.anomalies.detectors.detectors_of("agv")[0].late == 1)
    assert hub.hub.anomalies.detectors.detectors_of("agv")[0].episodes.began_us == -1


async def test_a_person_says_not_an_anomaly_and_the_detector_learns(hub, watched) -> None:
    rows = [("base/speed", NOW + at * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(60)]
    await watched.samples(*rows, ("base/speed", NOW + 60 * SECOND, 0.9))
    of = hub.hub.anomalies.detectors.detectors_of
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
    await page.hear(EventUpdate, lambda news: news.kind == "anomaly ended")
    assert of("agv")[1].detector.k > 1.5


async def test_what_was_learned_survives_the_hub(hub, watched) -> None:
    rows = [("base/speed", NOW + at * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(60)]
    await watched.samples(*rows)
    watching = hub.hub.anomalies.detectors
    await until(lambda: len(watching.detectors_of("agv")[1].detector.recent.came) == 60)
    await watching.close()
    kept = await watching._learned.states_of("agv")
    assert set(kept) == {("base/speed", "limits"), ("base/speed", "iqr")}
    live = hub.hub.core.sites.find_site("agv")
    after = AnomalyService(
        sites=hub.hub.core.sites,
        history=hub.history,
        learned=watching._learned,
        fanout=hub.hub.core.fanout,
        clock=SystemClock(),
    )
    await after._restore_learned(live, after._watch_of(live))
    assert (
        after.detectors_of("agv")[1].detector.recent
        == watching.detectors_of("agv")[1].detector.recent
    )


async def test_a_guest_sees_public_detectors_and_teaches_none(hub, watched) -> None:
    client = await hub.client("guest")
    said = AnomalyList.model_validate((await client.get("/api/sites/agv/anomalies")).json())
    assert len(said.detectors) == 2
    assert not said.may_forgive
    asked = {"address": "base/speed", "detector": "iqr"}
    assert (await client.post("/api/sites/agv/anomalies/forgiven", json=asked)).status_code == 403


async def test_a_detector_that_fails_begins_anew_and_the_others_go_on(hub, watched) -> None:
    watching = hub.hub.anomalies.detectors
    live = hub.hub.core.sites.find_site("agv")
    limits, broken = watching._watch_of(live).all_runners()

    def fail(_time_us: int, _value: float) -> float:
        raise ValueError("broken on purpose")

    broken.score_sample = fail
    await watched.samples(("base/speed", NOW, 9.0))
    await until(lambda: limits.episodes.began_us == NOW)
    await until(lambda: watching.detectors_of("agv")[1] is not broken)


async def test_what_finds_no_room_is_skipped_and_counted(hub, watched) -> None:
    watching = hub.hub.anomalies.detectors
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
    for each in hub.hub.anomalies.detectors.detectors_of("agv"):
        found.setdefault(each.address, []).append(each.word)
    assert found["base/speed"] == ["limits", "iqr"]
    assert found["power/voltage"] == ["together"]
    # A state, a position, and a number that is not on the first page.
    assert not {"base/wandering", "base/pose", "base/pose.x", "sensors/speed1"} & set(found)


async def test_without_the_service_nothing_but_the_described_is_watched(hub, watched) -> None:
    assert {each.address for each in hub.hub.anomalies.detectors.detectors_of("agv")} == {
        "base/speed"
    }


async def test_service_looks_at_one_sample_a_second_of_a_fast_signal(hub, served) -> None:
    looked = {"base/turn_rate": [], "base/speed": []}
    for each in hub.hub.anomalies.detectors.detectors_of("agv"):
        if each.address in looked and each.word != "iqr":
            each.score_sample = lambda time_us, _value, seen=looked[each.address]: seen.append(
                time_us
            )
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
    began = await page.hear(EventUpdate, lambda news: news.kind == "anomaly began")
    assert began.device == "power"
    assert began.time_us >= NOW + 400 * SECOND


async def scores_of(page, *channels: str) -> Subscribed:
    await page.say(Subscribe(sub=1, site="agv", channels=list(channels), every_ms=0))
    return await page.hear(Subscribed)


async def next_scores(page) -> list[tuple[int, int, float]]:
    news = await page.hear(Values)
    columns = unpack_columns(news)
    rows = (columns.channel.tolist(), columns.time_us.tolist(), columns.value.tolist())
    return list(zip(*rows, strict=True))


async def test_scores_come_over_the_socket_of_a_page_that_asks_for_them(hub, watched) -> None:
    page = await hub.page("operator")
    answer = await scores_of(page, "base/speed", "base/speed~limits", "base/speed~missing")
    # There is no such detector on the signal.
    assert answer.refused == ["base/speed~missing"]
    await watched.samples(("base/speed", NOW, 2.5))
    assert await next_scores(page) == [(0, NOW, 2.5)]
    assert await next_scores(page) == [(1, NOW, 1.0)]
    # Who comes later is told how it stands.
    later = await hub.page("operator")
    await scores_of(later, "base/speed~limits")
    assert await next_scores(later) == [(0, NOW, 1.0)]


async def test_scores_that_a_site_does_not_show_any_more_go_to_nobody(hub, watched) -> None:
    page = await hub.page("operator")
    await scores_of(page, "base/speed~limits")
    await watched.samples(("base/speed", NOW, 0.5))
    assert await next_scores(page) == [(0, NOW, 0.0)]
    await watched.close()
    again = await hub.gateway()
    await again.hello(DESCRIPTION, boot="boot-2")
    await again.samples(("base/speed", NOW + SECOND, 2.5))
    fresh = await scores_of(page, "base/speed~limits")
    assert fresh.refused == ["base/speed~limits"]


async def test_a_page_is_told_how_a_detector_stands_when_that_changes(hub, watched) -> None:
    page, guest = await hub.page("operator"), await hub.page("guest")
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    # Its signal is public, so a guest is told as well.
    for each in (page, guest):
        began = await each.hear(AnomalyUpdate, lambda news: news.on)
        assert (began.address, began.detector) == ("base/speed", "limits")
        assert (began.from_us, began.to_us) == (NOW + SECOND, 0)
        assert began.why == "2.5 m/s is above the most of 2 m/s"
    rows = [("base/speed", NOW + (2 + at) * SECOND, 0.5) for at in range(12)]
    await watched.samples(*rows)
    ended = await page.hear(AnomalyUpdate, lambda news: not news.on)
    assert (ended.from_us, ended.to_us) == (NOW + SECOND, NOW + SECOND)


async def test_not_an_anomaly_is_told_to_every_page_also_when_it_is_over(hub, watched) -> None:
    usual = [("base/speed", NOW + at * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(60)]
    after = [("base/speed", NOW + (61 + at) * SECOND, 0.5 + 0.01 * (at % 5)) for at in range(20)]
    page = await hub.page("guest")
    await watched.samples(*usual, ("base/speed", NOW + 60 * SECOND, 0.9), *after)
    ended = await page.hear(AnomalyUpdate, lambda news: news.detector == "iqr" and not news.on)
    assert not ended.forgiven
    client = await hub.client("operator")
    asked = {"address": "base/speed", "detector": "iqr"}
    await client.post("/api/sites/agv/anomalies/forgiven", json=asked)
    marked = await page.hear(AnomalyUpdate, lambda news: news.forgiven)
    assert (marked.from_us, marked.why) == (ended.from_us, ended.why)
    overview = AnomalyList.model_validate((await client.get("/api/sites/agv/anomalies")).json())
    limits, iqr = overview.detectors
    assert (iqr.forgiven, iqr.from_us, iqr.to_us) == (True, ended.from_us, ended.to_us)
    assert (limits.learns, iqr.learns) == (False, True)


async def test_what_a_guest_may_not_see_is_not_told(hub, served) -> None:
    guest, page = await hub.page("guest"), await hub.page("operator")
    assert (await scores_of(guest, "power/voltage~together")).refused == ["power/voltage~together"]
    rows = [("power/voltage", NOW + at * SECOND, 12.0 + 0.01 * (at % 7)) for at in range(1_000)]
    await served.samples(*rows)
    # It has learned, which pages are told once.
    told = await page.hear(AnomalyUpdate, lambda news: news.address == "power/voltage")
    assert (told.learning, told.on) == (0, False)
    assert not [each for each in guest.heard if isinstance(each, AnomalyUpdate)]


async def test_scores_of_before_can_be_asked_for_before_there_are_any(hub, watched) -> None:
    client = await hub.client("guest")
    query = {"channel": "base/speed~limits", "from_us": NOW, "to_us": NOW + SECOND}
    answer = await client.get("/api/sites/agv/history", params=query)
    assert answer.json()["series"][0]["v"] == []
    assert (
        await client.get(
            "/api/sites/agv/history", params={**query, "channel": "base/speed~missing"}
        )
    ).status_code == 404
