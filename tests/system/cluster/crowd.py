"""Many gateways and pages before several hubs, in a process of their own; each keeps its ledger.

    python -m system.cluster.crowd PORT KEYS COOKIE PAGES

KEYS holds a line ``SITE KEY`` for each gateway; the pages have one session, and each looks at the
site of one gateway. A gateway numbers its samples from 0, keeps what is not acknowledged, and sends
it again after a loss. Words on stdin: ``spread`` lets all dial anew, so that each hub has some, and
is answered by ``spread``; ``fault`` begins to measure how long each hears nothing; ``report`` is
answered by a line of JSON once no gateway has anything unacknowledged; the end of stdin ends all.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import random
import sys
import time
from collections import deque
from collections.abc import Awaitable, Callable
from pathlib import Path

import numpy as np
import uvloop
from websockets import WebSocketException
from websockets.asyncio.client import ClientConnection, connect

from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns, unpack_columns

# Between two samples of a gateway (s).
PERIOD_S = 0.5
ADDRESS = "hut/number"
DESCRIPTION = """\
talaia: 1
site: {site}
name: {site}
ros2: {{}}
recording: {{before: 20}}
devices:
  hut:
    name: Hut
    signals:
      number: {{name: Number, source: {{topic: /n, type: std_msgs/msg/Float64, field: data}}}}
