"""A message type that no package here knows, from a robot to a chart, by real processes."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import aclosing
from importlib.util import find_spec
from pathlib import Path

import httpx
import pytest
from patience import PATIENCE_S

from talaia.client import AsyncClient

from .conftest import need_ros2
from .stack import PASSWORD, SITE, Process, Stack

pytestmark = pytest.mark.robot

DESCRIPTION = f"""\
talaia: 1
site: {SITE}
name: Kitchen
ros2: {{}}
devices:
  oven:
    name: Oven
    signals:
      shelf:
        name: Upper shelf
        unit: °C
        source:
          {{topic: /oven/bake, type: oven_own_msgs/msg/Bake, field: "shelves[1].celsius"}}
"""
SHELF = "oven/shelf"


class Kitchen(Stack):
    """A hub and a gateway, and an oven in place of the robot."""

    def start_robot(self) -> Process:
        script = Path(__file__).with_name("own_type_robot.py")
        return Process([str(script)], self.folder / "robot.log", self._ros)


@pytest.fixture
async def stack(tmp_path: Path) -> AsyncIterator[Stack]:
    need_ros2()
    running = Kitchen(tmp_path, DESCRIPTION, {"boss": "admin"})
    try:
        await running.ready()
        yield running
    finally:
        running.close()


async def token_of(client: httpx.AsyncClient) -> str:
    """Sign in, and make a token for a script."""
    who = {"name": "boss", "password": PASSWORD}
    (await client.post("/api/login", json=who)).raise_for_status()
    asked = {
        "name": "a script",
        "ends_us": int((time.time() + 3600) * 1e6),
        "permissions": [{"right": "view", "site": SITE, "device": "*"}],
    }
    made = await client.post("/api/me/tokens", json=asked)
    return str(made.raise_for_status().json()["token"])


async def test_own_type_of_a_robot_is_seen_live_and_charted(stack: Stack) -> None:
    assert find_spec("oven_own_msgs") is None
    address = stack.address
    async with (
        asyncio.timeout(PATIENCE_S),
        httpx.AsyncClient(
            base_url=address, headers={"Origin": address}, timeout=PATIENCE_S
        ) as browser,
    ):
        token = await token_of(browser)
        sent = [187.25, 201.5]
        stack.robot.tell(str(sent[0]))
        seen = []
        script = AsyncClient(address, token)
        watched = script.watch_values([f"{SITE}/{SHELF}"], every_s=0.0)
        async with aclosing(watched) as readings:
            async for reading in readings:
                assert reading.unit == "°C"
                if reading.stale or reading.value in seen:
                    continue
                seen.append(reading.value)
                if seen == sent:
                    break
                # The next comes when this one has come all the way.
                stack.robot.tell(str(sent[1]))
        charted: list[float] = []
        while charted != sent:
            now_us = time.time_ns() // 1000
            # As the page's chart asks for it.
            window = {"from_us": now_us - 600_000_000, "to_us": now_us, "width": 800}
            answer = await browser.get(
                f"/api/sites/{SITE}/history", params={"channel": SHELF, **window}
            )
            series = answer.raise_for_status().json()["series"]
            charted = [value for one in series for value in one["v"] if value is not None]
