"""A signal over signals, end to end: real gateway and hub, history, an alarm, and no robot."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial
from pathlib import Path
from typing import Any

import httpx
import pytest
from patience import PATIENCE_S
from shared_trust import usual_trust

from .stack import PASSWORD, SITE, Process, Stack

DESCRIPTION = f"""\
talaia: 1
site: {SITE}
name: Weather
connections: {{shell: {{kind: process, poll: 0.1}}}}
devices:
  weather:
    name: Weather
    visibility: public
    signals:
      outside: {{name: Outside, unit: °C, visibility: public, source: {{run: cat OUTSIDE}}}}
      dew: {{name: Dew point, unit: °C, visibility: public, source: {{run: cat DEW}}}}
      spread:
        name: Above the dew point
        unit: °C
        visibility: public
        source: {{expression: "{{weather/outside}} - {{weather/dew}}"}}
alarms:
  damp: {{name: Damp, kind: limit, signal: weather/spread, below: 2}}
"""


class Weather(Stack):
    """A hub and a gateway whose signals are files."""

    def start_robot(self) -> Process:
        return Process(["-c", "print('ready'); input()"], self.folder / "robot.log", {})


@pytest.fixture
async def stack(tmp_path: Path) -> AsyncIterator[Stack]:
    text = DESCRIPTION
    for word, said in (("OUTSIDE", "12.5"), ("DEW", "10")):
        (tmp_path / word).write_text(said)
        text = text.replace(f"cat {word}", f"cat {tmp_path / word}")
    running = Weather(tmp_path, text, {"boss": "admin"})
    try:
        await running.ready()
        yield running
    finally:
        running.close()


async def test_history_and_an_alarm_have_what_the_gateway_works_out(
    stack: Stack, tmp_path: Path
) -> None:
    address = stack.address
    async with httpx.AsyncClient(
        base_url=address, headers={"Origin": address}, timeout=PATIENCE_S, verify=usual_trust()
    ) as client:
        signed = await client.post("/api/login", json={"name": "boss", "password": PASSWORD})
        signed.raise_for_status()

        async def read(what: str, **query: Any) -> Any:
            answer = await client.get(f"/api/sites/{SITE}/{what}", params=query)
            answer.raise_for_status()
            return answer.json()

        async def seen(value: float) -> bool:
            now_us = time.time_ns() // 1000
            window = {"from_us": now_us - 600_000_000, "to_us": now_us, "width": 800}
            found = await read("history", channel="weather/spread", **window)
            return any(value in series["v"] for series in found["series"])

        async def was_raised() -> bool:
            past = (await read("alarms/damp/history"))["past"]
            return any(one["what"] == "raised" for one in past)

        async def until_so(holds: Callable[[], Awaitable[bool]]) -> None:
            async with asyncio.timeout(PATIENCE_S):
                while True:
                    if await holds():
                        return
                    await asyncio.sleep(0.05)

        await until_so(partial(seen, 2.5))
        assert not await was_raised()
        (tmp_path / "DEW").write_text("11.25")
        await until_so(partial(seen, 1.25))
        await until_so(was_raised)
