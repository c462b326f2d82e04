"""Viewers of a camera without a screen, on lines of any speed; and another server's, to compare."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import ssl
import struct
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
import websockets
from stack import Stack, context, free_port

from talaia.wire import browser

# What a slow line holds besides what is under way (bytes): a home router's share.
BUFFER = 16 * 1024


class Got(NamedTuple):
    """A picture that came whole: how old it was then, and its weight in bytes."""

    age_ms: float
    size: int
    small: bool


def memory_mib(pid: int) -> float:
    """Give what a process holds in memory."""
    return float(psutil.Process(pid).memory_info().rss) / 2**20


@contextlib.asynccontextmanager
async def looking(here: Stack, session: str, port: int = 0) -> AsyncIterator[list[Got]]:
    """Look at the camera as a page does that plays films; fills the list."""
    got: list[Got] = []
    trust: ssl.SSLContext = context(here)

    async def look() -> None:
        path = "/ws/media?site=bench&stream=base/front&forms=h264,jpeg"
        async with websockets.connect(
            f"wss://localhost:{here.port}{path}", ssl=trust, compression=None,
            ping_interval=None, max_size=16 * 1024 * 1024, proxy=None,
            additional_headers={"Cookie": session}, host="127.0.0.1", port=port or here.port,
            origin=here.origin,
        ) as connection:  # type: ignore[arg-type]  # fmt: skip
            async for data in connection:
                shot = browser.MEDIA_TO_BROWSER.decode(data)
                if isinstance(shot, browser.CameraPicture):
                    # One machine has one monotonic clock.
                    age_ms = time.monotonic_ns() / 1e6 - shot.hub_us / 1e3
                    got.append(Got(age_ms, len(data), shot.small))
                    shown = browser.PictureShown(seq=shot.seq)
                    await connection.send(browser.MEDIA_FROM_BROWSER.encode(shown))

    task = asyncio.create_task(look())
    try:
        yield got
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


@contextlib.asynccontextmanager
async def throttled(port: int, bits: float) -> AsyncIterator[int]:
    """Stand before a port and pass on its answers at so many bit/s; gives the port to dial."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # The line's own buffer is small; without this, the kernel would hold some megabytes.
        own = socket.socket()
        own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
        own.settimeout(0)
        await asyncio.get_running_loop().sock_connect(own, ("127.0.0.1", port))
        down_reader, down_writer = await asyncio.open_connection(sock=own, limit=BUFFER)

        async def up() -> None:
            while data := await reader.read(65536):
                down_writer.write(data)
                await down_writer.drain()

        async def down() -> None:
            free = time.monotonic()
            while data := await down_reader.read(1500):
                free = max(free, time.monotonic()) + len(data) * 8 / bits
                await asyncio.sleep(free - time.monotonic())
                writer.write(data)
                await writer.drain()

        tasks = [asyncio.create_task(up()), asyncio.create_task(down())]
        with contextlib.suppress(asyncio.CancelledError):
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for each in tasks:
            each.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for each in (writer, down_writer):
            each.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()


async def foxglove(bits: float, seconds: float) -> tuple[float, float]:
    """Look at the film at a small foxglove-sdk server over such a line.

    Returns:
        The middle age of a picture when it has come (ms), of the last half of the time; and by
        how much the server's memory has grown (MiB).

    """
    port = free_port()
    server = subprocess.Popen(
        [sys.executable, str(Path(__file__).resolve()), str(port)], stdout=subprocess.PIPE
    )
    ages: list[float] = []
    try:
        assert server.stdout is not None
        await asyncio.to_thread(server.stdout.readline)
        before = memory_mib(server.pid)
        async with throttled(port, bits) as slow, websockets.connect(
            f"ws://127.0.0.1:{slow}", subprotocols=["foxglove.sdk.v1"], compression=None,
            max_size=None, ping_interval=None, proxy=None,
        ) as connection:  # type: ignore[list-item]  # fmt: skip
            until = time.monotonic() + seconds
            with contextlib.suppress(TimeoutError):
                while True:
                    data = await asyncio.wait_for(connection.recv(), until - time.monotonic())
                    if isinstance(data, str):
                        said = json.loads(data)
                        for each in said.get("channels", []):
                            wanted = [{"id": 1, "channelId": each["id"]}]
                            ask = {"op": "subscribe", "subscriptions": wanted}
                            await connection.send(json.dumps(ask))
                    elif data[0] == 1:
                        stamp = struct.unpack_from("<Q", data, 5)[0]
                        if until - time.monotonic() < seconds / 2:
                            ages.append((time.time_ns() - stamp) / 1e6)
            grown = memory_mib(server.pid) - before
    finally:
        server.kill()
        server.wait()
    return (float(np.median(ages)) if ages else float("inf")), grown


def serve_foxglove(port: int) -> None:
    """Serve the publisher's film as JPEG at 30 Hz."""
    import foxglove as sdk
    import simplejpeg
    from foxglove.channels import CompressedImageChannel
    from foxglove.messages import CompressedImage
    from publisher import film_of

    film = []
    for each in film_of():
        pixels = np.frombuffer(each.data, np.uint8).reshape(480, 640, 3)
        film.append(simplejpeg.encode_jpeg(pixels, 70, "RGB", "420"))
    sdk.start_server(host="127.0.0.1", port=port)
    channel = CompressedImageChannel("/camera")
    print("ready", flush=True)
    due = time.monotonic()
    for turn in range(10**9):
        now = time.time_ns()
        channel.log(CompressedImage(format="jpeg", data=film[turn % len(film)]), log_time=now)
        due += 1 / 30
        time.sleep(max(0.0, due - time.monotonic()))


if __name__ == "__main__":
    serve_foxglove(int(sys.argv[1]))
