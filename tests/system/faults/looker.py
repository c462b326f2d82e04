"""I8: a page that is open all the time, and what it shows beside what the hub says elsewhere."""

from __future__ import annotations

import asyncio
import contextlib
import time
from typing import TYPE_CHECKING, NamedTuple

import httpx
import websockets

from talaia.wire import browser
from talaia.wire.columns import unpack_columns

from ..people import connection, sign_in
from ..stack import SITE

if TYPE_CHECKING:
    from .world import World

__all__ = ["ALARM", "COUNT", "DOOR", "LIMIT", "Looker", "differences"]

COUNT, DOOR, ALARM = "base/count", "base/door", "door_open"
# Above this the alarm is to be on.
LIMIT = 5.0
_SUB = 9


class Shown(NamedTuple):
    """A value as a page has it: its time (µs), and how old it was when it came (ms)."""

    value: float
    time_us: int
    age_ms: float


class Looker:
    """Looks on, comes back whenever the hub does, and asks again until it is answered."""

    def __init__(self, world: World) -> None:
        """Begin to look."""
        self._world = world
        self.shown: dict[str, Shown] = {}
        self.alarm = ""
        self._task = asyncio.create_task(self._stay())

    async def _stay(self) -> None:
        cookie = ""
        while True:
            with contextlib.suppress(OSError, httpx.HTTPError, websockets.WebSocketException):
                # A session outlives its hub, as a page's does; to sign in anew costs the hub more
                # than all else that is looked at.
                cookie = cookie or await sign_in(self._world, "second")
                try:
                    async with connection(self._world, cookie) as socket:
                        await self._look(socket)
                except websockets.InvalidStatus:
                    cookie = ""
            await asyncio.sleep(0.1)

    async def _look(self, socket: websockets.ClientConnection) -> None:
        """Show nothing that this connection was not told."""
        self.shown, self.alarm = {}, ""
        taken, asked = False, 0.0
        while True:
            if not taken and time.monotonic() - asked > 1.0:
                asked = time.monotonic()
                wish = browser.Subscribe(sub=_SUB, site=SITE, channels=[COUNT, DOOR], every_ms=0)
                await socket.send(browser.FROM_BROWSER.encode(wish))
            try:
                # Not `wait_for`: in Python 3.11 it may swallow the end of the one who looks.
                async with asyncio.timeout(0.5):
                    data = await socket.recv()
            except TimeoutError:
                continue
            message = browser.TO_BROWSER.decode(data)
            if isinstance(message, browser.Subscribed):
                taken = taken or message.sub == _SUB
            elif isinstance(message, browser.AlarmUpdate) and message.alarm == ALARM:
                self.alarm = message.phase if message.known else "unknown"
            elif isinstance(message, browser.Values) and message.sub == _SUB:
                self._take(message)

    def _take(self, message: browser.Values) -> None:
        columns = unpack_columns(message)
        ages = message.age_ms or [0.0] * len(columns)
        rows = zip(
            columns.channel.tolist(), columns.value.tolist(), columns.time_us.tolist(), ages,
            strict=True,
        )  # fmt: skip
        for channel, value, time_us, age in rows:
            self.shown[(COUNT, DOOR)[channel]] = Shown(value, time_us, age)

    async def end(self) -> None:
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)


def differences(
    shown: dict[str, Shown],
    alarm: str,
    last: dict[str, tuple[float, int]],
    history: dict[str, tuple[float, int]],
    expected: dict[str, float],
) -> list[str]:
    """I8: say where page, alarm, last-value API and history do not agree. Pure.

    Args:
        shown: what the page shows.
        alarm: how it shows the alarm on the door.
        last: values and times as the API has them.
        history: the last of each series.
        expected: what the robot said last, where a gateway heard it.

    """
    found = []
    for address in (COUNT, DOOR):
        page = shown.get(address)
        told = None if page is None else (page.value, page.time_us)
        if not told == last.get(address) == history.get(address):
            found.append(
                f"{address}: the page shows {told}, the API {last.get(address)}, "
                f"the history {history.get(address)}"
            )
        elif address in expected and (told is None or told[0] != expected[address]):
            found.append(f"{address}: all show {told}, the robot said {expected[address]}")
    door = shown.get(DOOR)
    if door is not None and (alarm in {"active", "acknowledged"}) != (door.value > LIMIT):
        found.append(f"the door is at {door.value}, and its alarm is {alarm or 'not told'}")
    return found