"""
# What one batch holds at most when much is sent again.
_BATCH = 500
_LOSSES = (OSError, TimeoutError, WebSocketException)


class Silence:
    """How long one of them heard nothing from any hub, at the longest since a fault began (s)."""

    def __init__(self) -> None:
        """Begin before anything is heard."""
        self._heard_s = time.monotonic()
        self._longest_s = 0.0

    def begin_fault(self) -> None:
        """Measure from now on."""
        self._heard_s, self._longest_s = time.monotonic(), 0.0

    def hear(self) -> None:
        """Note that a hub says something."""
        self._longest_s = self.longest_s
        self._heard_s = time.monotonic()

    @property
    def longest_s(self) -> float:
        """Up to now, also while it lasts."""
        return max(self._longest_s, time.monotonic() - self._heard_s)


async def _stay_linked(link: Callable[[], Awaitable[None]]) -> None:
    """Dial whenever the link is lost, as a gateway does."""
    backoff = Backoff(random.SystemRandom().random)
    while True:
        began = time.monotonic()
        with contextlib.suppress(*_LOSSES):
            await link()
        await asyncio.sleep(backoff.after(time.monotonic() - began))


class NumberedGateway:
    """A gateway whose samples are their own numbers."""

    def __init__(self, address: str, site: str, key: str) -> None:
        """Dial ``address`` when it is run."""
        self._address, self.site = address, site
        self._headers = {"Authorization": f"Bearer {key}"}
        self._boot = f"{time.time_ns():x}"
        self._kept: deque[tuple[int, int]] = deque()
        self.next = self.acked = self.links = 0
        self.silence = Silence()
        self.socket: ClientConnection | None = None

    async def run(self) -> None:
        """Stay linked, for ever."""
        await _stay_linked(self._link)

    async def count(self) -> None:
        """Take a sample every period, linked or not, for ever."""
        # Not all of them at the same moment.
        pause_s = random.SystemRandom().random() * PERIOD_S
        while True:
            await asyncio.sleep(pause_s)
            self._kept.append((self.next, time.time_ns() // 1000))
            self.next += 1
            self._news.set()
            pause_s = PERIOD_S

    async def _link(self) -> None:
        async with connect(
            f"{self._address}/gateway/link", compression=None, ping_interval=None, proxy=None,
            close_timeout=1, additional_headers=self._headers,
        ) as socket:  # fmt: skip
            text = DESCRIPTION.format(site=self.site)
            hello = frames.Hello(site=self.site, boot=self._boot, catalogue="c", description=text)
            await socket.send(frames.LINK_FROM_GATEWAY.encode(hello))
            sending: asyncio.Task[None] | None = None
            try:
                async for data in socket:
                    message = frames.LINK_FROM_HUB.decode(data)
                    # A beat each second, at the least; a refusal is no sign of life.
                    self.silence.hear()
                    if isinstance(message, frames.Welcome):
                        self.links += 1
                        self.socket = socket
                        self._forget(message.acked)
                        sending = asyncio.create_task(self._send(socket))
                    elif isinstance(message, frames.Beat):
                        reply = reply_to(message, time.monotonic_ns())
                        await socket.send(frames.LINK_FROM_GATEWAY.encode(reply))
                    elif isinstance(message, frames.Ack) and message.boot == self._boot:
                        self._forget(message.below)
                    elif isinstance(message, frames.ResendRequest):
                        await self._send_rows(socket, message.first, message.below)
            finally:
                self.socket = None
                if sending is not None:
                    sending.cancel()

    async def _send(self, socket: ClientConnection) -> None:
        """Send what is kept, then each sample when it is taken."""
        sent = self.acked
        with contextlib.suppress(*_LOSSES):
            while True:
                self._news.clear()
                await self._send_rows(socket, sent, self.next)
                sent = max(sent, self.next)
                await self._news.wait()

    async def _send_rows(self, socket: ClientConnection, first: int, below: int) -> None:
        rows = [row for row in self._kept if first <= row[0] < below]
        for at in range(0, len(rows), _BATCH):
            some = rows[at : at + _BATCH]
            columns = Columns(
                np.zeros(len(some), np.uint16),
                np.array([time_us for _, time_us in some], np.int64),
                np.array([float(number) for number, _ in some]),
                {},
            )
            batch = frames.SampleBatch(
                boot=self._boot, first=some[0][0], catalogue="c", live=len(rows) == 1,
                **pack_columns(columns)._asdict(),
            )  # fmt: skip
            await socket.send(frames.LINK_FROM_GATEWAY.encode(batch))

    def _forget(self, below: int) -> None:
        # What is not kept any more was acknowledged: the judge asks for each of them.
        self.acked = max(self.acked, below)
        while self._kept and self._kept[0][0] < self.acked:
            self._kept.popleft()

    @property
    def settled(self) -> bool:
        """Whether all but what was taken just now is acknowledged."""
        return self.acked >= self.next - 1 and self.links > 0

    async def start(self) -> None:
        """Count and stay linked."""
        self._news = asyncio.Event()
        await asyncio.gather(self.run(), self.count())


class Onlooker:
    """A page that looks at one site, and comes again whenever its socket is closed."""

    def __init__(self, address: str, cookie: str, site: str) -> None:
        """Dial ``address`` when it is run."""
        self._address, self._cookie, self._site = address, cookie, site
        self.silence = Silence()
        self.newest = -1.0
        self.socket: ClientConnection | None = None

    async def run(self) -> None:
        """Stay, for ever."""
        await _stay_linked(self._look_until_lost)

    async def _look_until_lost(self) -> None:
        try:
            await self._look()
        finally:
            self.socket = None

    async def _look(self) -> None:
        origin = self._address.replace("ws://", "http://")
        async with connect(
            f"{self._address}/ws", compression=None, ping_interval=None, proxy=None,
            close_timeout=1, additional_headers={"Cookie": self._cookie},
            origin=origin,  # type: ignore[arg-type]
        ) as socket:  # fmt: skip
            taken, asked_s = False, 0.0
            while True:
                # A site is known once its gateway has said what it is.
                if not taken and time.monotonic() - asked_s > 0.5:
                    asked_s = time.monotonic()
                    wish = browser.Subscribe(sub=1, site=self._site, channels=[ADDRESS], every_ms=0)
                    await socket.send(browser.FROM_BROWSER.encode(wish))
                try:
                    async with asyncio.timeout(0.5):
                        data = await socket.recv()
                except TimeoutError:
                    continue
                message = browser.TO_BROWSER.decode(data)
                if isinstance(message, browser.Subscribed):
                    taken = True
                elif isinstance(message, browser.Values):
                    # Who sees again what was sees nothing new.
                    newest = max(unpack_columns(message).value.tolist())
                    if newest > self.newest:
                        self.newest = newest
                        self.socket = socket
                        self.silence.hear()


async def spread(everybody: list[NumberedGateway | Onlooker]) -> None:
    """Let all dial anew, and wait until all are there."""
    for one in everybody:
        if one.socket is not None:
            one.socket.transport.abort()
            one.socket = None
    while any(one.socket is None for one in everybody):  # noqa: ASYNC110
        await asyncio.sleep(0.05)


async def report(gateways: list[NumberedGateway], pages: list[Onlooker]) -> str:
    """Wait until all is acknowledged; give the ledgers."""
    ends = time.monotonic() + 60.0
    while not all(one.settled for one in gateways) and time.monotonic() < ends:  # noqa: ASYNC110
        await asyncio.sleep(0.05)
    # Up to here everything is to be there, once.
    ledger = {one.site: one.acked for one in gateways}
    unsettled = [one.site for one in gateways if not one.settled]
    blind = sum(one.newest < 0 for one in pages)
    return json.dumps(
        {"ledger": ledger, "unsettled": unsettled, "blind": blind,
         "gateways_s": [one.silence.longest_s for one in gateways],
         "pages_s": [one.silence.longest_s for one in pages]}
    )  # fmt: skip


async def main(address: str, keys: list[str], cookie: str, count: int) -> None:
    """Stay until stdin ends."""
    gateways = [NumberedGateway(address, *line.split()) for line in keys]
    pages = [Onlooker(address, cookie, gateways[at % len(gateways)].site) for at in range(count)]
    tasks = [asyncio.create_task(one.start()) for one in gateways]
    tasks += [asyncio.create_task(one.run()) for one in pages]
    while line := (await asyncio.to_thread(sys.stdin.readline)).strip():
        if broken := next((task for task in tasks if task.done()), None):
            broken.result()
        if line == "fault":
            for one in (*gateways, *pages):
                one.silence.begin_fault()
        elif line == "spread":
            await spread([*gateways, *pages])
            sys.stdout.write("spread\n")
            sys.stdout.flush()
        else:
            sys.stdout.write(f"report {await report(gateways, pages)}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    given = [Path(name).read_text() for name in sys.argv[2:4]]
    uvloop.run(
        main(f"ws://localhost:{sys.argv[1]}", given[0].splitlines(), given[1], int(sys.argv[4]))
    )
