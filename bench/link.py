"""The link under load: driving beside samples and cameras, and five hundred gateways at once."""

from __future__ import annotations

import asyncio
import contextlib
import random
import time
from collections.abc import AsyncIterator
from pathlib import Path

import numpy as np
import psutil
import websockets
from clients import cookie
from stack import Stack, context

from talaia.clock import SystemClock
from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.beats import reply_to
from talaia.hub.settings import Settings
from talaia.hub.store.database import Database
from talaia.hub.store.sites import SiteRegistry
from talaia.wire import browser, frames

PERIOD_S = 0.05


def _dial(here: Stack, session: str, path: str) -> websockets.connect:
    return websockets.connect(
        f"wss://localhost:{here.port}{path}", ssl=context(here), compression=None,
        ping_interval=None, max_size=16 * 1024 * 1024, proxy=None,
        additional_headers={"Cookie": session}, origin=here.origin,
    )  # type: ignore[arg-type]  # fmt: skip


@contextlib.asynccontextmanager
async def watching(here: Stack, session: str, cameras: int) -> AsyncIterator[None]:
    """Look at cameras as pages do."""

    async def look(number: int) -> None:
        path = f"/ws/media?site=bench&stream=base/camera{number}"
        async with _dial(here, session, path) as socket:
            async for data in socket:
                shot = browser.MEDIA_TO_BROWSER.decode(data)
                if isinstance(shot, browser.Shot):
                    shown = browser.Shown(seq=shot.seq)
                    await socket.send(browser.MEDIA_FROM_BROWSER.encode(shown))

    tasks = [asyncio.create_task(look(each)) for each in range(cameras)]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def driven(here: Stack, session: str, target: Path, presses: int) -> np.ndarray:
    """Hold a key from a page's socket; give the time (ms) of each frame to the ROS callback."""
    sent: dict[str, float] = {}
    tick, epoch = 0, 0
    async with _dial(here, session, "/ws") as socket:

        async def read() -> None:
            nonlocal tick, epoch
            async for data in socket:
                message = browser.TO_BROWSER.decode(data)
                if isinstance(message, browser.TickNews):
                    tick = message.tick
                elif isinstance(message, browser.LeaseNews) and message.yours:
                    epoch = message.epoch

        async def lease(op: frames.LeaseOp) -> None:
            asked = browser.Lease(site="bench", device="base", op=op)
            await socket.send(browser.FROM_BROWSER.encode(asked))

        reading = asyncio.create_task(read())
        await lease(frames.LeaseOp.TAKE)
        while not (epoch and tick):
            await asyncio.sleep(0.01)
        chance = random.Random(1)  # noqa: S311 - of a benchmark
        for number in range(presses):
            speed = 0.05 + number * 0.0005
            frame = browser.Drive(
                site="bench", device="base", epoch=epoch, seq=number + 1, tick=tick,
                linear=speed, angular=0.0,
            )  # fmt: skip
            sent[f"{speed:.4f}"] = time.time() * 1e6
            await socket.send(browser.FROM_BROWSER.encode(frame))
            if number % 20 == 19:
                await lease(frames.LeaseOp.RENEW)
            # In no step with any timer of the others.
            await asyncio.sleep(PERIOD_S + chance.uniform(0, 0.02))
        await asyncio.sleep(0.5)
        await lease(frames.LeaseOp.FREE)
        reading.cancel()
        await asyncio.gather(reading, return_exceptions=True)
    heard: dict[str, float] = {}
    for line in target.read_text().splitlines():
        at, speed, _ = line.split()
        heard.setdefault(speed, float(at))
    return np.array([(heard[key] - at) / 1000 for key, at in sent.items() if key in heard])


class Crowd:
    """Many gateways that say hello, answer beats, and dial again as the real one does."""

    def __init__(self, here: Stack, keys: list[str]) -> None:
        """Take a key for each; site ``crowdN`` for number N."""
        self._here, self._keys = here, keys
        self._sockets: dict[int, websockets.ClientConnection] = {}
        self._trust = context(here)
        self._tasks = [asyncio.create_task(self._live(each)) for each in range(len(keys))]

    @property
    def linked(self) -> int:
        """How many have had their welcome."""
        return len(self._sockets)

    def cut(self) -> None:
        """End all links at one blow."""
        for socket in [*self._sockets.values()]:
            socket.transport.abort()
        self._sockets.clear()

    async def all_back(self, within: float) -> float:
        """Wait until all are linked; give how long it took (s)."""
        began = time.monotonic()
        while self.linked < len(self._keys):
            if time.monotonic() - began > within:
                raise SystemExit(f"{self.linked} of {len(self._keys)} gateways after {within} s")
            await asyncio.sleep(0.05)
        return time.monotonic() - began

    async def _live(self, number: int) -> None:
        backoff = Backoff(random.Random(number).random)  # noqa: S311
        while True:
            began = time.monotonic()
            with contextlib.suppress(OSError, TimeoutError, websockets.WebSocketException):
                await self._link(number)
            self._sockets.pop(number, None)
            await asyncio.sleep(backoff.after(time.monotonic() - began))

    async def _link(self, number: int) -> None:
        site = f"crowd{number}"
        async with websockets.connect(
            f"wss://localhost:{self._here.port}/gateway/link", ssl=self._trust, compression=None,
            ping_interval=None, proxy=None,
            additional_headers={"Authorization": f"Bearer {self._keys[number]}"},
        ) as socket:  # fmt: skip
            text = f"talaia: 1\nsite: {site}\nname: {site}\ndevices: {{hut: {{name: Hut}}}}\n"
            hello = frames.Hello(site=site, boot="b", catalogue="c", description=text)
            await socket.send(frames.LINK_FROM_GATEWAY.encode(hello))
            async for data in socket:
                message = frames.LINK_FROM_HUB.decode(data)
                if isinstance(message, frames.Welcome):
                    self._sockets[number] = socket
                elif isinstance(message, frames.Beat):
                    reply = reply_to(message, time.monotonic_ns())
                    await socket.send(frames.LINK_FROM_GATEWAY.encode(reply))

    async def close(self) -> None:
        """Send all home."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)


async def crowd(here: Stack, count: int) -> Crowd:
    """Enrol so many gateways and let them dial."""
    database = Database(Settings(data=here.folder).url)
    registry = SiteRegistry(database, SystemClock())
    keys = [await registry.new_key(f"crowd{each}") for each in range(count)]
    await database.close()
    return Crowd(here, keys)


async def storm(here: Stack, target: Path, count: int) -> tuple[float, float, np.ndarray]:
    """Let many gateways lose the link at once; give s until all are back, MiB more, drive ages."""
    session = await cookie(here)
    many = await crowd(here, count)
    try:
        await many.all_back(120)
        await asyncio.sleep(2)
        hub = psutil.Process(here.hub.process.pid)
        before = hub.memory_info().rss
        driving = asyncio.create_task(driven(here, session, target, 200))
        await asyncio.sleep(2)
        many.cut()
        took = await many.all_back(60)
        ages = await driving
        grown = (hub.memory_info().rss - before) / 2**20
    finally:
        await many.close()
    return took, grown, ages
