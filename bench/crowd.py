"""Many gateways in a process of their own, so that only the hub is held up by them.

    crowd.py PORTS CERTIFICATE SIGNALS    reads one key a line until an empty one, then words

PORTS are of one hub, or with commas between of several, which each dials in turn; CERTIFICATE is
"-" for hubs without TLS. Each has so many signals and sends a sample of each once a second. Says
"linked" on a line whenever all have their welcome, and "kept" after that, once a batch of each was
acknowledged. Words are "sent", which is answered by how many samples were sent so far; "cut", which
ends all links; and "lost", behind which a hub is killed: once each is linked again, a list of how
long that took each (s, JSON) comes before "linked".
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import random
import ssl
import sys
import time

import numpy as np
import uvloop
import websockets

from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.wire import frames
from talaia.wire.columns import Columns, pack_columns

_SIGNAL = "{{name: Number {0}, source: {{topic: /n{0}, type: std_msgs/msg/Float64, field: data}}}}"
# The hub may acknowledge late; what waits longer than so many batches is not kept here.
_MOST_WAITING = 60


def describe(site: str, signals: int) -> str:
    """Write a description of so many signals."""
    head = f"talaia: 1\nsite: {site}\nname: {site}\nros2: {{}}\ndevices:\n  hut:\n    name: Hut\n"
    rows = [f"      n{each}: {_SIGNAL.format(each)}\n" for each in range(signals)]
    return head + ("    signals:\n" + "".join(rows) if rows else "")


class Crowd:
    """Many gateways that say hello, send, answer beats, and dial again as the real one does."""

    def __init__(
        self, ports: list[int], trust: ssl.SSLContext | None, keys: list[str], signals: int
    ) -> None:
        """Take a key for each; site ``crowdN`` for number N."""
        self._ports, self._trust, self._keys, self._signals = ports, trust, keys, signals
        # By number: how often it has dialled, and when it was welcomed last (monotonic, s).
        self._dials = [*range(len(keys))]
        self._welcomed = [0.0] * len(keys)
        self.sent = 0
        self._sockets: dict[int, websockets.ClientConnection] = {}
        self._next = [0] * len(keys)
        self._acked = [0] * len(keys)
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

    async def all_again(self) -> list[float]:
        """Wait until each was linked once more from now on; give after how long (s)."""
        began = time.monotonic()
        while min(self._welcomed) < began:
            await asyncio.sleep(0.05)
        return [at - began for at in self._welcomed]

    async def all_kept(self) -> None:
        """Wait until of each a batch was acknowledged that was sent from now on."""
        before = [*self._next]
        while self._signals and any(a <= b for a, b in zip(self._acked, before, strict=True)):
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
        site, scheme = f"crowd{number}", "wss" if self._trust else "ws"
        port = self._ports[self._dials[number] % len(self._ports)]
        self._dials[number] += 1
        async with websockets.connect(
            f"{scheme}://localhost:{port}/gateway/link", ssl=self._trust, compression=None,
            ping_interval=None, proxy=None,
            additional_headers={"Authorization": f"Bearer {self._keys[number]}"},
        ) as socket:  # fmt: skip
            text = describe(site, self._signals)
            hello = frames.Hello(site=site, boot="b", catalogue="c", description=text)
            await socket.send(frames.LINK_FROM_GATEWAY.encode(hello))
            sending: asyncio.Task[None] | None = None
            try:
                async for data in socket:
                    message = frames.LINK_FROM_HUB.decode(data)
                    if isinstance(message, frames.Welcome):
                        self._sockets[number] = socket
                        self._welcomed[number] = time.monotonic()
                        # What was not acknowledged is taken for sent again: it is the same work.
                        self._next[number] = self._acked[number] = message.acked
                        sending = asyncio.create_task(self._send(number, socket))
                    elif isinstance(message, frames.Ack):
                        self._acked[number] = message.below
                    elif isinstance(message, frames.Beat):
                        reply = reply_to(message, time.monotonic_ns())
                        await socket.send(frames.LINK_FROM_GATEWAY.encode(reply))
            finally:
                if sending is not None:
                    sending.cancel()
                if socket.close_reason:
                    print(f"{site}: {socket.close_reason}", file=sys.stderr, flush=True)

    async def _send(self, number: int, socket: websockets.ClientConnection) -> None:
        count = self._signals
        if not count:
            return
        addresses = np.arange(count, dtype=np.uint16)
        chance = np.random.default_rng(number)
        # Not all at the same moment of each second.
        await asyncio.sleep(float(chance.random()))
        with contextlib.suppress(OSError, websockets.WebSocketException):
            while True:
                if self._next[number] - self._acked[number] < _MOST_WAITING * count:
                    times = np.full(count, time.time_ns() // 1000, np.int64)
                    columns = Columns(addresses, times, chance.normal(20.0, 1.0, count), {})
                    batch = frames.SampleBatch(
                        boot="b", first=self._next[number], catalogue="c", live=True,
                        **pack_columns(columns)._asdict(),
                    )  # fmt: skip
                    self._next[number] += count
                    self.sent += count
                    await socket.send(frames.LINK_FROM_GATEWAY.encode(batch))
                await asyncio.sleep(1.0)


async def main() -> None:
    """Link all, and cut them when told."""
    # They stand for machines of their own, and must not take this one from hub and gateway.
    os.nice(10)
    trust = None
    if sys.argv[2] != "-":
        trust = ssl.create_default_context(cafile=sys.argv[2])
        trust.check_hostname = False
    words = asyncio.StreamReader()
    await asyncio.get_running_loop().connect_read_pipe(
        lambda: asyncio.StreamReaderProtocol(words), sys.stdin
    )
    keys = []
    while key := (await words.readline()).decode().strip():
        keys.append(key)
    ports = [int(port) for port in sys.argv[1].split(",")]
    many = Crowd(ports, trust, keys, int(sys.argv[3]))
    while True:
        await many.all_back()
        print("linked", flush=True)
        await many.all_kept()
        print("kept", flush=True)
        while (word := (await words.readline()).decode().strip()) == "sent":
            print(many.sent, flush=True)
        if not word:
            return
        if word == "lost":
            print(json.dumps(await many.all_again()), flush=True)
        else:
            many.cut()


if __name__ == "__main__":
    uvloop.run(main())
