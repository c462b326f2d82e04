"""Two hubs as one beside the lead alone, in one run: latency, processor time, a take-over.

PYTHONPATH=src python bench/cluster.py (nats-server; PostgreSQL at TALAIA_TEST_POSTGRESQL)
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import secrets
import shutil
import signal
import socket
import sys
import tempfile
import time
from contextlib import AsyncExitStack
from pathlib import Path

import httpx
import numpy as np
import psutil
import sqlalchemy as sa
import websockets

from talaia.model.yaml_text.load import load_site
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns

SERVER = os.environ.get("TALAIA_TEST_POSTGRESQL", "postgresql+pg8000://postgres@127.0.0.1/postgres")
PERSON = {"name": "ada", "password": "three unrelated words"}
SITE = """
talaia: 1
site: agv
name: Bench
connections: {shell: {kind: process, poll: 1, timeout: 2}}
devices:
  base:
    name: Base
    connection: shell
    signals:
      speed: {name: Speed, unit: m/s, source: {run: echo 1, pattern: '([0-9.]+)'}}
"""
TIMES = 300
PAGES, HERTZ, SPAN_S = 40, 10, 8.0


def free_port() -> int:
    """Find a port of loopback."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Hub:
    """One of the hubs, as a process."""

    def __init__(self, folder: Path, url: str, nats: int, name: str) -> None:
        """Prepare to start one."""
        self.port, self.name = free_port(), name
        words = ["-m", "talaia", "hub", "--plain", "--port", str(self.port), "--data", str(folder)]
        self._words = [*words, "--cluster", f"nats://127.0.0.1:{nats}", "--cluster-name", name]
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
        return f"http://127.0.0.1:{self.port}"

    def cpu_s(self) -> float:
        """Processor time so far (s)."""
        times = psutil.Process(self.process.pid).cpu_times()
        return times.user + times.system

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
            f"ws://127.0.0.1:{self.port}{path}",
            # A gateway is no page, and names no origin.
            additional_headers=headers | ({"Origin": self.origin} if "Cookie" in headers else {}),
            compression=None, proxy=None, ping_interval=None, open_timeout=60,
        )  # fmt: skip


class Gateway:
    """A link that answers beats, and notes when frames come."""

    def __init__(self, connection: websockets.ClientConnection) -> None:
        """Speak over ``connection``."""
        self._connection = connection
        self.came: dict[str, float] = {}
        self.heard = asyncio.Event()
        self._sequence = 0
        self._reading = asyncio.create_task(self._read())
        self.welcomed = asyncio.Event()

    async def hello(self) -> None:
        """Say which site it is, and wait until it is linked."""
        boot = secrets.token_hex(4)
        self._boot = boot
        said = frames.Hello(site="agv", boot=boot, description=SITE, catalogue="c1")
        await self._say(said)
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

    async def _say(self, message: object) -> None:
        await self._connection.send(frames.LINK_FROM_GATEWAY.encode(message))

    async def _read(self) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            await self._read_all()

    async def _read_all(self) -> None:
        async for data in self._connection:
            message = frames.LINK_FROM_HUB.decode(data)
            match message:
                case frames.Beat():
                    now = time.monotonic_ns() // 1000
                    await self._say(
                        frames.BeatReply(n=message.n, mono_us=message.mono_us, peer_us=now)
                    )
                case frames.Welcome():
                    self.welcomed.set()
                case frames.StopRequest():
                    self.came[message.id] = time.perf_counter()
                    self.heard.set()


async def sample_to_page(gateway: Gateway, page: websockets.ClientConnection) -> np.ndarray:
    """Measure from a gateway's socket to a page's (ms)."""
    found = []
    for at in range(TIMES):
        began = time.perf_counter()
        await gateway.sample(float(at))
        while True:
            told = browser.TO_BROWSER.decode(await page.recv())
            if isinstance(told, browser.Values):
                break
        found.append((time.perf_counter() - began) * 1000)
        await asyncio.sleep(0.01)
    return np.array(found)


async def page_to_gateway(gateway: Gateway, page: websockets.ClientConnection) -> np.ndarray:
    """Measure STOP from a page's socket to a gateway's (ms)."""
    found = []
    for _ in range(TIMES):
        word = secrets.token_hex(4)
        began = time.perf_counter()
        await page.send(
            browser.FROM_BROWSER.encode(browser.PageStop(site="agv", device="base", id=word))
        )
        while word not in gateway.came:
            gateway.heard.clear()
            await gateway.heard.wait()
        found.append((gateway.came[word] - began) * 1000)
        await asyncio.sleep(0.01)
    return np.array(found)


async def open_page(hub: Hub, cookie: str) -> websockets.ClientConnection:
    """Open a page's socket that is subscribed."""
    page = await hub.dial("/ws", Cookie=cookie)
    asked = browser.Subscribe(sub=1, site="agv", channels=["base/speed"], every_ms=0)
    await page.send(browser.FROM_BROWSER.encode(asked))
    return page


