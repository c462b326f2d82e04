"""Many gateways and pages at one hub, as a process of its own so that it is in nobody's way.

    python crowd.py PORT KEYS COOKIES PAGES

KEYS holds a line ``SITE KEY`` for each gateway, COOKIES one session a line, shared out among so
many pages. Says ``all back SECONDS`` whenever all are connected; on the line ``cut`` every
connection is reset, and each comes back as the real ones do.
"""

from __future__ import annotations

import asyncio
import contextlib
import random
import sys
import time
from collections.abc import Callable
from pathlib import Path

from websockets import WebSocketException
from websockets.asyncio.client import ClientConnection, connect

from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.wire import browser, frames


class Crowd:
    """All of them."""

    def __init__(self, port: int, keys: list[tuple[str, str]], cookies: list[str]) -> None:
        """Let them dial."""
        self._port = port
        self._sockets: dict[str, ClientConnection] = {}
        self._whole = asyncio.Event()
        self.size = len(keys) + len(cookies)
        self._tasks = [
            asyncio.create_task(self._stay(site, self._gateway(site, key))) for site, key in keys
        ] + [
            asyncio.create_task(self._stay(f"page {number}", self._page(number, cookie)))
            for number, cookie in enumerate(cookies)
        ]

    async def all_back(self) -> float:
        began = time.monotonic()
        await self._whole.wait()
        return time.monotonic() - began

    def _came(self, name: str, socket: ClientConnection) -> None:
        self._sockets[name] = socket
        if len(self._sockets) >= self.size:
            self._whole.set()

    def cut(self) -> None:
        self._whole.clear()
        for socket in [*self._sockets.values()]:
            socket.transport.abort()
        self._sockets.clear()

    async def _stay(self, name: str, kind: _Kind) -> None:
        backoff = Backoff(random.SystemRandom().random)
        while True:
            began = time.monotonic()
            with contextlib.suppress(OSError, TimeoutError, WebSocketException):
                await kind.once(lambda socket: self._came(name, socket))
            self._sockets.pop(name, None)
            await asyncio.sleep(backoff.after(time.monotonic() - began))

    def _gateway(self, site: str, key: str) -> _Kind:
        return _Gateway(
            f"ws://127.0.0.1:{self._port}/gateway/link", {"Authorization": f"Bearer {key}"}, site
        )

    def _page(self, number: int, cookie: str) -> _Kind:
        return _Page(f"ws://localhost:{self._port}/ws", {"Cookie": cookie}, str(number))


class _Kind:
    """One kind of peer."""

    origin: str | None = None

    def __init__(self, url: str, headers: dict[str, str], name: str) -> None:
        self._url, self._headers, self.name = url, headers, name

    async def once(self, came: Callable[[ClientConnection], None]) -> None:
        """Connect, say so, and stay until it is lost; each kind of peer in its own way."""

    def dial(self, origin: str | None = None) -> connect:
        return connect(
            self._url, compression=None, ping_interval=None, proxy=None, close_timeout=1,
            additional_headers=self._headers, origin=origin,  # type: ignore[arg-type]
        )  # fmt: skip


class _Gateway(_Kind):
    async def once(self, came: Callable[[ClientConnection], None]) -> None:
        async with self.dial() as socket:
            await socket.send(hello(self.name))
            async for data in socket:
                message = frames.LINK_FROM_HUB.decode(data)
                if isinstance(message, frames.Welcome):
                    came(socket)
                elif isinstance(message, frames.Beat):
                    reply = reply_to(message, time.monotonic_ns())
                    await socket.send(frames.LINK_FROM_GATEWAY.encode(reply))


class _Page(_Kind):
    async def once(self, came: Callable[[ClientConnection], None]) -> None:
        origin = self._url.replace("ws://", "http://").removesuffix("/ws")
        async with self.dial(origin) as socket:
            async for data in socket:
                if isinstance(browser.TO_BROWSER.decode(data), browser.Greeting):
                    came(socket)


def hello(site: str, devices: str = "{hut: {name: Hut}}") -> bytes:
    """Give the first frame of a gateway."""
    text = f"talaia: 1\nsite: {site}\nname: {site}\nros2: {{}}\ndevices: {devices}\n"
    first = frames.Hello(site=site, boot=f"{time.time_ns():x}", catalogue="c", description=text)
    return frames.LINK_FROM_GATEWAY.encode(first)


async def main(port: int, keys: list[str], sessions: list[str], pages: int) -> None:
    """Stay until stdin ends."""
    crowd = Crowd(
        port,
        [(site, key) for site, key in map(str.split, keys)],
        [sessions[each % len(sessions)] for each in range(pages)],
    )
    while True:
        sys.stdout.write(f"all back {await crowd.all_back():.3f}\n")
        sys.stdout.flush()
        if not await asyncio.to_thread(sys.stdin.readline):
            return
        crowd.cut()


if __name__ == "__main__":
    given = [Path(each).read_text().splitlines() for each in sys.argv[2:4]]
    asyncio.run(main(int(sys.argv[1]), *given, int(sys.argv[4])))
