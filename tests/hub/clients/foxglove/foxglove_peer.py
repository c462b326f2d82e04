"""Two Foxglove clients for tests: npm's own, and one that may say anything."""

from __future__ import annotations

import asyncio
import json
import shutil
import struct
from pathlib import Path

import websockets

from ..heard_events import HeardEvents
from ..tokens import open_protocol, token_of

SCRIPT = Path(__file__).with_name("ws_protocol_client.mjs")
MODULES = Path(__file__).parents[4] / "web" / "package.json"
V1, SDK = "foxglove.websocket.v1", "foxglove.sdk.v1"


def address_of(hub, site: str, token: str) -> str:
    return f"ws://127.0.0.1:{hub.port}/clients/foxglove/{site}?token={token}"


class NodeClient(HeardEvents):
    """`FoxgloveClient` of npm's @foxglove/ws-protocol, in a process of its own."""

    async def __aenter__(self):
        return self

    async def connect(self, address: str, subprotocol: str = V1, coding: str = "utf8"):
        self._process = await asyncio.create_subprocess_exec(
            shutil.which("node"),
            "--experimental-websocket",
            str(SCRIPT),
            str(MODULES),
            address,
            subprotocol,
            coding,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.DEVNULL,
            limit=2**24,
        )
        self._reading = asyncio.create_task(self._read())
        await self.hear("serverInfo")
        return self

    async def call(self, name: str, *arguments):
        self._process.stdin.write(json.dumps([name, *arguments]).encode() + b"\n")
        return await self.hear("returned")

    async def __aexit__(self, *_):
        if self._process.returncode is None:
            self._process.stdin.close()
            self._process.terminate()
        await self._process.wait()
        await self._reading

    async def _read(self) -> None:
        async for line in self._process.stdout:
            await self.note(*json.loads(line))


_KINDS = {1: "data", 2: "time", 3: "response", 4: "asset", 5: "state"}


class RawClient(HeardEvents):
    """A client that may say anything; JSON is heard by its ``op``, binary messages by kind."""

    async def connect(self, address: str, *, subprotocol=SDK, **options):
        self.socket = await websockets.connect(
            address, subprotocols=[subprotocol], proxy=None, max_size=None, **options
        )
        self.frames = []
        self._reading = asyncio.create_task(self._read())
        return self

    async def say(self, message) -> None:
        await self.socket.send(json.dumps(message) if isinstance(message, dict) else message)

    async def call(self, service: int, call: int, payload: bytes, encoding: bytes = b"json"):
        head = struct.pack("<BIII", 2, service, call, len(encoding))
        await self.say(head + encoding + payload)

    async def close(self) -> None:
        await self.socket.close()
        await self._reading

    async def _read(self) -> None:
        try:
            async for frame in self.socket:
                self.frames.append(frame)
                if isinstance(frame, bytes):
                    await self.note(_KINDS[frame[0]], frame)
                else:
                    said = json.loads(frame)
                    await self.note(said["op"], said)
        except websockets.ConnectionClosed:
            pass
        await self.note("closed", self.socket.close_code)


async def client_of(world, name, *, site="agv", kind=RawClient, more="", **options):
    """Connect as somebody, with a token of theirs; ``more`` stands in the address behind it."""
    await open_protocol(world.hub, "foxglove")
    token = await token_of(world.hub, name)
    return await kind().connect(address_of(world.hub, site, token) + more, **options)


async def topics_of(client) -> dict[str, int]:
    said = await client.hear("advertise")
    channels = said["channels"] if isinstance(said, dict) else said
    return {channel["topic"]: channel["id"] for channel in channels}


async def services_of(client) -> dict[str, int]:
    said = await client.hear("advertiseServices")
    services = said["services"] if isinstance(said, dict) else said
    return {service["name"]: service["id"] for service in services}
