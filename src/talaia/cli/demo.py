"""``talaia demo``: a simulated vehicle, its gateway, the hub and the dashboard, in one go."""

from __future__ import annotations

import argparse
import asyncio
import importlib.util
import os
import secrets
import shutil
import signal
import socket
import sys
import tempfile
import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.errors import CliError, PartMissing
from talaia.cli.parts import Part, end_all, start
from talaia.hub import accounts
from talaia.hub.errors import NameTaken
from talaia.hub.settings import Settings
from talaia.sim import domain

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

DEFAULT_PORT = 8470
ROLES = ("admin", "operator", "guest")
EXAMPLE = "agv"


class Login(NamedTuple):
    """A throw-away account."""

    name: str
    password: str
    role: str


def main(argv: Sequence[str]) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again."""
    options = _options(argv)
    for module in ("rclpy", "mujoco"):
        if importlib.util.find_spec(module) is None:
            raise PartMissing("talaia demo", module, "hub,sim")
    began = time.monotonic()
    kept = options.data is not None
    data = options.data or Path(tempfile.mkdtemp(prefix="talaia-demo-"))
    data.mkdir(parents=True, exist_ok=True, mode=0o700)
    try:
        asyncio.run(_run(options, data, began))
    finally:
        if not kept:
            shutil.rmtree(data, ignore_errors=True)
    return 0


def _options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia demo",
        description="Start a simulated vehicle, its gateway, the hub and the dashboard.",
    )
    parser.add_argument(
        "--port", type=int, default=0, help=f"of the dashboard (default: {DEFAULT_PORT} or next)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the simulated world (default: 1)")
    parser.add_argument("--data", type=Path, help="keep accounts and history in this folder")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument("--no-camera", action="store_true", help="simulate without pictures")
    return parser.parse_args(argv)


async def _run(options: argparse.Namespace, data: Path, began: float) -> None:
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop.set)
    parts: list[Part] = []
    try:
        ready = asyncio.create_task(_start(options, data, parts, began))
        stopped = asyncio.create_task(_until(stop))
        await asyncio.wait({ready, stopped}, return_when=asyncio.FIRST_COMPLETED)
        if not ready.done():
            ready.cancel()
            return
        await ready
        ended = [asyncio.create_task(part.ended()) for part in parts]
        done, _ = await asyncio.wait({stopped, *ended}, return_when=asyncio.FIRST_COMPLETED)
        for task in ended:
            task.cancel()
        for task in done - {stopped}:
            await task
    finally:
        print("\nstopping …", flush=True)
        await end_all(parts)


async def _until(event: asyncio.Event) -> None:
    await event.wait()


async def _start(options: argparse.Namespace, data: Path, parts: list[Part], began: float) -> None:
    port = _free_port(options.port)
    address = f"http://localhost:{port}"
    world = domain.reserve().domain  # kept until this process ends
    here = domain.environment(world)
    simulator = ["sim", "vehicle", "--domain", str(world), "--seed", str(options.seed)]
    simulator += ["--log", str(data / "actuations.jsonl")]
    simulator += ["--no-camera"] if options.no_camera else []
    parts.append(await start("simulated vehicle", simulator, data / "sim.log", here))
    settings = Settings(
        data=data, host="127.0.0.1", port=port, plain=True, database_url=Settings.url_from()
    )
    logins = [Login(role, secrets.token_urlsafe(6), role) for role in ROLES]
    for login in logins:
        try:
            await accounts.create_user(settings, *login)
        except NameTaken:  # a kept folder: the same people, new passwords
            await accounts.set_password(settings, login.name, login.password)
    site = _example()
    key = data / "gateway.key"
    key.write_text(await accounts.create_gateway(settings, EXAMPLE))
    key.chmod(0o600)
    hub = ["hub", "--data", str(data), "--host", "127.0.0.1", "--port", str(port), "--plain"]
    gateway = [
        "gateway", str(site), "--hub", f"ws://127.0.0.1:{port}", "--key-file", str(key),
        "--allow-plain", "--data", str(data / "gateway"), "--ros-domain", str(world),
    ]  # fmt: skip
    parts.append(await start("hub", hub, data / "hub.log"))
    parts.append(await start("gateway", gateway, data / "gateway.log", here))
    await asyncio.gather(
        parts[0].says("ready", 30), parts[1].says("ready", 30), parts[2].says("linked to", 30)
    )
    _greet(address, logins, data, time.monotonic() - began)
    if not options.no_browser and _has_screen():
        await asyncio.to_thread(_open, address)


def _free_port(wanted: int) -> int:
    for port in [wanted] if wanted else range(DEFAULT_PORT, DEFAULT_PORT + 50):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise CliError(f"port {wanted} is taken; choose another with --port" if wanted else "no port")


def _example() -> Path:
    """Find the example: in this tree, or beside the installed package."""
    package = Path(__file__).resolve().parent.parent
    for base in (package.parent.parent / "examples", package / "examples"):
        if (base / EXAMPLE / "site.yaml").exists():
            return base / EXAMPLE / "site.yaml"
    raise CliError(f"the example description {EXAMPLE}/site.yaml was not installed")


def _greet(address: str, logins: Sequence[Login], data: Path, took: float) -> None:
    width = max(len(login.name) for login in logins)
    print(f"\n  Talaia is ready ({took:.1f} s):  {address}\n")
    print("  throw-away accounts, made for this demo only:")
    for login in logins:
        print(f"    {login.name:<{width}}   {login.password}")
    print(f"\n  data and logs: {data}\n  Ctrl-C stops everything.", flush=True)


def _has_screen() -> bool:
    return sys.platform == "darwin" or bool(
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    )


def _open(address: str) -> None:
    """Open the browser without the library path that the ROS wheels need and it must not have."""
    kept = os.environ.pop("LD_LIBRARY_PATH", None)
    try:
        webbrowser.open(address)
    finally:
        if kept is not None:
            os.environ["LD_LIBRARY_PATH"] = kept
