"""Hubs as processes on a database of their own, alone or as one; who speaks to them in a bench."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
import shutil
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import numpy as np
import psutil
import sqlalchemy as sa
import websockets
from stack import PASSWORD, free_port, site_text

from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns

SERVER = os.environ.get("TALAIA_TEST_POSTGRESQL", "postgresql+pg8000://postgres@127.0.0.1/postgres")
# Site and channel of `Gateway`.
SITE, CHANNEL, EPOCH = "bench", "base/s0", 7
PEOPLE = 6


class Hub:
    """One of the hubs, as a process; ``nats`` is none for one that is alone."""

    def __init__(self, folder: Path, url: str, nats: int | None, name: str, *more: str) -> None:
        """Prepare to start one, with ``more`` words."""
        self.folder, self.port, self.name = folder / name, free_port(), name
        self._words = ["-m", "talaia", "hub", "--plain", "--port", str(self.port)]
        self._words += ["--data", str(self.folder)]
        if nats is not None:
            self._words += ["--cluster", f"nats://127.0.0.1:{nats}", "--cluster-name", name]
        self._words += more
        self._environment = {**os.environ, "TALAIA_DATABASE_URL": url, "PYTHONUNBUFFERED": "1"}
        self.lines: list[str] = []

    async def start(self, until: str) -> None:
        """Start it, until it has printed something."""
        self.process = await asyncio.create_subprocess_exec(
            sys.executable, *self._words, env=self._environment, stdout=asyncio.subprocess.PIPE
        )
        self._reading = asyncio.create_task(self._read())
        while not any(until in line for line in self.lines):
            await asyncio.sleep(0.05)

    async def _read(self) -> None:
        assert self.process.stdout is not None
        while line := (await self.process.stdout.readline()).decode():
            self.lines.append(line)

    @property
    def origin(self) -> str:
        """Its address."""
        return f"http://localhost:{self.port}"

    @property
    def program(self) -> psutil.Process:
        """Its process, to be measured."""
        return psutil.Process(self.process.pid)

    def cpu_s(self) -> float:
        """Processor time so far (s)."""
        return float(sum(self.program.cpu_times()[:2]))

    async def is_ready(self) -> bool:
        """Ask as a load balancer does."""
        try:
            async with httpx.AsyncClient() as client:
                return (await client.get(f"{self.origin}/api/ready")).status_code == 200
        except httpx.TransportError:
            return False

    async def dial(self, path: str, **headers: str) -> websockets.ClientConnection:
        """Open a socket there."""
        return await websockets.connect(
            f"ws://localhost:{self.port}{path}",
            # A gateway is no page, and names no origin.
            additional_headers=headers | ({"Origin": self.origin} if "Cookie" in headers else {}),
            compression=None, proxy=None, ping_interval=None, open_timeout=60,
        )  # fmt: skip

    async def sign_in(self) -> list[str]:
        """Give a session of each of the people."""
        found = []
        for number in range(PEOPLE):
            async with httpx.AsyncClient(base_url=self.origin, timeout=60) as client:
                who = {"name": f"person {number}", "password": PASSWORD}
                headers = {"Origin": self.origin}
                (await client.post("/api/login", json=who, headers=headers)).raise_for_status()
                found.append("; ".join(f"{word}={value}" for word, value in client.cookies.items()))
        return found

    async def end(self) -> None:
        """End it, if it runs."""
        if self.process.returncode is None:
            self.process.terminate()
        await self.process.wait()


class Deployment:
    """Hubs on one database, the first of which leads."""

    def __init__(self, hubs: list[Hub], settings: Settings) -> None:
        """Speak of ``hubs``; ``settings`` reach their database."""
        self.hubs, self.settings = hubs, settings
        self.lead = hubs[0]
        self.sessions: list[str] = []
        self.key = ""

    def cpu_s(self) -> list[float]:
        """Processor time of each so far (s)."""
        return [hub.cpu_s() for hub in self.hubs]

    async def cpu_over(self, seconds: float) -> np.ndarray:
        """Measure what each takes of a core meanwhile."""
        before, began = np.array(self.cpu_s()), time.monotonic()
        await asyncio.sleep(seconds)
        return (np.array(self.cpu_s()) - before) / (time.monotonic() - began)

    async def gateway(self, hub: Hub) -> Gateway:
        """Link a gateway of the site `SITE` at a hub."""
        gateway = Gateway(await hub.dial("/gateway/link", Authorization=f"Bearer {self.key}"))
        await gateway.hello()
        return gateway

    async def page(self, hub: Hub) -> websockets.ClientConnection:
        """Open a page's socket there that looks at `CHANNEL`."""
        page = await hub.dial("/ws", Cookie=self.sessions[0])
        asked = browser.Subscribe(sub=1, site=SITE, channels=[CHANNEL], every_ms=0)
        await page.send(browser.FROM_BROWSER.encode(asked))
        return page


