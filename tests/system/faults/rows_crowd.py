"""Rows of those who read slowly, not at all, or all at once."""

from __future__ import annotations

import asyncio
import contextlib
import random
import socket as sockets
import time
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import numpy as np
from browser_program import find_browser
from patience import PATIENCE_MS, lasts_for
from shared_trust import usual_trust
from websockets.asyncio.client import ClientConnection, connect

from talaia.clock import SystemClock
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.hub import accounts
from talaia.hub.errors import HubError
from talaia.hub.settings import Settings
from talaia.hub.store.database import Database
from talaia.hub.store.sites.site_registry import SiteRegistry
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns, unpack_columns

from ..conftest import launching, missing
from ..people import PERIOD_S, page
from ..stack import PASSWORD, Process, until
from .crowd import hello
from .doing import ages, p99, sees_values
from .ledgers import Findings
from .world import SITE, Run, World, now, under_load

FLOOD = "flood"
TEXTS = 100
BOUND_MIB = 8.0
SLOWER_MS = 10.0
BACK_S = 60.0


def hub_settings(world: World) -> Settings:
    return Settings(
        data=world.hub_data, host="127.0.0.1", port=world.port, plain=True, password_cost=4
    )


class Flood:
    """A gateway of another site that pours texts (4 MB/s) at whoever subscribes to them."""

    def __init__(self) -> None:
        """Begin at the first."""
        self.said = 0
        self.linked = asyncio.Event()
        self.pouring = True

    async def run(self, world: World, key: str) -> None:
        async with connect(
            f"ws://127.0.0.1:{world.port}/gateway/link", compression=None, ping_interval=None,
            proxy=None, additional_headers={"Authorization": f"Bearer {key}"},
        ) as link:  # fmt: skip
            source = "{topic: /t, type: std_msgs/msg/String, field: data}"
            signal = f"{{name: Text, type: text, source: {source}}}"
            await link.send(hello(FLOOD, f"{{hut: {{name: Hut, signals: {{text: {signal}}}}}}}"))
            pour = asyncio.create_task(self._pour(link))
            try:
                async for data in link:
                    message = frames.LINK_FROM_HUB.decode(data)
                    if isinstance(message, frames.Welcome):
                        self.linked.set()
                    elif isinstance(message, frames.Beat):
                        reply = reply_to(message, time.monotonic_ns())
                        await link.send(frames.LINK_FROM_GATEWAY.encode(reply))
            finally:
                pour.cancel()

    async def _pour(self, link: ClientConnection) -> None:
        await self.linked.wait()
        while True:
            if self.pouring:
                at = np.full(TEXTS, time.time_ns() // 1000)
                texts = {each: f"{self.said + each} ".ljust(1990, "x") for each in range(TEXTS)}
                columns = Columns(np.zeros(TEXTS, np.uint16), at, np.full(TEXTS, np.nan), texts)
                # The hub stores each number once, so that its disk is not what is measured here.
                batch = frames.SampleBatch(
                    boot="flood", first=0, catalogue="c", **pack_columns(columns)._asdict()
                )
                self.said += TEXTS
                await link.send(frames.LINK_FROM_GATEWAY.encode(batch))
            await asyncio.sleep(PERIOD_S)


@contextlib.asynccontextmanager
async def flood(world: World) -> AsyncIterator[Flood]:
    """Let it pour."""
    pouring = Flood()
    task = asyncio.create_task(pouring.run(world, await accounts.create_gateway(
        hub_settings(world), FLOOD
    )))  # fmt: skip
    try:
        await asyncio.wait([task, asyncio.ensure_future(pouring.linked.wait())], timeout=10,
                           return_when=asyncio.FIRST_COMPLETED)  # fmt: skip
        assert pouring.linked.is_set(), "the flood is not linked"
        yield pouring
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


@contextlib.asynccontextmanager
async def reluctant(world: World, cookie: str) -> AsyncIterator[ClientConnection]:
    """Open a page that asks for the flood and takes nothing by itself, nor does its machine."""
    narrow = sockets.socket()
    narrow.setsockopt(sockets.SOL_SOCKET, sockets.SO_RCVBUF, 4096)
    narrow.connect(("127.0.0.1", world.port))
    narrow.setblocking(False)  # noqa: FBT003
    async with connect(
        f"ws://localhost:{world.port}/ws", sock=narrow, compression=None, ping_interval=None,
        close_timeout=0.1, max_queue=1, additional_headers={"Cookie": cookie},
        origin=world.address,  # type: ignore[arg-type]
        max_size=None, proxy=None,
    ) as reading:  # fmt: skip
        asked = browser.Subscribe(sub=1, site=FLOOD, channels=["hut/text"], every_ms=0)
        await reading.send(browser.FROM_BROWSER.encode(asked))
        try:
            yield reading
        finally:
            reading.transport.abort()


async def f16(world: World, chance: random.Random, findings: Findings) -> None:
    """Pages that never read, of a site that says much: bounded, and others notice nothing."""
    count = 4
    async with under_load(world, findings), flood(world), ages(world) as others:
        cookie, seconds = await world.cookie(), 2.0 if world.long else 1.0
        slower, grown = [], []
        for _ in range(3):
            before = world.memory()["hub"]
            calm = p99(await others.during(seconds))
            async with contextlib.AsyncExitStack() as stack:
                for _ in range(count):
                    await stack.enter_async_context(reluctant(world, cookie))
                await asyncio.sleep(1.0)
                slower.append(p99(await others.during(seconds)) - calm)
                grown.append((world.memory()["hub"] - before) / count)
            # What else the machine does only adds, so the best of a few is the product's own.
            if slower[-1] < SLOWER_MS and grown[-1] < BOUND_MIB:
                break
        findings.figures["MiB for each"].append(min(grown))
        findings.figures["others' p99 later by, ms"].append(min(slower))
        if min(grown) >= BOUND_MIB:
            findings.breach("F16", f"{min(grown):.1f} MiB for one that does not read")
        if min(slower) >= SLOWER_MS:
            findings.breach("F16", f"others' p99 came {min(slower):.1f} ms later")


async def f17(world: World, chance: random.Random, findings: Findings) -> None:
    """A browser that reads slowly gets the newest and stays; a hidden tab loses the lease."""
    async with under_load(world, findings) as run:
        async with flood(world) as pouring, reluctant(world, await world.cookie()) as slow:
            got = await _read_slowly(slow, 2.0 if world.long else 1.0, chance)
            pouring.pouring = False
            said = pouring.said
            while not got or got[-1] != said - 1:
                got += await _read(slow, 10.0)
            findings.counted.update({"texts said": said, "texts taken": len(got)})
            if len(got) >= said:
                findings.breach("F17", "nothing was conflated: the browser was not slow")
        await _hidden(world, run, findings)


async def _read_slowly(slow: ClientConnection, seconds: float, chance: random.Random) -> list[int]:
    """Take a message now and then."""
    got: list[int] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        await asyncio.sleep(chance.uniform(0.2, 0.4))
        got += await _read(slow, 5.0)
    return got


async def _read(slow: ClientConnection, within: float) -> list[int]:
    """Take one message; give the numbers of the texts in it."""
    async with asyncio.timeout(within):
        message = browser.TO_BROWSER.decode(await slow.recv())
    if not isinstance(message, browser.Values):
        return []
    piece = unpack_columns(message)
    return [int(text.split()[0]) for _, text in sorted(piece.texts.items())]


HIDE = """
Object.defineProperty(document, 'visibilityState', {get: () => 'hidden', configurable: true});
Object.defineProperty(document, 'hidden', {get: () => true, configurable: true});
document.dispatchEvent(new Event('visibilitychange'));
"""


async def _hidden(world: World, run: Run, findings: Findings) -> None:
    """Hold a key in a real browser, and hide its tab."""
    from playwright.async_api import async_playwright

    program = find_browser()
    if program is None:
        missing("Chromium")
    async with async_playwright() as play, page(world, "second") as watcher:
        browsing = await play.chromium.launch(**launching(program))
        try:
            tab = await browsing.new_page(viewport={"width": 1280, "height": 900})
            tab.set_default_timeout(PATIENCE_MS)
            dialled: list[str] = []
            tab.on("websocket", lambda socket: dialled.append(socket.url))
            await tab.goto(f"{world.address}/login")
            await tab.get_by_label("Name").fill("driver")
            await tab.get_by_label("Password").fill(PASSWORD)
            await tab.get_by_role("button", name="Sign in", exact=True).click()
            await tab.wait_for_url("**/home")
            await tab.goto(f"{world.address}/sites/{SITE}/drive")
            await tab.get_by_role("button", name="Take control").first.click()
            await tab.get_by_text("You have control").first.wait_for()
            began, sockets_then = now(), len(dialled)
            await tab.keyboard.down("w")
            await until(lambda: any(x.moves for x in world.told(began)), 10, "it drives")
            since, at = len(watcher.got), now()
            await tab.evaluate(HIDE)
            await run.stopped(at)
            await watcher.sees(
                browser.LeaseUpdate, lambda x: x.device == "base" and not x.holder, since=since,
                within=2,
            )  # fmt: skip
            took = (now() - at) / 1e6
            findings.figures["lease free after hiding, ms"].append(took)
            run.nothing_moves_after(at)
            # What a page presses has no ledger; what it did is judged above.
            run.not_ours_until(now())
            if len(dialled) > sockets_then:
                findings.breach("F17", "the hidden tab dialled anew")
        finally:
            await browsing.close()


async def _crowd_of(world: World, gateways: int, people: int) -> tuple[Path, Path]:
    """Enrol gateways and people; give the files of their keys and of their sessions."""
    settings = hub_settings(world)
    database = Database(settings.url)
    registry = SiteRegistry(database, SystemClock())
    keys = world.folder / "crowd-keys"
    keys.write_text("".join([
        f"crowd{each} {await registry.new_key(f'crowd{each}')}\n" for each in range(gateways)
    ]))  # fmt: skip
    await database.close()
    sessions = []
    async with httpx.AsyncClient(
        base_url=world.address, headers={"Origin": world.address}, verify=usual_trust()
    ) as client:
        for each in range(people):
            with contextlib.suppress(HubError):
                await accounts.create_user(settings, f"onlooker{each}", PASSWORD, "guest")
            answer = await client.post(
                "/api/login", json={"name": f"onlooker{each}", "password": PASSWORD}
            )
            answer.raise_for_status()
            sessions.append("; ".join(f"{k}={v}" for k, v in answer.cookies.items()))
            client.cookies.clear()
    cookies = world.folder / "crowd-cookies"
    cookies.write_text("\n".join(sessions))
    return keys, cookies


async def f18(world: World, chance: random.Random, findings: Findings) -> None:
    """All gateways and browsers lose the hub at once and come back, while somebody drives."""
    gateways, pages = (500, 200) if world.long else (30, 10)
    async with under_load(world, findings) as run, page(world, "driver") as driver:
        keys, cookies = await _crowd_of(world, gateways, max(1, pages // 20))
        script = Path(__file__).parent / "crowd.py"
        words = [str(script), str(world.port), str(keys), str(cookies), str(pages)]
        many = Process(words, world.folder / f"crowd-{now()}.log", {})
        try:
            await many.says("all back", within=2 * BACK_S)
            # The fault is that all come at once, and not that there are so many sites.
            before = run.memory_from_now()["hub"]
            await run.press(driver)
            await lasts_for(0.5)
            began = now()
            many.tell("cut")
            await many.says("all back", within=BACK_S, times=2)
            took = float(many.said().splitlines()[-1].split()[-1])
            findings.figures["all back, s"].append(took)
            findings.figures["MiB more"].append(world.memory()["hub"] - before)
            findings.figures["drive p99, ms"].append(p99(run.ages_since(began)))
            findings.counted.update(gateways=gateways, browsers=pages)
            at = now()
            await run.let_go()
            await run.stopped(at)
        except AssertionError as error:
            findings.breach("F18", f"not all are back within {BACK_S:g} s: {error}")
            raise
        finally:
            many.end()
        await sees_values(driver)


__all__ = ["f16", "f17", "f18", "hub_settings"]
