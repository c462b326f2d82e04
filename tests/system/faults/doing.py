"""What many rows do: wait a little, see values again, measure how old they come."""

from __future__ import annotations

import asyncio
import contextlib
import random
import time
from collections.abc import AsyncIterator

import websockets
from patience import lasts_for

from talaia.wire import browser
from talaia.wire.columns import unpack_columns

from ..people import Page, connection
from . import ledgers
from .ledgers import MS, Findings
from .looker import COUNT
from .world import SITE, World, now


async def pause(chance: random.Random, least: float = 0.1, most: float = 0.5) -> None:
    await lasts_for(chance.uniform(least, most))


@contextlib.asynccontextmanager
async def back(findings: Findings, within_s: float = ledgers.BACK_S) -> AsyncIterator[None]:
    """I7: what is done inside is over within the bound after the fault's end."""
    began = time.monotonic()
    try:
        yield
    except AssertionError as error:
        findings.breach("I7", str(error))
        raise
    took = time.monotonic() - began
    findings.back_s.append(took)
    if took > within_s:
        findings.breach("I7", f"back only after {took:.1f} s")


async def sees_values(by: Page) -> None:
    """Wait until values arrive on a fresh subscription; one that is refused is asked for anew."""
    since, asked = len(by.got), 0.0

    def seen() -> bool:
        return any(
            isinstance(x, browser.Values) and x.sub == 2 and not x.age_ms for x in by.got[since:]
        )

    ends = time.monotonic() + ledgers.BACK_S
    while not seen():
        assert time.monotonic() < ends, f"no values within {ledgers.BACK_S:g} s: {by.got[-3:]}"
        if time.monotonic() - asked > 1.0:
            asked = time.monotonic()
            await by.say(browser.Subscribe(sub=2, site=SITE, channels=["base/still"], every_ms=0))
        await asyncio.sleep(0.01)


class Ages:
    """How old the robot's counts are when a page gets them (ms)."""

    def __init__(self, world: World) -> None:
        """Begin with none."""
        self._world = world
        self._got: list[tuple[int, int]] = []

    async def read(self, cookie: str) -> None:
        async with connection(self._world, cookie) as socket:
            asked = browser.Subscribe(sub=1, site=SITE, channels=[COUNT], every_ms=0)
            await socket.send(browser.FROM_BROWSER.encode(asked))
            async for data in socket:
                message = browser.TO_BROWSER.decode(data)
                if isinstance(message, browser.Values) and not message.age_ms:
                    at = now()
                    columns = unpack_columns(message)
                    self._got += [(at, int(value)) for value in columns.value]

    async def during(self, seconds: float) -> list[float]:
        """Give the ages of what comes in so many seconds."""
        self._got.clear()
        await lasts_for(seconds)
        got = list(self._got)
        said = {each.value: each.at for each in self._world.said()}
        return [(at - said[value]) / MS for at, value in got if value in said]


@contextlib.asynccontextmanager
async def ages(world: World) -> AsyncIterator[Ages]:
    """Look on from a page of its own."""
    looking = Ages(world)
    cookie = await world.cookie()

    async def read() -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            await looking.read(cookie)

    task = asyncio.create_task(read())
    try:
        yield looking
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def p99(values: list[float]) -> float:
    """Give the 99th of a hundred; infinite when there are none."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, round(len(ordered) * 0.99))] if ordered else float("inf")
