"""From an anomaly to its cause: ranked, compared with the last time, known while docked."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S

from talaia.wire.browser import EventUpdate

from ...conftest import DESCRIPTION

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
SPEED = "      speed:\n"
WATCHED = DESCRIPTION.replace(
    SPEED, SPEED + "        anomalies: [{detector: limits, maximum: 2, rest: 5}]\n", 1
)
PATH = "/api/sites/agv/causes"
LIMITS = {"address": "base/speed", "detector": "limits"}


@pytest.fixture
async def watched(hub):
    gateway = await hub.gateway()
    await gateway.hello(WATCHED)
    yield gateway
    await gateway.close()


def runner_of(hub):
    return hub.hub.anomalies.detectors.detectors_of("agv")[0]


async def until(is_so) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


async def test_what_was_unusual_within_the_minute_is_named_with_its_score(hub, watched) -> None:
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    await until(lambda: hub.history.has_channel("agv", "base/speed~limits"))
    client = await hub.client("operator")
    said = (await client.get(PATH, params={"at_us": NOW})).json()
    (found,) = said["unusual"]
    assert (found["address"], found["score"], found["at_us"]) == ("base/speed", 1.0, NOW + SECOND)
    assert found["title"].endswith("Speed")
    assert said["may_use"]
    later = (await client.get(PATH, params={"at_us": NOW + 3600 * SECOND})).json()
    assert later["unusual"] == []


async def test_a_guest_sees_nothing_of_signals_that_are_not_public(hub, watched) -> None:
    await watched.samples(("base/speed", NOW, 2.5))
    await until(lambda: hub.history.has_channel("agv", "base/speed~limits"))
    guest = await hub.client("guest")
    answer = await guest.get(PATH, params={"at_us": NOW})
    listed = await guest.get("/api/sites/agv/anomalies")
    assert len(answer.json()["unusual"]) == len(listed.json()["detectors"])
    assert (await guest.post(PATH + "/known", json=LIMITS)).status_code in {401, 403, 404}


async def test_of_a_known_anomaly_nobody_is_told_until_it_is_known_no_more(hub, watched) -> None:
    page = await hub.page("operator")
    client = await hub.client("operator")
    made = await client.post(PATH + "/known", json={**LIMITS, "comment": "downhill"})
    assert made.status_code == 201
    await watched.samples(("base/speed", NOW, 0.5), ("base/speed", NOW + SECOND, 2.5))
    await until(lambda: runner_of(hub).episodes.began_us > 0)
    assert runner_of(hub).known == made.json()["key"]
    (shown,) = (await client.get(PATH, params={"at_us": NOW})).json()["known"]
    assert (shown["comment"], shown["holds"], shown["who"]) == ("downhill", True, "operator")
    # It goes on when the word is taken back: then it is told.
    path = f"{PATH}/known/{made.json()['key']}"
    assert (await client.delete(path)).status_code == 204
    began = await page.hear(EventUpdate, lambda news: news.kind == "anomaly began")
    assert began.time_us == NOW + SECOND
    assert (await client.delete(path)).status_code == 404


async def test_it_survives_the_hub_and_holds_only_for_a_detector_that_is_there(
    hub, watched
) -> None:
    client = await hub.client("operator")
    await client.post(PATH + "/known", json=LIMITS)
    known = hub.hub.anomalies.detectors.known
    known._known.clear()
    assert [one.address for one in await known.read_site("agv")] == ["base/speed"]
    other = {"address": "base/nothing", "detector": "limits"}
    assert (await client.post(PATH + "/known", json=other)).status_code == 404
    state = {**LIMITS, "state": "base/speed", "value": 1}
    assert (await client.post(PATH + "/known", json=state)).status_code == 422


async def test_the_last_similar_episode_is_found_with_what_was_said_of_it(hub, watched) -> None:
    client = await hub.client("operator")
    audit = hub.hub.audit.log
    audit.append_record("anomaly began", site="agv", device="base", message="Speed: 2.5 m/s")
    said = await client.get(PATH, params={"at_us": NOW})
    assert said.json()["similar"] is None
