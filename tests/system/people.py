"""People without a browser: they sign in over HTTP and speak over the socket as the page does."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import AsyncIterator, Callable
from typing import TypeVar

import httpx
import websockets
from patience import PATIENCE_S
from shared_trust import usual_trust
from websockets.asyncio.client import ClientConnection, connect

from talaia.wire import browser
from talaia.wire.columns import unpack_columns
from talaia.wire.frames import LeaseOp

from .stack import PASSWORD, SITE, Stack, until

M = TypeVar("M", bound=browser.ToBrowser)
PERIOD_S = 0.05


async def sign_in(stack: Stack, name: str) -> str:
    """Sign in and give the session's cookie."""
    async with httpx.AsyncClient(
        base_url=stack.address, timeout=30, verify=usual_trust()
    ) as client:
        answer = await client.post(
            "/api/login",
            json={"name": name, "password": PASSWORD},
            headers={"Origin": stack.address},
        )
        answer.raise_for_status()
        return "; ".join(f"{key}={value}" for key, value in client.cookies.items())


def connection(stack: Stack, cookie: str) -> connect:
    """Open the socket that a page opens."""
    return connect(
        f"ws://localhost:{stack.port}/ws",
        compression=None,
        ping_interval=None,
        close_timeout=1,
        additional_headers={"Cookie": cookie},
        origin=stack.address,  # type: ignore[arg-type]
        proxy=None,
    )


class Page:
    """An open page: everything it was sent, and what a person may do there."""

    def __init__(self, socket: ClientConnection, device: str = "base") -> None:
        """Read what comes from now on."""
        self._socket = socket
        self.device = device
        self.got: list[browser.ToBrowser] = []
        self.tick, self.seq, self.epoch = 0, 0, 0
        self.sent: list[browser.PageDrive] = []
        self.last_frame_ns = 0
        self._hold: asyncio.Task[None] | None = None
        self._reader = asyncio.create_task(self._read())

    async def _read(self) -> None:
        with contextlib.suppress(websockets.ConnectionClosed, ConnectionError):
            async for data in self._socket:
                message = browser.TO_BROWSER.decode(data)
                self.got.append(message)
                if isinstance(message, browser.TickUpdate):
                    self.tick = message.tick

    def all(self, kind: type[M]) -> list[M]:
        return [each for each in self.got if isinstance(each, kind)]

    async def sees(
        self, kind: type[M], condition: Callable[[M], object] = lambda _: True, *,
        since: int = 0, within: float = PATIENCE_S,
    ) -> M:  # fmt: skip
        """Wait for a message, from position ``since`` of `got` on, and give it."""

        def matching() -> list[M]:
            return [x for x in self.got[since:] if isinstance(x, kind) and condition(x)]

        try:
            await until(matching, within, f"a {kind.__name__}")
        except AssertionError as error:
            raise AssertionError(f"{error} (last: {self.got[-3:]})") from None
        return matching()[0]

    async def say(self, message: browser.FromBrowser) -> None:
        await self._socket.send(browser.FROM_BROWSER.encode(message))

    async def online(self, site: str = "") -> None:
        """Wait until a site is there; the one that was told of last, unless it is named."""

        def is_online() -> bool:
            told = [
                update for update in self.all(browser.SiteUpdate) if update.site == site or not site
            ]
            return bool(told) and told[-1].online

        await until(is_online, PATIENCE_S, "the site online")

    async def take(self) -> browser.LeaseUpdate:
        """Take the lease; the epoch is kept for the frames to come."""
        since = len(self.got)
        await self.say(browser.PageLease(site=SITE, device=self.device, op=LeaseOp.TAKE))
        news = await self.sees(
            browser.LeaseUpdate, lambda x: x.device == self.device and (x.yours or x.refused),
            since=since,
        )  # fmt: skip
        if news.yours:
            self.epoch, self.seq = news.epoch, 0
            await self.sees(browser.TickUpdate, since=since)
        return news

    async def frame(self, linear: float, angular: float = 0.0) -> None:
        """Send one driving frame."""
        self.seq += 1
        frame = browser.PageDrive(
            site=SITE, device=self.device, epoch=self.epoch, seq=self.seq, tick=self.tick,
            linear=linear, angular=angular,
        )  # fmt: skip
        self.sent.append(frame)
        self.last_frame_ns = time.monotonic_ns()
        await self.say(frame)

    def press(self, linear: float, angular: float = 0.0) -> None:
        """Hold a direction: frames at 20 Hz, the lease renewed each second."""

        async def hold() -> None:
            turn = 0
            with contextlib.suppress(websockets.ConnectionClosed, ConnectionError):
                while True:
                    await self.frame(linear, angular)
                    turn += 1
                    if turn % 20 == 0:
                        renew = browser.PageLease(site=SITE, device=self.device, op=LeaseOp.RENEW)
                        await self.say(renew)
                    await asyncio.sleep(PERIOD_S)

        self._hold = asyncio.create_task(hold())

    async def vanish(self) -> None:
        """Send nothing more, without a word: the person, or their network, is gone."""
        if self._hold is not None:
            self._hold.cancel()
            await asyncio.gather(self._hold, return_exceptions=True)
            self._hold = None

    async def let_go(self) -> None:
        """End the hold as a page does: three zeros."""
        await self.vanish()
        for _ in range(3):
            await self.frame(0.0)

    async def free(self) -> None:
        """Give the lease back and wait until that is so."""
        since = len(self.got)
        await self.say(browser.PageLease(site=SITE, device=self.device, op=LeaseOp.FREE))
        await self.sees(browser.LeaseUpdate, lambda x: not x.holder, since=since)

    async def subscribe(self, *channels: str) -> browser.Subscribed:
        since = len(self.got)
        await self.say(browser.Subscribe(sub=1, site=SITE, channels=list(channels), every_ms=0))
        return await self.sees(browser.Subscribed, since=since)

    def values(self) -> list[float]:
        """Every number that came, of all subscriptions."""
        return [
            float(value)
            for each in self.all(browser.Values)
            for value in unpack_columns(each).value
        ]

    async def close(self) -> None:
        await self.vanish()
        self._reader.cancel()
        await asyncio.gather(self._reader, return_exceptions=True)


