"""Several hubs as processes on one database, with a NATS of their own; and who speaks to them."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import os
import re
import signal
from contextlib import AsyncExitStack, asynccontextmanager

import httpx
import sqlalchemy as sa
import websockets
from async_program import start_program
from patience import PATIENCE_S, until_answered
from ports import free_port
from server_programs import server_or_skip
from shared_trust import usual_trust

from talaia.hub.auth.key_file import read_or_make_key
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_tables import channel
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER
from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB

from .conftest import Gateway, Peer

ADA = {"name": "ada", "password": "three unrelated words"}


class Nats:
    """NATS at a port of its own, where it may be killed and begun anew."""

    def __init__(self) -> None:
        self.port = free_port()
        self.url = f"nats://127.0.0.1:{self.port}"
        self._process = None

    async def __aenter__(self) -> Nats:
        await self.start()
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self.kill()

    async def start(self) -> None:
        quiet = asyncio.subprocess.DEVNULL
        words = [server_or_skip("nats-server"), "-a", "127.0.0.1", "-p", str(self.port)]
        self._process = await asyncio.create_subprocess_exec(*words, stdout=quiet, stderr=quiet)

    async def kill(self) -> None:
        """End it without farewell."""
        if self._process is not None:
            self._process.kill()
            await self._process.wait()
            self._process = None


class OneHub:
    """One of the hubs, as a process."""

    def __init__(self, folder, url: str, nats: Nats, name: str, *more: str) -> None:
        folder.mkdir(mode=0o700, exist_ok=True)
        self.folder, self.name = folder, name
        self.port = free_port()
        self.origin = f"http://127.0.0.1:{self.port}"
        self.link = f"ws://127.0.0.1:{self.port}"
        self._url = url
        self._words = ["--plain", "--port", str(self.port), "--data", str(folder)]
        self._words += ["--cluster", nats.url, "--cluster-name", name, *more]
        self._frozen = False
        self._leads = asyncio.Event()
        # What it prints, line by line.
        self.said = []
        self.process = None

    async def start(self) -> None:
        words = ["-m", "talaia", "hub", *self._words]
        self.process = await start_program(*words, TALAIA_DATABASE_URL=self._url)
        self._reading = asyncio.create_task(self._read())
        await self.until_says("talaia hub is ready")

    async def until_says(self, words: str) -> str:
        """Wait for a line that it prints, or has printed."""

        async def has_said() -> bool:
            return any(words in line for line in self.said)

        await until_answered(has_said)
        return next(line for line in self.said if words in line)

    async def until_leads(self) -> None:
        async with asyncio.timeout(PATIENCE_S):
            await self._leads.wait()

    def leads_shard(self, shard: str) -> bool:
        """Tell whether it has said that it leads a shard; of the main one, too."""
        more = "" if shard == "main" else f" (shard {shard})"
        return f"talaia hub leads: {self.name}{more}\n" in self.said

    async def until_ready(self) -> None:
        """Wait until a load balancer would send somebody here."""
        await until_answered(self.is_ready)

    async def is_ready(self) -> bool:
        async with self.client() as client:
            try:
                return (await client.get("/api/ready")).status_code == 200
            # One that begins anew.
            except httpx.TransportError:
                return False

    def signal(self, number: int) -> None:
        """Send a signal: SIGKILL, SIGSTOP, SIGTERM."""
        self._frozen = number == signal.SIGSTOP
        self.process.send_signal(number)

    async def end(self) -> int:
        """End it, if it runs; give its exit code."""
        if self.process is None:
            return 0
        if self._frozen:
            self.signal(signal.SIGCONT)
        if self.process.returncode is None:
            self.process.send_signal(signal.SIGTERM)
        code = await asyncio.wait_for(self.process.wait(), PATIENCE_S)
        await self._reading
        self.process = None
        return code

    def client(self) -> httpx.AsyncClient:
        headers = {"Origin": self.origin}
        return httpx.AsyncClient(
            base_url=self.origin, headers=headers, timeout=PATIENCE_S, verify=usual_trust()
        )

    async def _read(self) -> None:
        while line := (await self.process.stdout.readline()).decode():
            self.said.append(line)
            if line.startswith("talaia hub leads"):
                self._leads.set()


class Hubs:
    """Hubs on one database; the first leads."""

    def __init__(self, url: str, nats: Nats, folder) -> None:
        self.nats, self.url = nats, url
        self._folder = folder
        self._key = read_or_make_key(folder / "key", os.urandom(32))
        self._stack = AsyncExitStack()
        self.all = []
        self.cookie = ""
        self.gateway_key = ""

    async def __aenter__(self) -> Hubs:
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self._stack.aclose()

    async def add(self, name: str, *more: str, same_key: bool = True) -> OneHub:
        """Start one more, with the key of the others unless it is to have its own."""
        hub = OneHub(self._folder / name, self.url, self.nats, name, *more)
        if same_key:
            read_or_make_key(hub.folder / "seal.key", self._key)
        self._stack.push_async_callback(hub.end)
        self.all.append(hub)
        await hub.start()
        return hub

    async def set_up(self, hub: OneHub) -> None:
        """Make the first person and a gateway, at the hub that leads."""
        token = re.search(r"/setup#(\S+)", await hub.until_says("/setup#"))[1]
        async with hub.client() as client:
            answer = await client.post("/api/setup", json={**ADA, "token": token})
            assert answer.status_code == 200, answer.text
            self.cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        self.gateway_key = await self.enrol(hub, "agv")

    async def enrol(self, hub: OneHub, site: str) -> str:
        """Give the key of a new gateway of a site."""
        async with hub.client() as client:
            client.headers["Cookie"] = self.cookie
            code = (await client.post("/api/gateways/codes", json={"site": site})).json()["code"]
            enrolled = await client.post("/api/enrol", json={"code": code, "name": "bench"})
            return str(enrolled.json()["key"])

    async def page(self, hub: OneHub) -> Peer:
        """Open a page's socket at a hub."""
        headers = {"Origin": hub.origin, "Cookie": self.cookie}
        connection = await self._dial(hub, "/ws", headers)
        return self._keep(Peer(connection, FROM_BROWSER, TO_BROWSER))

    async def gateway(self, hub: OneHub, key: str = "") -> Gateway:
        """Open a gateway's link at a hub, by a key; none: that of the first gateway."""
        headers = {"Authorization": f"Bearer {key or self.gateway_key}"}
        connection = await self._dial(hub, "/gateway/link", headers)
        return self._keep(Gateway(connection, LINK_FROM_GATEWAY, LINK_FROM_HUB))

    async def get(self, hub: OneHub, path: str, **asked) -> httpx.Response:
        """Ask a hub as the person."""
        async with hub.client() as client:
            return await client.get(path, params=asked, headers={"Cookie": self.cookie})

    async def _dial(self, hub: OneHub, path: str, headers):
        return await websockets.connect(
            f"ws://127.0.0.1:{hub.port}{path}",
            additional_headers=headers,
            compression=None,
            proxy=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
        )

    def _keep(self, peer):
        self._stack.push_async_callback(peer.close)
        return peer


@asynccontextmanager
async def two_hubs(url: str, folder, *more: str):
    """Start two hubs, of which the first leads, with a person and a gateway's key.

    ``more``: further words of both.
    """
    async with Nats() as nats, Hubs(url, nats, folder) as hubs:
        lead = await hubs.add("east", *more)
        await lead.until_leads()
        await hubs.set_up(lead)
        other = await hubs.add("west", *more)
        await other.until_ready()
        yield hubs, lead, other


def sites_stored_in(url: str) -> list[str]:
    """Name the sites of which a server has something."""
    engine = sa.create_engine(parse_database_url(url, blocking=True).url)
    try:
        with engine.connect() as connection:
            return sorted(set(connection.scalars(sa.select(channel.c.site))))
    finally:
        engine.dispose()
