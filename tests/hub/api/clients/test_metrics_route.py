"""``/metrics``: who may scrape, what of it they get, and what a real Prometheus makes of it."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shutil
import subprocess
from typing import TYPE_CHECKING

import httpx
import pytest
from patience import PATIENCE_S
from ports import free_port
from prometheus_client.openmetrics.parser import text_string_to_metric_families

from talaia.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

pytestmark = pytest.mark.asyncio(loop_scope="module")

OPENMETRICS = {"Accept": "application/openmetrics-text; version=1.0.0"}
EVERYWHERE = {"right": "metrics", "site": "*", "device": "*"}
VIEW_BASE = {"right": "view", "site": "agv", "device": "base"}


@pytest.fixture(scope="module")
def prometheus() -> str:
    program = shutil.which("prometheus")
    if program is None:
        pytest.skip("Prometheus is missing (apt install prometheus)")
    return program


async def open_protocol(hub, *, is_open: bool = True) -> None:
    admin = await hub.client("admin")
    asked = {"open": is_open, "origins": []}
    answer = await admin.put("/api/client-protocols/metrics", json=asked)
    assert answer.status_code == 204, answer.text


async def token(hub, *permissions: dict[str, str], name: str = "admin") -> dict[str, str]:
    """Give the header of a new token with these permissions."""
    client = await hub.client(name)
    asked = {
        "name": "scrape",
        "ends_us": SystemClock().wall_ns() // 1000 + 3_600_000_000,
        "permissions": list(permissions),
    }
    answer = await client.post("/api/me/tokens", json=asked)
    assert answer.status_code == 200, answer.text
    return {"Authorization": f"Bearer {answer.json()['token']}"}


async def scrape(hub, headers: dict[str, str], query: str = "") -> dict[str, dict]:
    """Scrape, and give the values of each sample by its labels."""
    # No page: it names no origin.
    async with httpx.AsyncClient(base_url=hub.origin) as client:
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
    async with httpx.AsyncClient(base_url=shared_hub.origin) as client:
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


async def test_a_real_prometheus_scrapes_it(
    shared_hub, shared_gateway, prometheus: str, tmp_path: Path
) -> None:
    await open_protocol(shared_hub)
    now_us = SystemClock().wall_ns() // 1000
    await shared_gateway.samples(("base/speed", now_us, 1.25))
    headers = await token(shared_hub, EVERYWHERE, {"right": "view", "site": "*", "device": "*"})
    async with serving(prometheus, tmp_path, shared_hub.port, headers) as client:
        query = 'talaia_signal_value{device="base",signal="speed"}'
        async with asyncio.timeout(PATIENCE_S):
            while True:
                with contextlib.suppress(httpx.TransportError):
                    answer = await client.get("/api/v1/query", params={"query": query})
                    if answer.is_success and (rows := answer.json()["data"]["result"]):
                        break
                # A value that is older than its limit is not scraped; the robot speaks again.
                now_us = SystemClock().wall_ns() // 1000
                await shared_gateway.samples(("base/speed", now_us, 1.25))
                await asyncio.sleep(0.1)
        assert rows[0]["value"][1] == "1.25"
        assert rows[0]["metric"]["unit"] == "m/s"
        targets = (await client.get("/api/v1/targets")).json()["data"]["activeTargets"]
        assert [(target["health"], target["lastError"]) for target in targets] == [("up", "")]


@contextlib.asynccontextmanager
async def serving(
    program: str, folder: Path, port: int, headers: dict[str, str]
) -> AsyncIterator[httpx.AsyncClient]:
    """Run Prometheus until the block ends; it scrapes the hub each second."""
    own = free_port()
    config = {
        "global": {"scrape_interval": "1s", "scrape_timeout": "1s"},
        "scrape_configs": [
            {
                "job_name": "talaia",
                "authorization": {"credentials": headers["Authorization"].split()[1]},
                "static_configs": [{"targets": [f"127.0.0.1:{port}"]}],
            }
        ],
    }
    # JSON is YAML, too.
    (folder / "prometheus.yml").write_text(json.dumps(config))
    process = await asyncio.create_subprocess_exec(
        program,
        f"--config.file={folder / 'prometheus.yml'}",
        f"--storage.tsdb.path={folder / 'data'}",
        f"--web.listen-address=127.0.0.1:{own}",
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "GOMAXPROCS": "1"},
    )
    try:
        async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{own}") as client:
            yield client
    finally:
        process.terminate()
        await process.wait()
