"""A hub that is killed while an alarm is on its way: nobody misses it, nobody hears of it twice."""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
import contextlib
import signal
import time
from pathlib import Path

import httpx
import pytest
import websockets
from aiosmtpd.smtp import SMTP
from async_program import start_program
from patience import PATIENCE_S
from ports import free_port
from shared_trust import usual_trust

from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, AlarmUpdate
from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB

from ...conftest import (
    DESCRIPTION,
    PASSWORD,
    Gateway,
    Peer,
    RunningHub,
)

pytestmark = pytest.mark.timeout(120)
SOURCE = Path(__file__).parents[4] / "src"
LOW = """
alarms:
  low: {name: Battery low, kind: limit, signal: power/voltage, below: 11, max_age: 3600}
"""


class Mailbox:
    """A mail server that can keep whoever sends waiting for its answer."""

    def __init__(self) -> None:
        self.mails = []
        self.news = asyncio.Event()
        self.may_answer = asyncio.Event()
        self.may_answer.set()

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        self.mails.append(envelope.content.decode())
        self.news.set()
        await self.may_answer.wait()
        return "250 OK"


class HubProcess:
    """The hub as a program of its own, on one data folder; it can be killed."""

    def __init__(self, data: Path, keys: dict[str, str]) -> None:
        self.data, self.keys = data, keys
        self.port = free_port()
        self.origin = f"http://127.0.0.1:{self.port}"

    async def start(self) -> None:
        command = ["-m", "talaia", "hub", "--plain", "--port", str(self.port)]
        command += ["--data", str(self.data), "--notify-network", "127.0.0.0/8"]
        self.process = await start_program(*command)
        async with asyncio.timeout(PATIENCE_S), httpx.AsyncClient(verify=usual_trust()) as client:
            while True:
                with contextlib.suppress(httpx.TransportError):
                    if (await client.get(f"{self.origin}/api/health")).is_success:
                        return
                assert self.process.returncode is None
                await asyncio.sleep(0.05)

    async def end(self, how: signal.Signals) -> None:
        if self.process.returncode is None:
            self.process.send_signal(how)
        await self.process.wait()

    async def dial(self, path: str, headers: dict[str, str]):
        url = f"ws://127.0.0.1:{self.port}{path}"
        return await websockets.connect(
            url, additional_headers=headers, compression=None, proxy=None
        )

    async def gateway(self, boot: str) -> Gateway:
        headers = {"Authorization": f"Bearer {self.keys['agv']}"}
        gateway = Gateway(
            await self.dial("/gateway/link", headers), LINK_FROM_GATEWAY, LINK_FROM_HUB
        )
        await gateway.hello(DESCRIPTION + LOW, boot=boot)
        return gateway

    async def page(self) -> Peer:
        async with httpx.AsyncClient(
            base_url=self.origin, headers={"Origin": self.origin}, verify=usual_trust()
        ) as http:
            said = {"name": "operator", "password": PASSWORD}
            cookie = (await http.post("/api/login", json=said)).cookies["talaia"]
        headers = {"Cookie": f"talaia={cookie}", "Origin": self.origin}
        return Peer(await self.dial("/ws", headers), FROM_BROWSER, TO_BROWSER)


@pytest.fixture
async def mailbox():
    mailbox = Mailbox()
    loop = asyncio.get_running_loop()
    server = await loop.create_server(lambda: SMTP(mailbox), "127.0.0.1", 0)
    mailbox.port = server.sockets[0].getsockname()[1]
    yield mailbox
    mailbox.may_answer.set()
    server.close()


@pytest.fixture
async def hub(settings, history, mailbox):
    """A hub whose operator is told by mail, a second after an alarm was raised."""
    async with RunningHub(settings, history) as first:
        await first.populate()
        admin, operator = await first.client("admin"), await first.client("operator")
        way = {
            "name": "Mail", "kind": "mail", "host": "127.0.0.1", "port": mailbox.port,
            "security": "none", "sender": "talaia@example.org",
        }  # fmt: skip
        made = (await admin.post("/api/ways", json=way)).json()["id"]
        rule = {"site": "agv", "way": made, "target": "op@example.org", "group_s": 1}
        assert (await operator.post("/api/me/rules", json=rule)).status_code == 201
        keys = first.keys
    hub = HubProcess(settings.data, keys)
    await hub.start()
    yield hub
    await hub.end(signal.SIGTERM)


async def test_alarm_whose_message_waits_survives_the_kill_and_is_told_once(hub, mailbox):
    gateway, page = await hub.gateway("one"), await hub.page()
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))
    await page.hear(AlarmUpdate, lambda news: news.phase == "active")
    await hub.end(signal.SIGKILL)
    assert mailbox.mails == []
    await hub.start()
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    page = await hub.page()
    told = await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    assert (told.phase, told.undelivered) == ("active", "")
    # Still low: the same alarm, and no other message.
    again = await hub.gateway("two")
    await again.samples(("power/voltage", time.time_ns() // 1000, 9.0))
    await again.samples(("power/voltage", time.time_ns() // 1000, 12.0))
    await page.hear(AlarmUpdate, lambda news: news.phase == "cleared")
    mailbox.news.clear()
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    assert ["over:" in mail for mail in mailbox.mails] == [False, True]


async def test_message_under_way_at_the_kill_is_not_repeated_and_the_page_says_so(hub, mailbox):
    gateway = await hub.gateway("one")
    mailbox.may_answer.clear()
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))
    async with asyncio.timeout(PATIENCE_S):
        await mailbox.news.wait()
    await hub.end(signal.SIGKILL)
    mailbox.may_answer.set()
    await hub.start()
    page = await hub.page()
    told = await page.hear(AlarmUpdate, lambda news: news.alarm == "low")
    assert told.phase == "active"
    assert "it may have been delivered" in told.undelivered
    assert len(mailbox.mails) == 1
