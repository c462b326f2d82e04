"""``talaia hub`` as a process on each database: people, gateways, history, and all of it again."""

# ruff: noqa: D107

import asyncio
import re
import signal
from contextlib import asynccontextmanager, suppress

import httpx
import pytest
import websockets
from async_program import start_program
from patience import PATIENCE_S
from shared_trust import usual_trust

from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB, Ack

from .conftest import Gateway

ADA = {"name": "ada", "password": "three unrelated words"}
ROW_US = 1_700_000_000_000_000


class Process:
    """A hub of its own, told of its database by the environment alone."""

    def __init__(self, folder, url) -> None:
        self._folder = folder
        self._url = url
        self._killed = False

    async def __aenter__(self):
        words = ["-m", "talaia", "hub", "--plain", "--port", "0", "--data", str(self._folder)]
        self._process = await start_program(*words, TALAIA_DATABASE_URL=self._url)
        ready = await asyncio.wait_for(self._process.stdout.readline(), PATIENCE_S)
        self.port = int(ready.decode().rsplit(":", 1)[1])
        self.origin = f"http://127.0.0.1:{self.port}"
        return self

    async def setup_token(self) -> str:
        while True:
            line = (await asyncio.wait_for(self._process.stdout.readline(), PATIENCE_S)).decode()
            found = re.search(r"/setup#(\S+)", line)
            if found:
                return found[1]

    async def __aexit__(self, *_exc) -> None:
        # A signal to a process that has died just now would take its exit code from asyncio.
        if self._process.returncode is None and not self._killed:
            self._process.send_signal(signal.SIGTERM)
        await asyncio.wait_for(self._process.communicate(), PATIENCE_S)
        assert self._process.returncode == (-signal.SIGKILL if self._killed else 0)

    def kill(self) -> None:
        """Kill -9."""
        self._killed = True
        self._process.send_signal(signal.SIGKILL)

    @asynccontextmanager
    async def gateway(self, key: str):
        """Connect with a gateway's key; the link may be lost at any time."""
        async with websockets.connect(
            f"ws://127.0.0.1:{self.port}/gateway/link",
            additional_headers={"Authorization": f"Bearer {key}"},
            proxy=None,
        ) as connection:
            gateway = Gateway(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB)
            yield gateway
            await gateway.close()

    async def enrolled(self) -> str:
        """Make the first person and a gateway; give its key."""
        token = await self.setup_token()
        async with self.client() as client:
            answer = await client.post("/api/setup", json={**ADA, "token": token})
            assert answer.status_code == 200, answer.text
            code = (await client.post("/api/gateways/codes", json={"site": "agv"})).json()["code"]
            enrolled = await client.post("/api/enrol", json={"code": code, "name": "bench"})
            return str(enrolled.json()["key"])

    def client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(
            base_url=self.origin,
            headers={"Origin": self.origin},
            timeout=PATIENCE_S,
            verify=usual_trust(),
        )


@pytest.mark.timeout(180)
async def test_hub_serves_sign_in_and_history_from_one_url(tmp_path, database_url) -> None:
    async with (
        Process(tmp_path, database_url) as hub,
        hub.gateway(await hub.enrolled()) as gateway,
    ):
        await gateway.hello()
        rows = [("power/voltage", ROW_US + at * 1000, 11.0 + at / 8) for at in range(50)]
        await gateway.samples(*rows)
        await gateway.hear(Ack, lambda ack: ack.below >= 50)
    async with Process(tmp_path, database_url) as hub, hub.client() as client:
        assert (await client.post("/api/login", json=ADA)).json()["admin"] is True
        asked = {
            "channel": "power/voltage",
            "from_us": ROW_US,
            "to_us": ROW_US + 1_000_000,
            "width": 1000,
        }
        (series,) = (await client.get("/api/sites/agv/history", params=asked)).json()["series"]
        assert series["v"] == [11.0 + at / 8 for at in range(50)]
        kinds = {row["kind"] for row in (await client.get("/api/audit")).json()["rows"]}
        assert {"setup", "gateway enrolled", "login"} <= kinds
        assert (await client.get("/api/audit/verify")).json()["ok"]
        assert (await client.get("/api/people")).json()["people"][0]["sessions"] == 2


@pytest.mark.timeout(180)
async def test_a_hub_killed_under_load_has_all_that_it_acknowledged_and_no_sample_twice(
    tmp_path, database_url
) -> None:
    rows = [("power/voltage", ROW_US + at * 1000, at / 8) for at in range(15_000)]

    async def load(gateway, first) -> None:
        for at in range(first, len(rows), 250):
            with suppress(websockets.ConnectionClosed):
                await gateway.samples(*rows[at : at + 250], first=at)

    async with Process(tmp_path, database_url) as hub:
        key = await hub.enrolled()
        async with hub.gateway(key) as gateway:
            await gateway.hello()
            loading = asyncio.create_task(load(gateway, 0))
            await gateway.hear(Ack, lambda ack: ack.below >= 3_000)
            hub.kill()
            await asyncio.gather(loading, gateway.closed())
            acknowledged = max([3_000, *(x.below for x in gateway.heard if isinstance(x, Ack))])
    async with Process(tmp_path, database_url) as hub:
        async with hub.gateway(key) as gateway:
            stored = (await gateway.hello()).acked
            assert stored >= acknowledged
            # What was under way is sent again, together with some that is there already.
            await load(gateway, stored - 500)
            await gateway.hear(Ack, lambda ack: ack.below >= len(rows))
        async with hub.client() as client:
            await client.post("/api/login", json=ADA)
            asked = {
                "channel": "power/voltage", "from_us": ROW_US, "to_us": rows[-1][1],
                "width": 10_000,
            }  # fmt: skip
            (series,) = (await client.get("/api/sites/agv/history", params=asked)).json()["series"]
    assert series["t_us"] == [row[1] for row in rows]
    assert series["v"] == [row[2] for row in rows]
