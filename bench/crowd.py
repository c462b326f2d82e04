"""Many gateways in a process of their own, so that only the hub is held up by them.

    crowd.py PORT CERTIFICATE    reads one key a line until an empty one, then words: "cut"

Says "linked" on a line whenever all have their welcome.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import random
import ssl
import sys
import time

import uvloop
import websockets

from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.wire import frames


class Crowd:
    """Many gateways that say hello, answer beats, and dial again as the real one does."""

    def __init__(self, port: int, trust: ssl.SSLContext, keys: list[str]) -> None:
        """Take a key for each; site ``crowdN`` for number N."""
        self._port, self._trust, self._keys = port, trust, keys
        self._sockets: dict[int, websockets.ClientConnection] = {}
        self._tasks = [asyncio.create_task(self._live(each)) for each in range(len(keys))]

    def cut(self) -> None:
        """End all links at one blow."""
        for socket in [*self._sockets.values()]:
            socket.transport.abort()
        self._sockets.clear()

    async def all_back(self) -> None:
        """Wait until all are linked."""
        while len(self._sockets) < len(self._keys):
            await asyncio.sleep(0.05)

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
            f"wss://localhost:{self._port}/gateway/link", ssl=self._trust, compression=None,
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


async def main() -> None:
    """Link all, and cut them when told."""
    # They stand for machines of their own, and must not take this one from hub and gateway.
    os.nice(10)
    trust = ssl.create_default_context(cafile=sys.argv[2])
    trust.check_hostname = False
    words = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(words), sys.stdin
    )
    keys = []
    while key := (await words.readline()).decode().strip():
        keys.append(key)
    many = Crowd(int(sys.argv[1]), trust, keys)
    await many.all_back()
    print("linked", flush=True)
    while await words.readline():
        many.cut()
        await many.all_back()
        print("linked", flush=True)


if __name__ == "__main__":
    uvloop.run(main())
