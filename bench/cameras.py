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

import clients
import link
import numpy as np
import psutil
import stack
import websockets
from stack import Stack, context, free_port

from talaia.wire import browser

# What a slow line holds besides what is under way (bytes): a home router's share.
BUFFER = 16 * 1024
# What else goes on beside many cameras or large ones: signals at 20 Hz, and for how long (s).
SIGNALS, SECONDS = 20, 20.0


class Got(NamedTuple):
    """A picture that came whole: how old it was then, its weight in bytes, and its size (px)."""

    age_ms: float
    size: int
    small: bool
    width: int
    height: int


def memory_mib(pid: int) -> float:
    """Give what a process holds in memory."""
    return float(psutil.Process(pid).memory_info().rss) / 2**20


@contextlib.asynccontextmanager
async def looking(
    here: Stack, session: str, port: int = 0, name: str = "front"
) -> AsyncIterator[list[Got]]:
    """Look at a camera as a page does that plays films; fills the list."""
    got: list[Got] = []
    trust: ssl.SSLContext = context(here)

    async def look() -> None:
        path = f"/ws/media?site=bench&stream=base/{name}&forms=h264,jpeg"
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
                    got.append(Got(age_ms, len(data), shot.small, shot.width, shot.height))
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


class Load(NamedTuple):
    """What some cameras cost, and what came of them.

    Attributes:
        gateway: % of a core that the gateway takes.
        hub: the same of the hub.
        rates: pictures a second of each camera that came to its viewer; none where nobody looks.
        size: width and height of the last picture (px).
        ages_ms: of all pictures when they had come.
        mbits: all that came (Mbit/s).
        drives_ms: from a page's socket to ``cmd_vel``, meanwhile.
        samples_ms: from ROS to a page's socket, meanwhile.

    """

    gateway: float
    hub: float
    rates: list[float]
    size: tuple[int, int]
    ages_ms: np.ndarray
    mbits: float
    drives_ms: np.ndarray
    samples_ms: np.ndarray


async def load_of(
    count: int, size: str = "640x480", *, compressed: bool = False, watched: bool = True
) -> Load:
    """Let so many cameras of a size send at 30 Hz while somebody drives and looks at samples.

    With a ``count`` of 0 there is none: what the rest costs.
    """
    async with stack.running(SIGNALS, cameras=max(1, count), compressed=compressed) as here:
        target = here.folder / "driven.txt"
        words = ["--films", str(count), "--size", size, *(["--compressed"] if compressed else [])]
        async with (
            # Of another process: what writes pictures is not to hold up who listens.
            stack.publisher(here, SIGNALS, 20.0, "--listen", str(target)),
            stack.publisher(here, 0, 1, *words),
        ):
            session = await clients.cookie(here)
            async with contextlib.AsyncExitStack() as open_now:
                seen = [
                    await open_now.enter_async_context(looking(here, session, name=f"camera{each}"))
                    for each in range(count if watched else 0)
                ]
                # Films begin with their dearest picture, and a pace has to be found.
                await asyncio.sleep(8)
                for got in seen:
                    got.clear()
                began = time.monotonic()
                *used, drives, samples = await asyncio.gather(
                    *(stack.cpu_percent(part, SECONDS) for part in here.parts),
                    link.driven(here, session, target, 300),
                    clients.listen(here, session, SIGNALS, 0, SECONDS),
                )
                lasted = time.monotonic() - began
    every = [one for got in seen for one in got]
    return Load(
        gateway=used[0],
        hub=used[1],
        rates=[len(got) / lasted for got in seen],
        size=(every[-1].width, every[-1].height) if every else (0, 0),
        ages_ms=np.array([one.age_ms for one in every]),
        mbits=sum(one.size for one in every) * 8 / lasted / 1e6,
        drives_ms=drives,
        samples_ms=samples,
    )


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
