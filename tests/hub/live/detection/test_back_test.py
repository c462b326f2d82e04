"""What a detector would have said of stored history: found, cancelled, refused."""

from __future__ import annotations

import asyncio
import random

import pytest
from patience import PATIENCE_S

from ...conftest import DESCRIPTION

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
GROUP = """
anomaly_groups:
  body:
    signals: [base/speed, base/turn_rate, power/voltage]
    learn: 100
"""
PATH = "/api/sites/agv/anomalies/tests"


@pytest.fixture
async def stored(hub):
    """A robot that ran for ten minutes; its battery sagged in the eighth."""
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + GROUP)
    chance, rows = random.Random(1), []  # noqa: S311 - noise
    for at in range(600):
        load = chance.gauss(0.0, 1.0)
        sag = 2.5 if 420 <= at < 480 else 0.0
        rows += [
            ("base/speed", NOW + at * SECOND, 0.5 + 0.05 * load),
            ("base/turn_rate", NOW + at * SECOND, chance.gauss(0.0, 0.01)),
            ("power/voltage", NOW + at * SECOND, 12.0 - 0.1 * load - sag),
        ]
    await gateway.samples(*rows)
    yield hub
    await gateway.close()


def asked(**change) -> dict[str, object]:
    window = {"from_us": NOW + 200 * SECOND, "to_us": NOW + 600 * SECOND}
    return {"address": "/body", "detector": "group"} | window | change


async def result_of(client, **change):
    begun = await client.post(PATH, json=asked(**change))
    assert begun.status_code == 201, begun.text
    async with asyncio.timeout(PATIENCE_S):
        while True:
            said = (await client.get(f"{PATH}/{begun.json()['key']}")).json()
            if said["state"] != "running":
                return said
            await asyncio.sleep(0.02)


async def test_a_group_tried_on_the_past_finds_what_was_wrong_and_who_made_it_so(stored) -> None:
    client = await stored.client("operator")
    said = await result_of(client)
    assert (said["state"], said["progress"], said["rows"]) == ("done", 1.0, 400)
    # It had learned from what lay before the window.
    assert said["learning"] == 0
    assert said["count"] == 1
    (found,) = said["anomalies"]
    assert 420 <= (found["from_us"] - NOW) / SECOND < 440
    assert found["shares"][0]["signal"] == "power/voltage"
    assert said["cpu_s"] > 0
    assert len(said["scores"]) == 300
    assert max(said["scores"][:150]) < 0.5 < max(said["scores"][165:])


async def test_another_bar_says_less_and_too_little_history_is_told(stored) -> None:
    client = await stored.client("operator")
    strict = await result_of(client, bar=1.0)
    assert (strict["bar"], strict["count"]) == (1.0, 0)
    short = await result_of(client, learn=1000)
    assert short["learning"] > 0
    assert short["count"] == 0


async def test_a_detector_of_one_signal_is_tried_without_being_described(stored) -> None:
    client = await stored.client("operator")
    said = await result_of(
        client, address="power/voltage", detector="limits", minimum=10.5, maximum=14
    )
    assert said["count"] == 1
    assert said["anomalies"][0]["why"].endswith("is below the least of 10.5 V")
    assert (said["anomalies"][0]["from_us"] - NOW) // SECOND == 420


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"address": "/nothing"}, "there is no signal"),
        ({"address": "power/none", "detector": "iqr"}, "there is no signal"),
        ({"address": "base/wandering", "detector": "iqr"}, "is no number"),
        ({"address": "power/voltage", "detector": "missing"}, "expected one of together"),
        ({"address": "power/voltage", "detector": "limits"}, "limits without a limit"),
        ({"detector": "iqr"}, "expected 'group' for a group"),
        ({"learn": 5}, "expected 60 to 30000 steps"),
        ({"from_us": NOW - 40 * 86_400 * SECOND}, "at most 31 days"),
        ({"to_us": NOW}, "expected from_us before to_us"),
    ],
)
async def test_what_cannot_be_tried_is_said(stored, change, says) -> None:
    client = await stored.client("operator")
    answer = await client.post(PATH, json=asked(**change))
    assert answer.status_code in (404, 422)
    assert says in answer.text


async def test_a_test_is_cancelled_and_only_so_many_compute_at_once(stored) -> None:
    client = await stored.client("operator")
    tests = stored.hub.anomalies._tests
    gate = asyncio.Event()
    read = stored.history.read_series

    async def wait(*args, **more):
        await gate.wait()
        return await read(*args, **more)

    stored.history.read_series = wait
    try:
        first = (await client.post(PATH, json=asked())).json()
        assert (await client.post(PATH, json=asked())).status_code == 201
        assert (await client.post(PATH, json=asked())).status_code == 429
        assert (await client.delete(f"{PATH}/{first['key']}")).status_code == 204
        async with asyncio.timeout(PATIENCE_S):
            while len(tests._tasks) > 1:  # noqa: ASYNC110 - the hub tells no test
                await asyncio.sleep(0.02)
        said = (await client.get(f"{PATH}/{first['key']}")).json()
        assert (said["state"], said["count"]) == ("cancelled", 0)
    finally:
        gate.set()


async def test_who_may_not_use_the_site_tries_nothing_there(stored) -> None:
    guest = await stored.client("guest")
    assert (await guest.post(PATH, json=asked())).status_code == 403