@contextlib.asynccontextmanager
async def page(
    stack: Stack, name: str, *, cookie: str = "", device: str = "base"
) -> AsyncIterator[Page]:
    """Open a page for somebody; the site is online when this gives it."""
    cookie = cookie or await sign_in(stack, name)
    async with connection(stack, cookie) as socket:
        opened = Page(socket, device)
        try:
            await opened.online(stack.one_of_many)
            yield opened
        finally:
            await opened.close()


class Guest:
    """A guest's page that is always open, in a thread of its own, and keeps all it is sent."""

    def __init__(self, stack: Stack) -> None:
        """Begin to visit."""
        self._stack = stack
        self.got: list[browser.ToBrowser] = []
        self.pages = 0
        self._loop = asyncio.new_event_loop()
        self._task: asyncio.Task[None] | None = None
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        with (
            asyncio.Runner(loop_factory=lambda: self._loop) as runner,
            contextlib.suppress(asyncio.CancelledError),
        ):
            runner.run(self._stay())

    async def _stay(self) -> None:
        self._task = asyncio.current_task()
        while True:
            with contextlib.suppress(OSError, httpx.HTTPError, websockets.WebSocketException):
                await self._visit(await sign_in(self._stack, "guest"))
            await asyncio.sleep(PERIOD_S)

    async def _visit(self, cookie: str) -> None:
        async with connection(self._stack, cookie) as socket:
            self.pages += 1
            asked = False
            async for data in socket:
                message = browser.TO_BROWSER.decode(data)
                self.got.append(message)
                if isinstance(message, browser.SiteUpdate) and message.online and not asked:
                    asked = True
                    for each in self._asks():
                        await socket.send(browser.FROM_BROWSER.encode(each))

    def _asks(self) -> list[browser.FromBrowser]:
        """Ask for one channel that is public, one that is not, and for all that moves a robot."""
        name = f"guest-{self.pages}"
        return [
            browser.Subscribe(sub=1, site=SITE, channels=["base/open", "base/count"]),
            browser.PageLease(site=SITE, device="base", op=LeaseOp.TAKE),
            browser.PageDrive(
                site=SITE, device="base", epoch=1, seq=1, tick=1, linear=1.0, angular=0.0
            ),
            browser.PageStop(site=SITE, device="base", id=name),
            browser.PageReset(site=SITE, device="base", epoch=1),
            browser.PageCommand(site=SITE, device="base", command="none", id=name),
        ]

    def close(self) -> None:
        if self._task is not None:
            self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(10)
