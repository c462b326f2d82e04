"""Raw topics at Foxglove clients, of our hub and of a small server of ``foxglove-sdk`` and rclpy.

python bench/taps.py serve PORT TOPICS    that server
python bench/taps.py count TOPIC …        how many subscribe to them, as ROS has it
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import ssl
import struct
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import numpy as np
import psutil
import websockets
from clients import cookie
from stack import Stack, context, free_port

SDK = "foxglove.sdk.v1"
HERE = Path(__file__).resolve()
# Of a message as a client gets it: kind, subscription, time; then CDR's own four bytes.
HEAD = 13 + 4


class Heard:
    """What one client got since it was cleared last."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.ages_ms: list[float] = []
        self.bytes = 0

    def clear(self) -> None:
        """Forget it."""
        self.ages_ms.clear()
        self.bytes = 0

    def add(self, frame: bytes) -> None:
        """Take a message: a `Float64` with the time it was published, or a cloud with its stamp."""
        now_us = time.time() * 1e6
        self.bytes += len(frame)
        if len(frame) < 100:
            said_us = struct.unpack_from("<d", frame, HEAD)[0]
        else:
            sec, nanosec = struct.unpack_from("<iI", frame, HEAD)
            said_us = sec * 1e6 + nanosec / 1e3
        self.ages_ms.append((now_us - said_us) / 1e3)


async def open_door(here: Stack) -> str:
    """Open the protocol as an admin does; give the address with a token."""
    session = await cookie(here)
    headers = {"Origin": here.origin, "Cookie": session}
    async with httpx.AsyncClient(
        verify=context(here), base_url=here.origin, timeout=60, headers=headers
    ) as client:
        answer = await client.put("/api/client-protocols/foxglove", json={"open": True})
        answer.raise_for_status()
        asked = {
            "name": "bench",
            "ends_us": int((time.time() + 3600) * 1e6),
            "permissions": [{"right": "view", "site": "bench", "device": "*"}],
        }
        answer = await client.post("/api/me/tokens", json=asked)
        answer.raise_for_status()
    return f"wss://localhost:{here.port}/clients/foxglove/bench?token={answer.json()['token']}"


@contextlib.asynccontextmanager
async def taking(
    address: str, topics: set[str], *, trust: ssl.SSLContext | None = None, port: int = 0
) -> AsyncIterator[Heard]:
    """Take topics as a Foxglove client; through another port where one is given."""
    heard, subscribed = Heard(), asyncio.Event()
    dialled = {"host": "127.0.0.1", "port": port} if port else {}

    async def take() -> None:
        async with websockets.connect(
            address, subprotocols=[SDK], ssl=trust, compression=None, max_size=None,
            ping_interval=None, proxy=None, **dialled,
        ) as socket:  # type: ignore[list-item, arg-type]  # fmt: skip
            missing = set(topics)
            async for frame in socket:
                if isinstance(frame, bytes):
                    if frame[0] == 1:
                        heard.add(frame)
                    continue
                said = json.loads(frame)
                if said["op"] == "advertise":
                    wanted = [one for one in said["channels"] if one["topic"] in missing]
                    missing -= {one["topic"] for one in wanted}
                    asked = [{"id": one["id"], "channelId": one["id"]} for one in wanted]
                    if asked:
                        await socket.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
                    if not missing:
                        subscribed.set()

    task = asyncio.create_task(take())
    try:
        async with asyncio.timeout(30):
            await subscribed.wait()
        yield heard
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


def seconds_used(*pids: int) -> float:
    """Give the processor time of processes so far."""
    times = [psutil.Process(pid).cpu_times() for pid in pids]
    return sum(one.user + one.system for one in times)


def memory_mib(pid: int) -> float:
    """Give what a process has in memory for itself."""
    return float(psutil.Process(pid).memory_full_info().uss) / 2**20


def line_bytes(here: Stack) -> int:
    """Give what the gateway has sent to its hub on the connections that are open, by the kernel."""
    found = subprocess.run(
        ["ss", "-tinHp", f"dport = :{here.port}"], check=True, capture_output=True, text=True
    ).stdout
    total, ours = 0, False
    for line in found.splitlines():
        if not line.startswith(("\t", " ")):
            ours = f"pid={here.gateway.process.pid}," in line
        elif ours and (sent := re.search(r"bytes_sent:(\d+)", line)):
            total += int(sent[1])
    return total


