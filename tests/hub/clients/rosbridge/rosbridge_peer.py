"""Rosbridge clients for tests: PyPI's roslibpy, npm's roslib in a page, one that says anything."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from pathlib import Path

import websockets

from ..heard_events import HeardEvents

HERE = Path(__file__).parent
WEB = HERE.parents[3] / "web"


def path_of(site: str, token: str) -> str:
    return f"/clients/rosbridge/{site}?token={token}"


def address_of(hub, site: str, token: str) -> str:
    return f"ws://127.0.0.1:{hub.port}{path_of(site, token)}"


def bundle_roslib(folder: Path) -> str:
    """Bundle npm's roslib for a page; give the script."""
    # Beside the modules that it is made of.
    target = folder / "roslib.js"
    subprocess.run(
        [
            str(WEB / "node_modules" / ".bin" / "rolldown"),
            str(WEB / "node_modules" / "roslib" / "dist" / "RosLib.js"),
            "--format=iife",
            "--name=ROSLIB",
            "--platform=browser",
            f"--file={target}",
        ],
        check=True,
        cwd=WEB,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return target.read_text()


class RoslibpyClient(HeardEvents):
    """PyPI's roslibpy, in a process of its own."""

    async def connect(self, hub, site: str, token: str):
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            str(HERE / "roslibpy_client.py"),
            address_of(hub, site, token),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=2**24,
        )
        self._reading = asyncio.create_task(self._read())
        assert await self.hear("connected")
        return self

    async def say(self, *command) -> None:
        self._process.stdin.write(json.dumps(command).encode() + b"\n")
        await self._process.stdin.drain()

    async def __aenter__(self):
        return self

    async def __aexit__(self, *_):
        self._process.stdin.close()
        try:
            async with asyncio.timeout(5):
                await self._process.wait()
        except TimeoutError:
            self._process.kill()
            await self._process.wait()
        await self._reading

    async def _read(self) -> None:
        async for line in self._process.stdout:
            await self.note(*json.loads(line))


class RawClient(HeardEvents):
    """A client that may say anything; JSON is heard by its ``op``, binary messages as such."""

    async def connect(self, address: str, **options):
        self.socket = await websockets.connect(address, proxy=None, max_size=None, **options)
        self.frames = []
        self._reading = asyncio.create_task(self._read())
        return self

    async def say(self, op: str, **fields) -> None:
        await self.socket.send(json.dumps({"op": op, **fields}))

    async def call(self, service: str, args=None, **fields):
        """Call a service; give its answer."""
        await self.say("call_service", service=service, id="called", args=args or {}, **fields)
        return await self.hear("service_response", lambda said: said.get("id") == "called")

    async def close(self) -> None:
        await self.socket.close()
        await self._reading

    async def _read(self) -> None:
        try:
            async for frame in self.socket:
                self.frames.append(frame)
                if isinstance(frame, bytes):
                    await self.note("binary", frame)
                else:
                    said = json.loads(frame)
                    await self.note(said["op"], said)
        except websockets.ConnectionClosed:
            pass
        await self.note("closed", self.socket.close_code)