async def serve_pages(hubs: list[Hub], at: Hub, gateway: Gateway, cookie: str) -> list[float]:
    """Give what each hub takes (s of a core) for `PAGES` pages at one of them, a second."""
    pages = [await open_page(at, cookie) for _ in range(PAGES)]
    heard = 0

    async def read(page: websockets.ClientConnection) -> None:
        nonlocal heard
        async for data in page:
            heard += isinstance(browser.TO_BROWSER.decode(data), browser.Values)

    reading = [asyncio.create_task(read(page)) for page in pages]
    before, began, sent = [hub.cpu_s() for hub in hubs], time.monotonic(), 0
    while time.monotonic() - began < SPAN_S:
        await gateway.sample(float(sent))
        sent += 1
        await asyncio.sleep(1 / HERTZ)
    passed = time.monotonic() - began
    after = [hub.cpu_s() for hub in hubs]
    for task in reading:
        task.cancel()
    for page in pages:
        await page.close()
    print(f"  {heard} of about {sent * PAGES} frames came")
    return [(end - start) / passed for start, end in zip(before, after, strict=True)]


def show(what: str, near: np.ndarray, far: np.ndarray) -> None:
    """Print both beside each other."""
    for share in (50, 99):
        one, two = np.percentile(near, share), np.percentile(far, share)
        said = f"{one:.2f} ms at the lead, {two:.2f} through another (+{two - one:.2f})"
        print(f"{what} p{share}: {said}")


async def main() -> None:
    """Measure everything, and print it."""
    load_site(SITE)
    async with AsyncExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        engine = sa.create_engine(SERVER, isolation_level="AUTOCOMMIT")
        name = f"talaia_bench_{secrets.token_hex(4)}"
        with engine.connect() as connection:
            connection.exec_driver_sql(f"CREATE DATABASE {name}")
        url = sa.make_url(SERVER).set(
            database=name, drivername="postgresql", query={"sslmode": "disable"}
        ).render_as_string(hide_password=False)  # fmt: skip
        port = free_port()
        program = shutil.which("nats-server", path=f"{os.environ['PATH']}:/usr/sbin")
        assert program is not None, "nats-server is missing"
        quiet = asyncio.subprocess.DEVNULL
        nats = await asyncio.create_subprocess_exec(
            program, "-a", "127.0.0.1", "-p", str(port), stdout=quiet, stderr=quiet
        )
        hubs = [Hub(folder / word, url, port, word) for word in ("east", "west")]
        key = secrets.token_bytes(32)
        try:
            for hub in hubs:
                (folder / hub.name).mkdir(mode=0o700)
                (folder / hub.name / "seal.key").write_bytes(key)
                await hub.start("leads" if hub is hubs[0] else "is ready")
            await measure(hubs)
        finally:
            for hub in hubs:
                if hub.process.returncode is None:
                    hub.process.terminate()
                await hub.process.wait()
            nats.terminate()
            await nats.wait()
            with engine.connect() as connection:
                connection.exec_driver_sql(f"DROP DATABASE {name} WITH (FORCE)")
            engine.dispose()


async def measure(hubs: list[Hub]) -> None:
    """Measure with two hubs, of which the first leads."""
    lead, other = hubs
    while not any("/setup#" in line for line in lead.lines):
        await asyncio.sleep(0.05)
    token = re.search(r"/setup#(\S+)", "".join(lead.lines))
    assert token is not None
    async with httpx.AsyncClient(
        base_url=lead.origin, headers={"Origin": lead.origin}, timeout=60
    ) as client:
        (await client.post("/api/setup", json={**PERSON, "token": token[1]})).raise_for_status()
        code = (await client.post("/api/gateways/codes", json={"site": "agv"})).json()["code"]
        key = (await client.post("/api/enrol", json={"code": code, "name": "bench"})).json()["key"]
        cookie = "; ".join(f"{word}={value}" for word, value in client.cookies.items())
    while not await other.is_ready():
        await asyncio.sleep(0.1)
    gateway = Gateway(await lead.dial("/gateway/link", Authorization=f"Bearer {key}"))
    await gateway.hello()
    near, far = await open_page(lead, cookie), await open_page(other, cookie)
    show("sample to page", await sample_to_page(gateway, near), await sample_to_page(gateway, far))
    show(
        "STOP to gateway", await page_to_gateway(gateway, near), await page_to_gateway(gateway, far)
    )
    await near.close()
    await far.close()
    for at, words in ((lead, "at the lead"), (other, "at the other")):
        used = await serve_pages(hubs, at, gateway, cookie)
        print(
            f"{PAGES} pages at {HERTZ} Hz {words}: {used[0] * 100:.1f} % of a core for the lead,"
            f" {used[1] * 100:.1f} % for the other"
        )
    began = time.perf_counter()
    lead.process.send_signal(signal.SIGKILL)
    while not await other.is_ready() or not any("leads" in line for line in other.lines):
        await asyncio.sleep(0.02)
    ready = time.perf_counter() - began
    again = Gateway(await other.dial("/gateway/link", Authorization=f"Bearer {key}"))
    await again.hello()
    linked = time.perf_counter() - began
    print(
        f"the lead is killed: another leads after {ready:.2f} s,"
        f" a gateway is linked at {linked:.2f} s"
    )


if __name__ == "__main__":
    asyncio.run(main())
