"""A rosbridge server for the tests: its real words, recorded, played back by who asks for them.

``recorded/rosbridge-*.jsonl`` were recorded between this gateway and RobotWebTools'
rosbridge_suite (branch ros2) on rclpy, with `recording`; see `test_adapter`. A line is a frame
in the order of the wire: ``c`` what the client said, ``s`` what the server said (``b`` when it
was binary, in base64). `Replay` says each server frame when the client has said all that came
before it; so it also shows that the gateway still says what the real server understood.
"""

from __future__ import annotations

import asyncio
import base64
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from websockets.asyncio.client import connect
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

# Driving goes by the clock and by how long things take: it is looked at, and not compared.
_BY_THE_CLOCK = ("/cmd_vel", "/stop")
_MAX = 32 * 1024 * 1024


def line_of(side: str, data: str | bytes) -> str:
    if isinstance(data, bytes):
        return json.dumps({"b": base64.b64encode(data).decode()})
    return json.dumps({side: json.loads(data)})


def by_the_clock(said: dict) -> bool:
    return said["op"] == "publish" and said["topic"] in _BY_THE_CLOCK


@asynccontextmanager
async def recording(url: str, path: Path) -> AsyncIterator[str]:
    """Stand between a client and a real server, and write down what both say."""
    lines: list[str] = []

    async def handle(client: ServerConnection) -> None:
        async with connect(url, max_size=_MAX, compression=None, proxy=None) as server:

            async def pump(source, target, side: str) -> None:
                try:
                    async for data in source:
                        if side == "s" or not by_the_clock(json.loads(data)):
                            lines.append(line_of(side, data))
                        await target.send(data)
                except ConnectionClosed:
                    return

            back = asyncio.ensure_future(pump(server, client, "s"))
            await pump(client, server, "c")
            back.cancel()

    async with serve(handle, "127.0.0.1", 0, max_size=_MAX, compression=None) as one:
        yield f"ws://127.0.0.1:{one.sockets[0].getsockname()[1]}"
    await asyncio.to_thread(path.write_text, "\n".join(lines) + "\n")


class Replay:
    """Plays one recording to each client that comes."""

    def __init__(self, path: Path) -> None:  # noqa: D107
        self.lines = [json.loads(line) for line in path.read_text().splitlines()]
        self.driven: list[dict] = []
        self.unexpected: list[dict] = []
        self.clients: list[ServerConnection] = []
        self._said: asyncio.Queue[dict] = asyncio.Queue()

    async def handle(self, client: ServerConnection) -> None:
        self.clients.append(client)
        waiting: list[dict] = []
        reading = asyncio.ensure_future(self._read(client))
        try:
            for line in self.lines:
                if "c" in line:
                    while line["c"] not in waiting:
                        waiting.append(await self._said.get())
                    waiting.remove(line["c"])
                elif "b" in line:
                    await client.send(base64.b64decode(line["b"]))
                else:
                    await client.send(json.dumps(line["s"]))
            await reading
        except ConnectionClosed:
            return
        finally:
            # What has not come yet is asked for again, as often as it takes.
            more = [*waiting, *(self._said.get_nowait() for _ in range(self._said.qsize()))]
            self.unexpected += [each for each in more if not each["op"].endswith("subscribe")]
            reading.cancel()

    async def _read(self, client: ServerConnection) -> None:
        async for data in client:
            said = json.loads(data)
            if by_the_clock(said):
                self.driven.append(said)
            else:
                self._said.put_nowait(said)


@asynccontextmanager
async def replaying(path: Path) -> AsyncIterator[tuple[Replay, str]]:
    one = Replay(path)
    async with serve(one.handle, "127.0.0.1", 0, max_size=_MAX, compression=None) as server:
        yield one, f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
