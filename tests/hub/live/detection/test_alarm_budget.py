"""False alarms that are borne: asked for, kept, filled from history, confirmed ones left out."""

from __future__ import annotations

import asyncio
import random

import pytest
from patience import PATIENCE_S

from talaia.clock import SystemClock
from talaia.hub.anomaly.budget.score_tail import BLOCK_US, ScoreTail
from talaia.hub.live.detection.alarm_budget import AlarmBudgets

from ...conftest import DESCRIPTION

NOW = 1_795_000_000_000_000
SECOND = 1_000_000
GROUP = """
anomaly_groups:
  body:
    signals: [base/speed, base/turn_rate, power/voltage]
    learn: 100
"""
BUDGET = "services: {false_alarms_a_week: 2}\n"
PATH = "/api/sites/agv/anomalies/budget"


def calm_rows(count: int) -> list[tuple[str, int, float]]:
    chance, rows = random.Random(1), []  # noqa: S311 - noise
    for at in range(count):
        rows += [
            ("base/speed", NOW + at * SECOND, 0.5 + chance.gauss(0.0, 0.05)),
            ("base/turn_rate", NOW + at * SECOND, chance.gauss(0.0, 0.01)),
            ("power/voltage", NOW + at * SECOND, 12.0 + chance.gauss(0.0, 0.1)),
        ]
    return rows


@pytest.fixture
async def grouped(hub):
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + GROUP + BUDGET)
    yield gateway
    await gateway.close()


def group_of(hub):
    return hub.hub.anomalies.detectors.detectors_of("agv")[-1]


def seen_tail(days: int) -> ScoreTail:
    """Make a tail of so many days with a peak every two hours."""
    tail = ScoreTail(filled=True)
    for block in range(days * 144):
        tail.see_time(NOW + block * BLOCK_US)
        if block % 12 == 0:
            tail.record_magnitudes(NOW + block * BLOCK_US, [1.0 + block % 97 / 97])
    return tail


async def until(is_so) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not is_so():  # noqa: ASYNC110 - the hub tells no test
            await asyncio.sleep(0.02)


async def test_what_the_description_says_holds_until_a_person_says_otherwise(hub, grouped) -> None:
    client = await hub.client("operator")
    said = (await client.get(PATH)).json()
    assert (said["a_week"], said["by_person"], said["basis"]) == (2.0, False, "learning")
    said = (await client.put(PATH, json={"a_week": 0.5})).json()
    assert (said["a_week"], said["described"], said["by_person"]) == (0.5, 2.0, True)
    said = (await client.put(PATH, json={"a_week": None})).json()
    assert (said["a_week"], said["by_person"]) == (2.0, False)
    assert (await client.put(PATH, json={"a_week": 0.001})).status_code == 422


async def test_a_guest_changes_nothing(hub, grouped) -> None:
    client = await hub.client("guest")
    assert (await client.put(PATH, json={"a_week": 5})).status_code in {401, 403, 404}


async def test_thresholds_follow_from_what_was_seen_and_are_gone_without_a_budget(
    hub, grouped
) -> None:
    client = await hub.client("operator")
    runner = group_of(hub)
    runner.tail = seen_tail(8)
    said = (await client.put(PATH, json={"a_week": 1})).json()
    assert said["basis"] == "short"
    assert said["seen_s"] == 8 * 86_400
    assert said["needed_s"] == 21 * 86_400
    assert runner.needs[0] > 1.9
    own = runner.group.group.bar
    assert runner.episodes.bar < own
    await client.put(PATH, json={"a_week": 0})
    assert (runner.needs, runner.tail, runner.episodes.bar) == ((), None, own)


async def test_new_detectors_look_at_the_stored_history(hub, grouped) -> None:
    await grouped.samples(*calm_rows(1500))
    client = await hub.client("operator")
    await client.put(PATH, json={"a_week": 1})
    await until(lambda: group_of(hub).tail is not None and group_of(hub).tail.filled)
    # 1500 s from the middle of a block on.
    assert group_of(hub).tail.blocks in {2, 3, 4}
    # What each signal does against the others is learned from it, too.
    assert group_of(hub).residuals.heard >= 1490
    assert (await client.get(PATH)).json()["reading"] == 0


async def test_what_was_seen_and_said_survives_the_hub(hub, grouped) -> None:
    client = await hub.client("operator")
    runner = group_of(hub)
    runner.tail = seen_tail(3)
    await client.put(PATH, json={"a_week": 3})
    feature = hub.hub.anomalies
    await feature.budgets.close()
    live = hub.hub.core.sites.find_site("agv")
    kept = await feature.budgets._learned.states_of("agv")
    runner.restore_tail(kept["/body", "group~tail"])
    assert runner.tail.blocks == 3 * 144
    after = AlarmBudgets(
        feature.detectors,
        sites=hub.hub.core.sites,
        history=hub.history,
        learned=feature.budgets._learned,
        clock=SystemClock(),
    )
    await after._look_after(live)
    assert after.standing_of(live).a_week == 3.0


async def test_an_anomaly_that_was_real_is_no_false_alarm(hub, grouped) -> None:
    client = await hub.client("operator")
    runner = group_of(hub)
    confirm = {"address": "/body", "detector": "group", "comment": "a wheel was blocked"}
    at = "/api/sites/agv/anomalies/confirmed"
    assert (await client.post(at, json=confirm)).status_code == 404
    await client.put(PATH, json={"a_week": 1})
    runner.tail = seen_tail(8)
    fault_us = NOW + 8 * 144 * BLOCK_US
    runner.tail.record_magnitudes(fault_us, [50.0])
    runner.from_us, runner.to_us = fault_us, fault_us + 5 * SECOND
    assert (await client.post(at, json=confirm)).status_code == 204
    assert max(peak.greatest for peak in runner.tail.peaks[0]) < 2.0
    listed = (await client.get("/api/sites/agv/anomalies")).json()["detectors"]
    assert listed[-1]["confirmed"]
