"""The link under load: driving beside samples and cameras, and hundreds of gateways at once."""

from __future__ import annotations

import asyncio
import contextlib
import json
import random
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
import websockets
from clients import cookie
from stack import HERE, Stack, context

from talaia.clock import SystemClock
from talaia.hub.settings import Settings
from talaia.hub.store.database import Database
from talaia.hub.store.sites.site_registry import add_key
from talaia.wire import browser, frames

PERIOD_S = 0.05


def _dial(here: Stack, session: str, path: str) -> websockets.connect:
    return websockets.connect(
        f"wss://localhost:{here.port}{path}", ssl=context(here), compression=None,
        ping_interval=None, max_size=16 * 1024 * 1024, proxy=None,
        additional_headers={"Cookie": session}, origin=here.origin,
    )  # type: ignore[arg-type]  # fmt: skip


@contextlib.asynccontextmanager
async def watching(here: Stack, session: str, *cameras: str) -> AsyncIterator[None]:
    """Look at cameras as pages do."""

    async def look(name: str) -> None:
        path = f"/ws/media?site=bench&stream=base/{name}&forms=h264,jpeg"
        async with _dial(here, session, path) as socket:
            async for data in socket:
                shot = browser.MEDIA_TO_BROWSER.decode(data)
                if isinstance(shot, browser.CameraPicture):
                    shown = browser.PictureShown(seq=shot.seq)
                    await socket.send(browser.MEDIA_FROM_BROWSER.encode(shown))

    tasks = [asyncio.create_task(look(each)) for each in cameras]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def driven(here: Stack, session: str, target: Path, presses: int) -> np.ndarray:
    """Hold a key from a page's socket; give the time (ms) of each frame to the ROS callback."""
    sent: dict[str, float] = {}
    # Who drove before was told the same speeds.
    former = len(target.read_text().splitlines())
    tick, epoch = 0, 0
    async with _dial(here, session, "/ws") as socket:

        async def read() -> None:
            nonlocal tick, epoch
            async for data in socket:
                message = browser.TO_BROWSER.decode(data)
                if isinstance(message, browser.TickUpdate):
                    tick = message.tick
                elif isinstance(message, browser.LeaseUpdate) and message.yours:
                    epoch = message.epoch

        async def lease(op: frames.LeaseOp) -> None:
            asked = browser.PageLease(site="bench", device="base", op=op)
            await socket.send(browser.FROM_BROWSER.encode(asked))

        reading = asyncio.create_task(read())
        await lease(frames.LeaseOp.TAKE)
        while not (epoch and tick):
            await asyncio.sleep(0.01)
        chance = random.Random(1)  # noqa: S311 - of a benchmark
        for number in range(presses):
            speed = 0.05 + number * 0.0005
            frame = browser.PageDrive(
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
    for line in target.read_text().splitlines()[former:]:
        at, speed, _ = line.split()
        heard.setdefault(speed, float(at))
    return np.array([(heard[key] - at) / 1000 for key, at in sent.items() if key in heard])


class Crowd:
    """Many gateways, in a process of their own (see ``crowd.py``)."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        """Take the process that has its keys."""
        self._process = process

    async def cut(self) -> None:
        """End all links at one blow."""
        await self._say("cut\n")

    async def samples_sent(self) -> int:
        """Ask, after `all_kept`, how many samples were sent so far."""
        await self._say("sent\n")
        return int(await self._read_line())

    async def expect_loss(self) -> None:
        """Say that a hub is killed now."""
        await self._say("lost\n")

    async def all_again(self, within: float) -> list[float]:
        """Wait, after `expect_loss`, until each is linked anew; give after how long (s)."""
        async with asyncio.timeout(within):
            found: list[float] = json.loads(await self._read_line())
        return found

    async def _read_line(self) -> bytes:
        assert self._process.stdout is not None
        said = await self._process.stdout.readline()
        if not said:
            raise SystemExit("the crowd of gateways has ended")
        return said

    async def _say(self, words: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(words.encode())
        await self._process.stdin.drain()

    async def all_back(self, within: float) -> float:
        """Wait until all are linked; give how long it took (s)."""
        return await self._wait_for(b"linked\n", within)

    async def all_kept(self, within: float) -> float:
        """Wait, after `all_back`, until a batch of each was acknowledged; give how long (s)."""
        return await self._wait_for(b"kept\n", within)

    async def _wait_for(self, words: bytes, within: float) -> float:
        began = time.monotonic()
        async with asyncio.timeout(within):
            while await self._read_line() != words:
                pass
        return time.monotonic() - began


@contextlib.asynccontextmanager
async def crowd(here: Stack, count: int, signals: int = 0) -> AsyncIterator[Crowd]:
    """Enrol so many gateways and let them dial; each has so many signals at 1 Hz."""
    certificate = str(here.folder / "tls" / "cert.pem")
    async with crowd_at(Settings(data=here.folder), [here.port], certificate, count, signals) as it:
        yield it


@contextlib.asynccontextmanager
async def crowd_at(
    settings: Settings, ports: list[int], certificate: str, count: int, signals: int
) -> AsyncIterator[Crowd]:
    """Enrol so many gateways, and let them dial hubs at ``ports``; see `crowd`."""
    database = Database(settings.url)
    keys = []
    # In one transaction: thousands of their own would take minutes.
    async with database.write() as connection:
        for number in range(count):
            made = await add_key(connection, f"crowd{number}", "", SystemClock().wall_ns() // 1000)
            keys.append(made[1])
    await database.close()
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(HERE / "crowd.py"), ",".join(str(port) for port in ports),
        certificate, str(signals),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=2**20,
    )  # fmt: skip
    try:
        assert process.stdin is not None
        process.stdin.write("\n".join([*keys, "", ""]).encode())
        yield Crowd(process)
    finally:
        process.kill()
        await process.wait()


class JoinCost(NamedTuple):
    """What many gateways cost their hub.

    Attributes:
        joined_s: until all were linked the first time, and ``kept_s`` until of each a batch was
            acknowledged after that (s).
        join_ms: CPU of the hub for each of them, until then (ms), without that for the samples of
            those that are there already (``with_samples_ms``: with them).
        again_ms: the same after all had lost the link, until they were linked again.
        back_s: until all were back (s).
        running: of a core, while they send.
        row_us: CPU of the hub for each sample meanwhile (µs).
        memory_kib: of the hub, for each of them (KiB).

    """

    joined_s: float
    kept_s: float
    join_ms: float
    with_samples_ms: float
    again_ms: float
    back_s: float
    running: float
    row_us: float
    memory_kib: float


async def join(here: Stack, count: int, signals: int, seconds: float) -> JoinCost:
    """Let so many new gateways with so many signals come, send for a while, and all come again."""
    hub = psutil.Process(here.hub.process.pid)

    def used_s() -> float:
        return sum(hub.cpu_times()[:2])

    await asyncio.sleep(2)
    before, began = used_s(), time.monotonic()
    await asyncio.sleep(8)
    alone = (used_s() - before) / (time.monotonic() - began)
    memory, before, began = hub.memory_info().rss, used_s(), time.monotonic()
    async with crowd(here, count, signals) as many:
        joined_s = await many.all_back(300)
        kept_s = await many.all_kept(300)
        join_s = used_s() - before - alone * (time.monotonic() - began)
        sent = await many.samples_sent()
        await asyncio.sleep(5)
        before, began = used_s(), time.monotonic()
        await asyncio.sleep(seconds)
        running = (used_s() - before) / (time.monotonic() - began)
        grown = hub.memory_info().rss - memory
        before = used_s()
        await many.cut()
        back_s = await many.all_back(120)
        again_s = used_s() - before - running * back_s
    row_s = (running - alone) / (count * signals) if signals else 0.0
    return JoinCost(
        joined_s, kept_s, 1e3 * (join_s - row_s * sent) / count, 1e3 * join_s / count,
        1e3 * again_s / count, back_s, running, 1e6 * row_s, grown / count / 1024,
    )  # fmt: skip


async def storm(here: Stack, target: Path, count: int) -> tuple[float, float, np.ndarray]:
    """Let many gateways lose the link at once; give s until all are back, MiB more, drive ages."""
    session = await cookie(here)
    async with crowd(here, count) as many:
        await many.all_back(120)
        await asyncio.sleep(2)
        hub = psutil.Process(here.hub.process.pid)
        before = hub.memory_info().rss
        driving = asyncio.create_task(driven(here, session, target, 200))
        await asyncio.sleep(2)
        await many.cut()
        took = await many.all_back(60)
        ages = await driving
        grown = (hub.memory_info().rss - before) / 2**20
    return took, grown, ages
