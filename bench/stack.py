"""A hub and a gateway of their own for one measurement, over TLS, with rights and storage on."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import ssl
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import psutil

from talaia.cli.child_processes import ChildProcess, end_all, start_program, start_talaia
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.sim import ros_domain

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

HERE = Path(__file__).resolve().parent
PASSWORD = "a bench's own password"  # noqa: S105 - of a hub that lives for a minute on loopback


class Stack(NamedTuple):
    """What a measurement needs of its hub and its gateway."""

    folder: Path
    port: int
    hub: ChildProcess
    gateway: ChildProcess
    environment: dict[str, str]

    @property
    def parts(self) -> tuple[ChildProcess, ChildProcess]:
        """Gateway and hub."""
        return self.gateway, self.hub

    @property
    def origin(self) -> str:
        """Where the pages are."""
        return f"https://localhost:{self.port}"


def site_text(
    topics: int,
    *,
    camera: bool = False,
    cameras: int = 0,
    compressed: bool = False,
    detect: str = "",
    tapped: bool = False,
) -> str:
    """Write the description of the publisher's site.

    ``detect`` is what its camera is to see; with ``tapped`` its topics may be had raw; the numbered
    ``cameras`` are ``compressed`` ones or not.
    """
    signals = "\n".join(
        f"      s{each}: {{name: Signal {each}, source: {{topic: /bench/s{each},"
        " type: std_msgs/msg/Float64, field: data}}"
        for each in range(topics)
    )
    seeing = f", detect: {detect}" if detect else ""
    stream = (
        "    streams: {front: {name: Front, source: {topic: /bench/image,"
        f" type: sensor_msgs/msg/Image}}{seeing}}}}}\n"
        if camera
        else ""
    )
    if cameras:
        listed = ", ".join(
            f"camera{each}: {{name: Camera {each}, source: {{topic: /bench/image{each},"
            f" type: sensor_msgs/msg/{'CompressedImage' if compressed else 'Image'}}}}}"
            for each in range(cameras)
        )
        stream = f"    streams: {{{listed}}}\n"
    return (
        "talaia: 1\nsite: bench\nname: Bench\nros2: {}\ndevices:\n  base:\n    name: Base\n"
        f"    kind: vehicle\n{stream}    signals:{chr(10) + signals if signals else ' {}'}\n"
        "    drive: {topic: /cmd_vel, max_speed: 1.0, max_turn: 1.0, max_acceleration: 1000,"
        " max_turn_acceleration: 1000}\n"
        + ("topics:\n  - {pattern: /bench/**, right: view}\n" if tapped else "")
    )


def free_port() -> int:
    """Find a port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.asynccontextmanager
async def running(
    topics: int,
    *,
    camera: bool = False,
    cameras: int = 0,
    compressed: bool = False,
    detect: str = "",
    tapped: bool = False,
    hurried: bool = True,
    before: Callable[[Settings], Awaitable[None]] | None = None,
) -> AsyncIterator[Stack]:
    """Run a hub and a gateway for a site with so many topics; ``before`` is done before both.

    One that is not ``hurried`` sends as slowly as ever what somebody looks at.
    """
    with tempfile.TemporaryDirectory(prefix="talaia-bench-") as name:
        folder = Path(name)
        port = free_port()
        world = ros_domain.reserve_domain().domain
        here = ros_domain.domain_environment(world)
        settings = Settings(data=folder, host="127.0.0.1", port=port)
        await accounts.create_user(settings, "admin", PASSWORD, "admin")
        (folder / "key").write_text(await accounts.create_gateway(settings, "bench"))
        (folder / "site.yaml").write_text(
            site_text(
                topics,
                camera=camera,
                cameras=cameras,
                compressed=compressed,
                detect=detect,
                tapped=tapped,
            )
        )
        if before is not None:
            await before(settings)
        words = ["hub", "--data", str(folder), "--host", "127.0.0.1", "--port", str(port)]
        hub = await start_talaia("hub", words, folder / "hub.log")
        await hub.wait_line("ready", 30)
        words = [
            "gateway", str(folder / "site.yaml"), "--hub", f"wss://127.0.0.1:{port}",
            "--key-file", str(folder / "key"), "--ca", str(folder / "tls" / "cert.pem"),
            "--data", str(folder / "gateway"), "--ros-domain", str(world),
        ]  # fmt: skip
        program = ["-m", "talaia"] if hurried else [str(HERE / "unhurried_gateway.py")]
        words = [sys.executable, *program, *words]
        gateway = await start_program("gateway", words, folder / "gateway.log", here)
        try:
            await gateway.wait_line("linked to", 30)
            yield Stack(folder, port, hub, gateway, here)
        finally:
            await end_all([gateway, hub])


async def add_people(stack: Stack, count: int) -> list[str]:
    """Give so many people an account each; their names."""
    settings = Settings(data=stack.folder, host="127.0.0.1", port=stack.port)
    names = [f"person {each}" for each in range(count)]
    for name in names:
        await accounts.create_user(settings, name, PASSWORD, "operator")
    return names


@contextlib.asynccontextmanager
async def publisher(stack: Stack, topics: int, rate: float, *more: str) -> AsyncIterator[None]:
    """Run the ROS peer beside a stack."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(HERE / "publisher.py"), str(topics), str(rate), "600", *more,
        stdout=asyncio.subprocess.PIPE, env={**os.environ, **stack.environment},
    )  # fmt: skip
    try:
        assert process.stdout is not None
        await asyncio.wait_for(process.stdout.readline(), 30)
        yield
    finally:
        process.kill()
        await process.wait()


def context(stack: Stack) -> ssl.SSLContext:
    """Trust the hub's own certificate and no other."""
    trust = ssl.create_default_context(cafile=str(stack.folder / "tls" / "cert.pem"))
    trust.check_hostname = False
    return trust


async def cpu_percent(part: ChildProcess, seconds: float) -> float:
    """Measure a process's use of one core over some seconds, in percent."""
    process = psutil.Process(part.process.pid)
    before = process.cpu_times()
    began = asyncio.get_running_loop().time()
    await asyncio.sleep(seconds)
    after = process.cpu_times()
    used = (after.user + after.system) - (before.user + before.system)
    return 100 * used / (asyncio.get_running_loop().time() - began)
