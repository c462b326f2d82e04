"""``talaia hub`` as a process on each database: people, gateways, history, and all of it again."""

# ruff: noqa: D107

import asyncio
import os
import re
import signal
import sys

import httpx
import pytest
import websockets

from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB, Ack

from .conftest import Gateway

ADA = {"name": "ada", "password": "three unrelated words"}
ROW_US = 1_700_000_000_000_000


class Process:
    """A hub of its own, told of its database by the environment alone."""

    def __init__(self, folder, url) -> None:
        self._folder = folder
        self._url = url

    async def __aenter__(self):
        self._process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "talaia", "hub", "--plain", "--port", "0"),
            *("--data", str(self._folder)),
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": "src", "TALAIA_DATABASE_URL": self._url},
        )
        ready = await asyncio.wait_for(self._process.stdout.readline(), 60)
        self.port = int(ready.decode().rsplit(":", 1)[1])
        self.origin = f"http://127.0.0.1:{self.port}"
        return self

    async def setup_token(self) -> str:
        while True:
            line = (await asyncio.wait_for(self._process.stdout.readline(), 20)).decode()
            found = re.search(r"/setup#(\S+)", line)
            if found:
                return found[1]

    async def __aexit__(self, *_exc) -> None:
        if self._process.returncode is None:
            self._process.send_signal(signal.SIGTERM)
        await asyncio.wait_for(self._process.communicate(), 20)
        assert self._process.returncode == 0

    def client(self) -> httpx.AsyncClient:
        return httpx.AsyncClient(base_url=self.origin, headers={"Origin": self.origin}, timeout=60)


@pytest.mark.timeout(180)
async def test_hub_serves_sign_in_and_history_from_one_url(tmp_path, database_url) -> None:
    async with Process(tmp_path, database_url) as hub:
        token = await hub.setup_token()
        async with hub.client() as client:
            answer = await client.post("/api/setup", json={**ADA, "token": token})
            assert answer.status_code == 200, answer.text
            code = (await client.post("/api/gateways/codes", json={"site": "agv"})).json()["code"]
            enrolled = await client.post("/api/enrol", json={"code": code, "name": "bench"})
            key = enrolled.json()["key"]
            async with websockets.connect(
                f"ws://127.0.0.1:{hub.port}/gateway/link",
                additional_headers={"Authorization": f"Bearer {key}"},
                proxy=None,
            ) as connection:
                gateway = Gateway(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB)
                await gateway.hello()
                rows = [("power/voltage", ROW_US + at * 1000, 11.0 + at / 8) for at in range(50)]
                await gateway.samples(*rows)
                await gateway.hear(Ack, lambda ack: ack.below >= 50)
                await gateway.close()
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
