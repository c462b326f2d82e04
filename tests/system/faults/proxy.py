"""A network between gateway and hub whose weather a test makes: TCP in user space.

It runs on a thread of its own, so that a test that is busy does not hold up the network.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections import deque
from collections.abc import Coroutine
from typing import Any

from .weather import CALM, Dice, Frames, Way, Weather

# What may be under way in one direction; then nothing more is read, as with a full TCP window.
MOST_UNDER_WAY = 4 * 1024 * 1024


class _Pipe:
    """One direction of one connection."""

    def __init__(
        self, way: Way, proxy: Proxy, reader: asyncio.StreamReader, writer: asyncio.StreamWriter,
        name: str,
    ) -> None:  # fmt: skip
        """Read from ``reader``, write to ``writer``."""
        self.way, self.writer = way, writer
        self._proxy, self._reader = proxy, reader
        self.dice = Dice(name)
        self._queue: deque[tuple[float, bytes]] = deque()
        self._bytes = 0
        self._changed = asyncio.Event()
        self._ended = False
        self.shut = False
        self._due = 0.0

    async def run(self) -> None:
        taking = asyncio.ensure_future(self._take())
        try:
            await self._give()
        finally:
            taking.cancel()
            await asyncio.gather(taking, return_exceptions=True)

    async def _take(self) -> None:
        frames = Frames()
        loop = asyncio.get_running_loop()
        while data := await self._reader.read(65_536):
            for piece, whole in frames.feed(data):
                for bit in self.dice.deal(piece, whole, self._proxy.weather):
                    self._put(loop.time(), bit)
            while self._bytes > MOST_UNDER_WAY:  # noqa: ASYNC110 - asked from time to time
                await asyncio.sleep(0.01)
        for bit in [*self.dice.last(), frames.rest]:
            self._put(loop.time(), bit)
        self._ended = True
        self._changed.set()

    def _put(self, now: float, bit: bytes) -> None:
        weather = self._proxy.weather
        # Jitter never overtakes: TCP delivers in order.
        self._due = max(self._due, now + self.dice.delay_s(weather))
        self._queue.append((self._due, bit))
        self._bytes += len(bit)
        self._changed.set()

    async def _give(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            while not self._queue:
                if self._ended:
                    if not self.shut and self.writer.can_write_eof():
                        self.writer.write_eof()
                    return
                self._changed.clear()
                await self._changed.wait()
            due, bit = self._queue[0]
            await asyncio.sleep(max(0.0, due - loop.time()))
            await self._proxy.light(self.way)
            self._queue.popleft()
            self._bytes -= len(bit)
            if not self.shut:
                self.writer.write(bit)
                await self.writer.drain()
            self._proxy.passed[self.way] += len(bit)
            if (words := self._proxy.looked_for.get(self.way)) and words in bit:
                self._proxy.seen_ns[self.way] = time.monotonic_ns()
            if self._proxy.weather.rate:
                await asyncio.sleep(len(bit) / self._proxy.weather.rate)


class Proxy:
    """Listens on a port of its own and forwards to another of this machine."""

    def __init__(self, target: int, seed: int = 0) -> None:
        """Begin in calm weather."""
        self._target, self._seed = target, seed
        self.weather = CALM
        self.passed = {Way.UP: 0, Way.DOWN: 0}
        # Words to look for in what passes, by direction, and when they passed last (monotonic, ns).
        self.looked_for: dict[Way, bytes] = {}
        self.seen_ns: dict[Way, int] = {}
        self.connections = 0
        self._pipes: list[_Pipe] = []
        self._loop = asyncio.new_event_loop()
        self._cleared = asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._server = self._do(asyncio.start_server(self._serve, "127.0.0.1", 0))
        self.port = int(self._server.sockets[0].getsockname()[1])

    def _do(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(10)

    # ── what a test does ──

    def reseed(self, seed: int) -> None:
        """Decide by another seed from the next connection on."""
        self._seed = seed
        self.connections = 0

    def change(self, weather: Weather) -> None:
        """Change the weather, for what is read from now on (darkness: for all)."""

        async def change() -> None:
            self.weather = weather
            self._cleared.set()

        self._do(change())

    def cut(self) -> None:
        """End every connection with a reset."""

        async def cut() -> None:
            for pipe in self._pipes:
                pipe.writer.transport.abort()

        self._do(cut())

    def half_close(self, way: Way) -> None:
        """Tell the receiver of one direction that no more will come; the other stays open."""

        async def close() -> None:
            for pipe in self._pipes:
                if pipe.way is way and not pipe.writer.transport.is_closing():
                    pipe.shut = True
                    pipe.writer.write_eof()

        self._do(close())

    def dealt(self) -> tuple[int, int, int]:
        """Tell how many frames were repeated, changed places, and were cut in bits."""
        dice = [pipe.dice for pipe in self._pipes]
        return (
            sum(each.duplicated for each in dice),
            sum(each.reordered for each in dice),
            sum(each.cut for each in dice),
        )

    def forget(self) -> None:
        """Forget the pipes that have ended, and what was dealt."""

        async def forget() -> None:
            self._pipes = [each for each in self._pipes if not each.writer.transport.is_closing()]

        self._do(forget())

    def close(self) -> None:
        """End all."""

        async def end() -> None:
            self._server.close()
            mine = asyncio.current_task()
            tasks = [each for each in asyncio.all_tasks() if each is not mine]
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

        self._do(end())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(10)
        self._loop.close()

    # ── what passes ──

    async def light(self, way: Way) -> None:
        """Wait until a direction is not dark."""
        while way in self.weather.dark:
            self._cleared.clear()
            await self._cleared.wait()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.connections += 1
        name = f"{self._seed}:{self.connections}"
        try:
            # In the dark the other side cannot be reached either.
            for way in Way:
                await self.light(way)
            far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:
            writer.transport.abort()
            return
        pipes = [
            _Pipe(Way.UP, self, reader, far_writer, f"{name}:up"),
            _Pipe(Way.DOWN, self, far_reader, writer, f"{name}:down"),
        ]
        self._pipes += pipes
        runs = [asyncio.ensure_future(pipe.run()) for pipe in pipes]
        try:
            await asyncio.wait(runs, return_when=asyncio.FIRST_EXCEPTION)
        finally:
            for each in runs:
                each.cancel()
            # That one side went away is no news here: the other is told by the abort.
            await asyncio.gather(*runs, return_exceptions=True)
            for pipe in pipes:
                pipe.writer.transport.abort()
