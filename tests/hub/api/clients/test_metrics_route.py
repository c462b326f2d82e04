"""``/metrics``: who may scrape, what of it they get, and what a real Prometheus makes of it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import httpx
import pytest
from patience import PATIENCE_S
from prometheus_client.openmetrics.parser import text_string_to_metric_families
from shared_trust import usual_trust

from talaia.clock import SystemClock

from .prometheus_server import (
    EVERYWHERE,
    OPENMETRICS,
    VIEW_BASE,
    open_protocol,
    query,
    serving,
    token,
)

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def scrape(hub, headers: dict[str, str], query: str = "") -> dict[str, dict]:
    """Scrape, and give the values of each sample by its labels."""
    # No page: it names no origin.
    async with httpx.AsyncClient(base_url=hub.origin, verify=usual_trust()) as client:
        answer = await client.get(f"/metrics{query}", headers={**OPENMETRICS, **headers})
    assert answer.status_code == 200, answer.text
    found: dict[str, dict] = {}
    for family in text_string_to_metric_families(answer.text):
        for sample in family.samples:
            key = tuple(sorted(sample.labels.items()))
            found.setdefault(sample.name, {})[key] = sample.value
    return found


def of_signal(found: dict[str, dict], device: str, signal: str) -> list[float]:
    wanted = {("device", device), ("signal", signal)}
    values = found.get("talaia_signal_value", {})
    return [value for labels, value in values.items() if wanted <= set(labels)]


async def heard(hub, headers: dict[str, str], device: str, signal: str, value: float) -> None:
    """Wait until the hub has a value."""
    async with asyncio.timeout(PATIENCE_S):
        for _ in iter(int, 1):
            if of_signal(await scrape(hub, headers), device, signal) == [value]:
                return
            await asyncio.sleep(0.05)


async def test_nobody_scrapes_while_it_is_shut_without_a_token_or_without_the_right(
    shared_hub,
) -> None:
    await open_protocol(shared_hub, is_open=False)
    allowed = await token(shared_hub, EVERYWHERE)
    cookie = {"Cookie": await shared_hub.cookie("admin")}
    only_view = await token(shared_hub, VIEW_BASE)
    async with httpx.AsyncClient(base_url=shared_hub.origin, verify=usual_trust()) as client:
        assert (await client.get("/metrics", headers=allowed)).json()["code"] == "shut"
        await open_protocol(shared_hub)
        assert (await client.get("/metrics")).status_code == 401
        # A page's cookie counts nothing here.
        assert (await client.get("/metrics", headers=cookie)).status_code == 401
        foreign = {**allowed, "Origin": shared_hub.origin}
        assert (await client.get("/metrics", headers=foreign)).json()["code"] == "origin"
        answer = await client.get("/metrics", headers=only_view)
        assert (answer.status_code, answer.json()["code"]) == (403, "forbidden")
        assert (await client.get("/metrics", headers=allowed)).status_code == 200


async def test_values_come_with_their_units_and_only_to_those_who_may_see_them(
    shared_hub, shared_gateway
) -> None:
    await open_protocol(shared_hub)
    now_us = SystemClock().wall_ns() // 1000
    await shared_gateway.samples(("base/speed", now_us, 0.75), ("power/voltage", now_us, 12.5))
    everything = {"right": "view", "site": "*", "device": "*"}
    headers = await token(shared_hub, EVERYWHERE, everything)
    await heard(shared_hub, headers, "power", "voltage", 12.5)
    found = await scrape(shared_hub, headers)
    (labels,) = (
        dict(labels) for labels in found["talaia_signal_value"] if ("signal", "speed") in labels
    )
    assert labels == {"site": "agv", "device": "base", "signal": "speed", "part": "", "unit": "m/s"}
    assert found["talaia_gateway_linked"][("site", "agv"),] == 1.0
    assert any(name.startswith("process_") for name in found)
    # Of one device, and of the hub nothing.
    of_agv = {"right": "metrics", "site": "agv", "device": "*"}
    narrow = await scrape(shared_hub, await token(shared_hub, of_agv, VIEW_BASE))
    assert of_signal(narrow, "base", "speed") == [0.75]
    assert not of_signal(narrow, "power", "voltage")
    assert "talaia_hub_info" not in narrow
    assert not any(name.startswith("process_") for name in narrow)
    # What is asked for by pattern, whether or not it is on the first page.
    chosen = await scrape(shared_hub, headers, "?site=agv&signal=power/*")
    assert of_signal(chosen, "power", "voltage") == [12.5]
    assert not of_signal(chosen, "base", "speed")
    assert not of_signal(await scrape(shared_hub, headers, "?site=moon"), "base", "speed")


async def test_a_stale_value_is_left_out_and_its_age_goes_on(shared_hub, shared_gateway) -> None:
    await open_protocol(shared_hub)
    now_us = SystemClock().wall_ns() // 1000
    await shared_gateway.samples(("base/speed", now_us, 0.5))
    headers = await token(shared_hub, EVERYWHERE, {"right": "view", "site": "*", "device": "*"})
    live = shared_hub.hub.core.sites.find_site("agv")
    at = next(n for n, channel in enumerate(live.channels) if channel.address == "base/speed")
    await heard(shared_hub, headers, "base", "speed", 0.5)
    # It came a minute ago, and nothing since then.
    live.latest.arrived_ns[at] -= 60_000_000_000
    found = await scrape(shared_hub, headers)
    assert not of_signal(found, "base", "speed")
    ages = found["talaia_signal_age_seconds"]
    assert any(("signal", "speed") in labels and age > 59 for labels, age in ages.items())


async def test_a_real_prometheus_scrapes_it(shared_hub, shared_gateway, tmp_path: Path) -> None:
    await open_protocol(shared_hub)
    now_us = SystemClock().wall_ns() // 1000
    await shared_gateway.samples(("base/speed", now_us, 1.25))
    headers = await token(shared_hub, EVERYWHERE, {"right": "view", "site": "*", "device": "*"})
    async with serving(tmp_path, shared_hub.port, headers) as client:
        speed = 'talaia_signal_value{device="base",signal="speed"}'
        async with asyncio.timeout(PATIENCE_S):
            while not (rows := await query(client, speed)):
                # A value that is older than its limit is not scraped; the robot speaks again.
                now_us = SystemClock().wall_ns() // 1000
                await shared_gateway.samples(("base/speed", now_us, 1.25))
                await asyncio.sleep(0.1)
        assert rows[0]["value"][1] == "1.25"
        assert rows[0]["metric"]["unit"] == "m/s"
        targets = (await client.get("/api/v1/targets")).json()["data"]["activeTargets"]
        assert [(target["health"], target["lastError"]) for target in targets] == [("up", "")]
