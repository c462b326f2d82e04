"""A rosbridge server for the tests: its real words, recorded, played back by who asks for them.

``recorded/rosbridge-*.jsonl`` were recorded between this gateway and RobotWebTools'
rosbridge_suite (branch ros2) on rclpy, with `recording`; see `test_adapter`. A line is a frame
in the order of the wire: ``c`` what the client said, ``s`` what the server said (``b`` when it
was binary, in base64). The gateway's connection for raw topics has a recording of its own
(``…-raw.jsonl``), where the story has any. `Replay` says each server frame when the client has
said all that came before it; so it also shows that the gateway still says what the real server
understood.
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


def of_raw_topics(first: dict) -> bool:
    """Tell by what a client says first whether it is the gateway's connection for raw topics."""
    return first["op"] == "call_service" and first["service"].startswith("/rosapi/")


def raw_path(path: Path) -> Path:
    return path.with_name(f"{path.stem}-raw.jsonl")


@asynccontextmanager
async def recording(
    url: str, path: Path, *, raw: bool = False, both: bool = False
) -> AsyncIterator[str]:
    """Stand between a client and a real server, and write down what both say on one connection.

    With ``both``, what is said on the gateway's connection for raw topics, too.
    """
    lines: dict[bool, list[str]] = {False: [], True: []}

    async def handle(client: ServerConnection) -> None:
        async with connect(url, max_size=_MAX, compression=None, proxy=None) as server:
            said = await client.recv()
            own = lines[of_raw_topics(json.loads(said))]
            await server.send(said)
            if not by_the_clock(json.loads(said)):
                own.append(line_of("c", said))

            async def pump(source, target, side: str) -> None:
                try:
                    async for data in source:
                        if side == "s" or not by_the_clock(json.loads(data)):
                            own.append(line_of(side, data))
                        await target.send(data)
                except ConnectionClosed:
                    return

            back = asyncio.ensure_future(pump(server, client, "s"))
            await pump(client, server, "c")
            back.cancel()

    async with serve(handle, "127.0.0.1", 0, max_size=_MAX, compression=None) as one:
        yield f"ws://127.0.0.1:{one.sockets[0].getsockname()[1]}"
    for which in {raw, *((False, True) if both else ())}:
        target = raw_path(path) if which else path
        await asyncio.to_thread(target.write_text, "\n".join(lines[which]) + "\n")


class Replay:
    """Plays one recording to each client that comes; nothing is said on one that has none."""

    def __init__(self, path: Path) -> None:  # noqa: D107
        self.lines = {
            raw: [json.loads(line) for line in each.read_text().splitlines()]
            for raw, each in ((False, path), (True, raw_path(path)))
            if each.exists()
        }
        self.driven: list[dict] = []
        self.unexpected: list[dict] = []
        self.clients: list[ServerConnection] = []

    async def handle(self, client: ServerConnection) -> None:
        said: asyncio.Queue[dict] = asyncio.Queue()
        reading = asyncio.ensure_future(self._read(client, said))
        asking = asyncio.ensure_future(said.get())
        try:
            await asyncio.wait([asking, reading], return_when=asyncio.FIRST_COMPLETED)
            if not asking.done():
                # It has gone and said nothing.
                return
            first = asking.result()
            raw = of_raw_topics(first)
            if not raw:
                self.clients.append(client)
            said.put_nowait(first)
            await self._play(client, said, reading, self.lines.get(raw, []))
        finally:
            asking.cancel()
            reading.cancel()

    async def _play(
        self,
        client: ServerConnection,
        said: asyncio.Queue[dict],
        reading: asyncio.Future[None],
        lines: list[dict],
    ) -> None:
        waiting: list[dict] = []
        try:
            for line in lines:
                if "c" in line:
                    while line["c"] not in waiting:
                        waiting.append(await said.get())
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
            more = [*waiting, *(said.get_nowait() for _ in range(said.qsize()))]
            self.unexpected += [
                each
                for each in more
                if not each["op"].endswith("subscribe") and not of_raw_topics(each)
            ]

    async def _read(self, client: ServerConnection, queue: asyncio.Queue[dict]) -> None:
        async for data in client:
            said = json.loads(data)
            if by_the_clock(said):
                self.driven.append(said)
            else:
                queue.put_nowait(said)


@asynccontextmanager
async def replaying(path: Path) -> AsyncIterator[tuple[Replay, str]]:
    one = Replay(path)
    async with serve(one.handle, "127.0.0.1", 0, max_size=_MAX, compression=None) as server:
        yield one, f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}"
