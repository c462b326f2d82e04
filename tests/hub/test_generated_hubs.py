"""A generated deployment of three hubs, really started: a hub dies, and all are there again."""

# ruff: noqa: D107
import asyncio
import signal
import sys
import time
from contextlib import suppress

import pytest
import websockets
from async_program import start_program
from patience import until_answered

from talaia.wire.browser import RequestError, Subscribe, Values
from talaia.wire.columns import unpack_columns

from .databases import database_with_tables, empty_database
from .generated_hubs import GeneratedHubs
from .several_hubs import sites_stored_in

# Each poll gives the next number: one that is lost, or stored twice, is seen.
SITE = """
talaia: 1
site: agv
name: Shed
connections: {{shell: {{kind: process, poll: 0.2, timeout: 5}}}}
devices:
  base:
    name: Base
    connection: shell
    signals:
      count: {{name: Count, source: {{run: "sh {script}", pattern: '([0-9.]+)'}}}}
"""
COUNT = 'n=$(($(cat "{file}" 2>/dev/null || echo 0) + 1)); echo $n > "{file}"; echo $n\n'


@pytest.fixture
def url(tmp_path):
    with database_with_tables("postgresql", tmp_path) as made:
        yield made


@pytest.fixture
def history_url():
    with empty_database("postgresql") as made:
        yield made


class Viewer:
    """A page that is always there: it comes again whenever its socket is closed."""

    def __init__(self, hubs: GeneratedHubs) -> None:
        self._hubs = hubs
        self.newest = 0.0
        # How long it saw nothing new, the longest first (s).
        self.dark_s = []
        self._task = asyncio.create_task(self._watch())

    async def until_sees(self, number: float) -> None:
        async def has_seen() -> bool:
            assert not self._task.done(), self._task.result()
            return self.newest >= number

        await until_answered(has_seen)

    async def close(self) -> None:
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)
        self.dark_s.sort(reverse=True)

    async def _watch(self) -> None:
        last = time.monotonic()
        while True:
            # Refused while no hub is ready.
            with suppress(OSError, websockets.WebSocketException, AssertionError):
                page = await self._hubs.page()
                asked = Subscribe(sub=1, site="agv", channels=["base/count"], every_ms=0)
                await page.say(asked)
                # A site is known once its gateway has said what it is.
                while isinstance(values := await page.hear((Values, RequestError)), Values):
                    self.newest = max([self.newest, *unpack_columns(values).value.tolist()])
                    now = time.monotonic()
                    self.dark_s.append(now - last)
                    last = now
                await page.close()
            await asyncio.sleep(0.1)


async def hub_of_gateway(hubs: GeneratedHubs) -> str:
    """Wait until the gateway came in at one of the hubs that are there; give its name."""
    there = []

    async def has_come() -> bool:
        told = (await hubs.get("/api/hubs")).json()["hubs"]
        there[:] = [hub["name"] for hub in told if hub["gateways"] == 1 and hub["role"] != "gone"]
        return len(there) == 1

    await until_answered(has_come)
    return there[0]


async def leading_hub(hubs: GeneratedHubs) -> str:
    told = (await hubs.get("/api/hubs")).json()["hubs"]
    return next(hub["name"] for hub in told if hub["role"] == "leads")


async def stored_numbers(hubs: GeneratedHubs) -> list[float]:
    answer = await hubs.get(
        "/api/sites/agv/history", channel="base/count", from_us=0, to_us=2**53, width=10_000
    )
    return answer.json()["series"][0]["v"]


def report_dark(viewer: Viewer) -> None:
    shown = ", ".join(f"{seconds:.1f}" for seconds in viewer.dark_s[:3])
    sys.stderr.write(f"longest without a new value: {shown} s\n")


@pytest.mark.timeout(400)
async def test_whoever_comes_through_haproxy_is_back_after_a_hub_died_and_one_was_replaced(
    tmp_path, url, history_url, monkeypatch
) -> None:
    (tmp_path / "count.sh").write_text(COUNT.format(file=tmp_path / "count"))
    site = tmp_path / "agv.yaml"
    site.write_text(SITE.format(script=tmp_path / "count.sh"))
    async with GeneratedHubs(tmp_path, site, url, history_url) as hubs:
        await hubs.set_up()
        key = await hubs.enrol(monkeypatch)
        gateway = await start_program(
            *("-m", "talaia", "gateway", str(site), "--key-file", str(key)),
            *("--data", str(tmp_path / "gateway")),
        )
        viewers = []
        try:
            first = await hub_of_gateway(hubs)
            viewers.append(viewer := Viewer(hubs))
            await viewer.until_sees(3)
            await hubs.end_hub(first, signal.SIGKILL)
            killed_at = viewer.newest
            await viewer.until_sees(killed_at + 5)
            assert await hubs.end_hub(await leading_hub(hubs), signal.SIGTERM) == 0
            await viewer.until_sees(viewer.newest + 5)
        finally:
            await asyncio.gather(*(viewer.close() for viewer in viewers))
            gateway.terminate()
            await gateway.wait()
        numbers = await stored_numbers(hubs)
        assert numbers == [float(number + 1) for number in range(len(numbers))]
        assert len(numbers) >= killed_at + 5
        report_dark(viewer)
        # In the database that is histories' own.
        assert sites_stored_in(history_url) == ["agv"]
        assert sites_stored_in(url) == []
        assert (await hubs.get("/api/audit/verify")).json()["ok"]
