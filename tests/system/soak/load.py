"""People who come and go, drive, command, ask for history; and a network and machines that fail."""

from __future__ import annotations

import asyncio
import random
import signal
import time
from collections import Counter
from collections.abc import Awaitable, Callable

import httpx
import websockets
from patience import lasts_for
from shared_trust import usual_trust

from talaia.wire import browser

from ..faults.doing import sees_values
from ..faults.weather import CALM, Way, Weather
from ..faults.world import World
from ..people import Page, page, sign_in
from ..stack import SITE
from .measure import Measure

__all__ = ["Load"]

CHANNELS = ("base/count", "base/open", "base/still", "base/wheel1")
# How long somebody goes on with one session (s).
SESSION_S = 600.0
HOUR_US = 3_600_000_000
WEATHERS = (
    Weather(delay_ms=40, jitter_ms=40),
    Weather(split=0.3, duplicate=0.02, reorder=0.02),
    Weather(rate=30_000),
    Weather(dark=frozenset(Way)),
    Weather(dark=frozenset({Way.UP})),
)
EXPECTED = (
    AssertionError, ConnectionError, OSError, TimeoutError, httpx.HTTPError,
    websockets.WebSocketException,
)  # fmt: skip


class Load:
    """All that happens to one world, until it is cancelled.

    Attributes:
        done: how often what was done.
        killing: somebody is killed just now, and not ready again.
        errors: what must not be: questions that a running hub answers with an error, and processes
            that ended by themselves.

    """

    def __init__(self, world: World, measure: Measure, chance: random.Random) -> None:
        """Decide by ``chance`` what happens when."""
        self.done: Counter[str] = Counter()
        self.errors: list[str] = []
        self.lives = {"hub": 0, "gateway": 0}
        self.ready_at = {"hub": time.monotonic(), "gateway": time.monotonic()}
        self._world, self._measure, self._chance = world, measure, chance
        self._cookies: dict[str, tuple[float, str]] = {}
        self.killing = False
        self._began_us = time.time_ns() // 1000

    async def run(self, kills_at: list[tuple[float, str]]) -> None:
        """Load the world for good; kills: moments (s from now) and whom."""
        self._world.robot.tell("count 20")
        async with asyncio.TaskGroup() as group:
            for each in (
                self._visit, self._visit, self._command, self._drive, self._ask, self._alarm,
                self._disturb, self._freeze,
            ):  # fmt: skip
                group.create_task(self._again(each))
            group.create_task(self._kill(kills_at))
            group.create_task(self._watch())

    async def _again(self, work: Callable[[], Awaitable[None]]) -> None:
        name = work.__name__.strip("_")
        while True:
            try:
                await work()
                self.done[name] += 1
            except EXPECTED:
                # A fault came between.
                self.done[f"{name}, cut short"] += 1
                await asyncio.sleep(2)

    async def _pause(self, least: float, most: float) -> None:
        await lasts_for(self._chance.uniform(least, most))

    async def _cookie(self, name: str) -> str:
        until, cookie = self._cookies.get(name, (0.0, ""))
        if time.monotonic() > until:
            cookie = await sign_in(self._world, name)
            self._cookies[name] = time.monotonic() + SESSION_S, cookie
            self.done["sign-ins"] += 1
        return cookie

    # ── people ──

    async def _visit(self) -> None:
        name = self._chance.choice(("second", "driver", "guest"))
        some = self._chance.sample(CHANNELS, self._chance.randint(1, len(CHANNELS)))
        async with page(self._world, name, cookie=await self._cookie(name)) as opened:
            await opened.subscribe(*some)
            if self._chance.random() < 0.5 and name != "guest":
                await sees_values(opened)
            await self._pause(10, 40)
            await opened.say(browser.Unsubscribe(sub=1))
        await self._pause(2, 10)

    async def _command(self) -> None:
        async with page(self._world, "second", cookie=await self._cookie("second")) as opened:
            for _ in range(10):
                await self._send_command(opened)
                await self._pause(2, 6)

    async def _send_command(self, opened: Page) -> None:
        self.done["commands"] += 1
        name = f"soak-{time.monotonic_ns()}"
        which = self._chance.choice(("mark", "mark", "work"))
        value = float(self.done["commands"])
        ask = browser.PageCommand(
            site=SITE, device="base", command=which, id=name,
            args={"value": value} if which == "mark" else {},
        )  # fmt: skip
        await opened.say(ask)
        # As a nervous finger does.
        await opened.say(ask)

    async def _drive(self) -> None:
        async with page(self._world, "driver", cookie=await self._cookie("driver")) as opened:
            if (await opened.take()).yours:
                opened.press(0.2)
                await self._pause(2, 6)
                if self._chance.random() < 0.3:
                    # The browser is gone in the middle of it.
                    await opened.vanish()
                else:
                    await opened.let_go()
                    await opened.free()
        await self._pause(20, 60)

    async def _ask(self) -> None:
        cookie = await self._cookie("second")
        now_us = time.time_ns() // 1000
        from_us = now_us - self._chance.choice((60_000_000, HOUR_US // 4, HOUR_US, 24 * HOUR_US))
        window: dict[str, str | int] = {
            "channel": self._chance.choice(CHANNELS), "from_us": from_us, "to_us": now_us
        }  # fmt: skip
        path, query = self._chance.choice(
            (
                ("history", {**window, "width": 800}),
                ("history", {**window, "width": 3}),
                ("statistics", window),
                ("outliers", window),
                ("last", {"channel": window["channel"], "before_us": from_us}),
                ("events", {}),
                ("alarms", {}),
                ("stored", window),
            )
        )
        async with httpx.AsyncClient(
            base_url=self._world.address,
            headers={"Cookie": cookie},
            timeout=30,
            verify=usual_trust(),
        ) as client:
            answer = await client.get(f"/api/sites/{SITE}/{path}", params=query)
        self.done[f"asked {path}: {answer.status_code}"] += 1
        if answer.status_code == httpx.codes.UNAUTHORIZED:
            self._cookies.clear()
        elif answer.is_error and not self.killing:
            self.errors.append(f"{path} answered {answer.status_code}: {answer.text[:200]}")
        await self._pause(3, 9)

    async def _alarm(self) -> None:
        for speed in (1, 9):
            await self._pause(10, 40)
            self._world.robot.tell(f"metric {{'name': 'wheel1', 'magnitude': {speed}}}")

    # ── faults ──

    async def _disturb(self) -> None:
        await self._pause(30, 120)
        if self._chance.random() < 0.3:
            self._world.proxy.cut()
        elif self._chance.random() < 0.1:
            self._world.proxy.half_close(self._chance.choice(list(Way)))
        else:
            self._world.proxy.change(self._chance.choice(WEATHERS))
            try:
                await self._pause(2, 15)
            finally:
                self._world.proxy.change(CALM)
        self._world.proxy.forget()

    async def _freeze(self) -> None:
        await self._pause(300, 600)
        part = self._chance.choice((self._world.hub, self._world.gateway))
        if part.popen.poll() is None:
            part.popen.send_signal(signal.SIGSTOP)
            try:
                await self._pause(1, 5)
            finally:
                part.popen.send_signal(signal.SIGCONT)

    async def _kill(self, kills_at: list[tuple[float, str]]) -> None:
        began = time.monotonic()
        for moment, whom in kills_at:
            await asyncio.sleep(max(0.0, began + moment - time.monotonic()))
            self.killing = True
            self._measure.remember_segments()
            # What is seen from here on is of the next life, which warms up.
            self.lives[whom] += 1
            self.ready_at[whom] = time.monotonic()
            if whom == "hub":
                self._world.hub.kill()
                self._world.start_hub()
                await self._world.hub.says("ready")
            else:
                self._world.gateway.kill()
                self._world.start_gateway()
                await self._world.gateway.says("linked to")
            self.ready_at[whom] = time.monotonic()
            self.done[f"kills of the {whom}"] += 1
            self.killing = False

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(1)
            for name in ("hub", "gateway", "robot"):
                part = getattr(self._world, name)
                if part.popen.poll() is not None and not self.killing:
                    self.errors.append(f"the {name} ended: {part.said()[-500:]}")
                    raise RuntimeError(self.errors[-1])