@contextlib.asynccontextmanager
async def deployment(count: int, *, shards: int = 0) -> AsyncIterator[Deployment]:
    """Run hubs on a database of PostgreSQL that is made for them; one is alone, without NATS.

    Sites are divided among ``shards`` besides the main one, which then has the accounts alone.
    """
    async with contextlib.AsyncExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="talaia-cluster-")))
        url = stack.enter_context(_database())
        nats = None
        if count > 1:
            nats = await stack.enter_async_context(_nats())
        more = []
        if shards:
            servers = {f"shard{at}": stack.enter_context(_database()) for at in range(shards)}
            text = {"servers": servers, "shards": list(servers), "default": list(servers)}
            # JSON is YAML.
            (folder / "servers.yaml").write_text(json.dumps(text))
            (folder / "servers.yaml").chmod(0o600)
            more = ["--history-servers", str(folder / "servers.yaml")]
        names = ("east", "west", "south", "north")[:count]
        hubs = [Hub(folder, url, nats, name, *more) for name in names]
        seal = secrets.token_bytes(32)
        for hub in hubs:
            hub.folder.mkdir(mode=0o700)
            (hub.folder / "seal.key").write_bytes(seal)
        settings = Settings(data=hubs[0].folder, database_url=url)
        for number in range(PEOPLE):
            await accounts.create_user(settings, f"person {number}", PASSWORD, "admin")
        here = Deployment(hubs, settings)
        here.key = await accounts.create_gateway(settings, SITE)
        for hub in hubs:
            leads = count > 1 and hub is hubs[0]
            await hub.start("leads" if leads else "is ready")
            stack.push_async_callback(hub.end)
        while not all([await hub.is_ready() for hub in hubs]):
            await asyncio.sleep(0.1)
        while sum("leads:" in line for hub in hubs for line in hub.lines) < 1 + shards and shards:
            await asyncio.sleep(0.1)
        here.sessions = await hubs[0].sign_in()
        yield here


@contextlib.contextmanager
def _database():  # noqa: ANN202 - a URL
    engine = sa.create_engine(SERVER, isolation_level="AUTOCOMMIT")
    name = f"talaia_bench_{secrets.token_hex(4)}"
    with engine.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    try:
        yield (
            sa.make_url(SERVER)
            .set(database=name, drivername="postgresql", query={"sslmode": "disable"})
            .render_as_string(hide_password=False)
        )
    finally:
        with engine.connect() as connection:
            connection.exec_driver_sql(f"DROP DATABASE {name} WITH (FORCE)")
        engine.dispose()


@contextlib.asynccontextmanager
async def _nats() -> AsyncIterator[int]:
    port = free_port()
    program = shutil.which("nats-server", path=f"{os.environ['PATH']}:/usr/sbin")
    assert program is not None, "nats-server is missing"
    quiet = asyncio.subprocess.DEVNULL
    process = await asyncio.create_subprocess_exec(
        program, "-a", "127.0.0.1", "-p", str(port), stdout=quiet, stderr=quiet
    )
    try:
        yield port
    finally:
        process.terminate()
        await process.wait()


class Gateway:
    """A link that answers beats, lends control, and notes when frames come."""

    def __init__(self, connection: websockets.ClientConnection) -> None:
        """Speak over ``connection``."""
        self._connection = connection
        # By what was sent: the id of a STOP, or a speed.
        self.came: dict[str, float] = {}
        self.heard = asyncio.Event()
        self.welcomed = asyncio.Event()
        self._sequence = 0
        self._boot = secrets.token_hex(4)
        self._reading = asyncio.create_task(self._read())

    async def hello(self) -> None:
        """Say which site it is, and wait until it is linked."""
        await self._say(
            frames.Hello(site=SITE, boot=self._boot, description=site_text(1), catalogue="c1")
        )
        await self.welcomed.wait()

    async def sample(self, value: float) -> None:
        """Send one sample."""
        now = np.array([time.time_ns() // 1000], np.int64)
        packed = pack_columns(Columns(np.zeros(1, np.uint16), now, np.array([value]), {}))
        batch = frames.SampleBatch(
            boot=self._boot, first=self._sequence, catalogue="c1", live=True, **packed._asdict()
        )
        self._sequence += 1
        await self._say(batch)

    async def until_came(self, word: str) -> float:
        """Wait for a STOP or a speed; give the moment when it came."""
        while word not in self.came:
            self.heard.clear()
            await self.heard.wait()
        return self.came[word]

    async def _say(self, message: object) -> None:
        await self._connection.send(frames.LINK_FROM_GATEWAY.encode(message))

    async def _read(self) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            async for data in self._connection:
                await self._take(frames.LINK_FROM_HUB.decode(data))

    async def _take(self, message: object) -> None:
        match message:
            case frames.Beat():
                now = time.monotonic_ns() // 1000
                reply = frames.BeatReply(n=message.n, mono_us=message.mono_us, peer_us=now)
                await self._say(reply)
            case frames.Welcome():
                self.welcomed.set()
            case frames.LeaseRequest():
                held = message.op is not frames.LeaseOp.FREE
                await self._say(
                    frames.LeaseState(
                        device="base", session=message.session if held else "",
                        who=message.who if held else "", epoch=EPOCH, remains_ms=10_000,
                        asked=message.session,
                    )
                )  # fmt: skip
            case frames.StopRequest():
                self._note(message.id)
            case frames.DriveFrame():
                self._note(f"{message.linear:.4f}")

    def _note(self, word: str) -> None:
        self.came[word] = time.perf_counter()
        self.heard.set()