def subscriptions(here: Stack, topics: list[str]) -> int:
    """Count who subscribes to topics, as another node of ROS sees it."""
    done = subprocess.run(
        [sys.executable, str(HERE), "count", *topics],
        check=True, capture_output=True, text=True, env={**os.environ, **here.environment},
    )  # fmt: skip
    return int(done.stdout)


@contextlib.asynccontextmanager
async def foxglove_server(here: Stack, topics: int) -> AsyncIterator[tuple[str, int]]:
    """Run the other server; gives its address and its process."""
    port = free_port()
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(HERE), "serve", str(port), str(topics),
        stdout=asyncio.subprocess.PIPE, env={**os.environ, **here.environment},
    )  # fmt: skip
    try:
        assert process.stdout is not None
        await asyncio.wait_for(process.stdout.readline(), 30)
        yield f"ws://127.0.0.1:{port}", process.pid
    finally:
        process.kill()
        await process.wait()


async def side_by_side(
    here: Stack, topics: int, rounds: int, seconds: float
) -> dict[str, tuple[float, np.ndarray]]:
    """Take the publisher's topics of both, in turn.

    Returns:
        By who serves: percent of a core (gateway and hub together), and the ages (ms).

    """
    address, trust = await open_door(here), context(here)
    names = {f"/bench/s{number}" for number in range(topics)}
    pids = here.gateway.process.pid, here.hub.process.pid
    used: dict[str, list[float]] = {"talaia": [], "foxglove-sdk": []}
    ages: dict[str, list[float]] = {"talaia": [], "foxglove-sdk": []}

    async def measure(who: str, heard: Heard, *pids: int) -> None:
        # What was there before the first message is told first.
        await asyncio.sleep(2)
        heard.clear()
        before, began = seconds_used(*pids), time.monotonic()
        await asyncio.sleep(seconds)
        used[who].append(100 * (seconds_used(*pids) - before) / (time.monotonic() - began))
        ages[who] += heard.ages_ms

    for _ in range(rounds):
        async with taking(address, names, trust=trust) as heard:
            await measure("talaia", heard, *pids)
        async with foxglove_server(here, topics) as (other, pid), taking(other, names) as heard:
            await measure("foxglove-sdk", heard, pid)
    return {who: (float(np.mean(used[who])), np.array(ages[who])) for who in used}


def serve_foxglove(port: int, topics: int) -> None:
    """Hand topics of ROS 2 on, as the examples of both do it."""
    import foxglove
    import rclpy
    from rclpy.qos import QoSProfile
    from std_msgs.msg import Float64

    foxglove.start_server(host="127.0.0.1", port=port)
    rclpy.init()
    node = rclpy.create_node("foxglove_server")
    schema = foxglove.Schema(name="std_msgs/msg/Float64", encoding="ros2msg", data=b"float64 data")
    for number in range(topics):
        channel = foxglove.Channel(f"/bench/s{number}", schema=schema, message_encoding="cdr")

        def hand_on(raw: bytes, channel: foxglove.Channel = channel) -> None:
            channel.log(raw, log_time=time.time_ns())

        node.create_subscription(
            Float64, f"/bench/s{number}", hand_on, QoSProfile(depth=100), raw=True
        )
    print("ready", flush=True)
    rclpy.spin(node)


def count_subscriptions(topics: list[str]) -> None:
    """Print how many subscribe, once the publishers of all are known."""
    import rclpy

    rclpy.init()
    node = rclpy.create_node("bench_count", enable_rosout=False)
    while not all(node.count_publishers(topic) for topic in topics):
        time.sleep(0.1)
    # Subscriptions are made known with the publishers, or soon after.
    time.sleep(1)
    print(sum(node.count_subscribers(topic) for topic in topics))


if __name__ == "__main__":
    if sys.argv[1] == "serve":
        serve_foxglove(int(sys.argv[2]), int(sys.argv[3]))
    else:
        count_subscriptions(sys.argv[2:])
