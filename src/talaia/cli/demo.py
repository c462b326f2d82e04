"""``talaia demo``: a simulated vehicle and observatory, their gateways, the hub, its dashboard."""

from __future__ import annotations

import argparse
import asyncio
import importlib.util
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from talaia.cli.demonstration import example, folder, greet, make_logins
from talaia.cli.errors import PartMissing
from talaia.cli.parts import Part, run_together, start
from talaia.cli.places import DEFAULT_PORT, free_port, has_screen, open_page
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.model.load import dump_site, read_site
from talaia.sim import domain
from talaia.sim.observatory.night import at_night, longitude_of_night

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

VEHICLE, OBSERVATORY = "agv", "observatory"


def main(argv: Sequence[str]) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again."""
    options = _options(argv)
    for module in ("rclpy", "mujoco"):
        if importlib.util.find_spec(module) is None:
            raise PartMissing("talaia demo", module, "hub,sim")
    began = time.monotonic()
    with folder(options.data, "talaia-demo-") as data:
        asyncio.run(run_together(lambda parts: _start(options, data, parts, began)))
    return 0


def _options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia demo",
        description="Start a simulated vehicle and a simulated observatory, their gateways, the "
        "hub and the dashboard.",
    )
    parser.add_argument(
        "--port", type=int, default=0, help=f"of the dashboard (default: {DEFAULT_PORT} or next)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the simulated world (default: 1)")
    parser.add_argument("--data", type=Path, help="keep accounts and history in this folder")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument("--no-camera", action="store_true", help="simulate without pictures")
    parser.add_argument("--no-observatory", action="store_true", help="only the vehicle")
    return parser.parse_args(argv)


async def _start(options: argparse.Namespace, data: Path, parts: list[Part], began: float) -> None:
    port = free_port(options.port)
    address = f"http://localhost:{port}"
    robots = [_vehicle(options, data)]
    if not options.no_observatory:
        robots.append(_observatory(options, data))
    for robot in robots:
        name = f"simulated {robot.name}"
        parts.append(await start(name, robot.words, data / robot.log, robot.environment))
    settings = Settings(
        data=data, host="127.0.0.1", port=port, plain=True, database_url=Settings.url_from()
    )
    logins = await make_logins(settings)
    hub = ["hub", "--data", str(data), "--host", "127.0.0.1", "--port", str(port), "--plain"]
    gateways = [await _gateway(robot, settings) for robot in robots]
    parts.append(await start("hub", hub, data / "hub.log"))
    for robot, words in zip(robots, gateways, strict=True):
        suffix = "" if robot.site == VEHICLE else f"-{robot.site}"
        log = data / f"gateway{suffix}.log"
        parts.append(await start(f"gateway of the {robot.name}", words, log, robot.environment))
    ready = len(robots) + 1
    await asyncio.gather(
        *(part.says("ready", 30) for part in parts[:ready]),
        *(part.says("linked to", 30) for part in parts[ready:]),
    )
    greet(address, logins, data, time.monotonic() - began)
    if not options.no_browser and has_screen():
        await asyncio.to_thread(open_page, address)


class _Robot(NamedTuple):
    """A simulated robot: the site it plays, its description, and how it is started."""

    site: str
    description: Path
    name: str
    words: list[str]
    log: str
    domain: int
    environment: dict[str, str]


def _vehicle(options: argparse.Namespace, data: Path) -> _Robot:
    world = domain.reserve().domain  # kept until this process ends
    words = ["sim", "vehicle", "--domain", str(world), "--seed", str(options.seed)]
    words += ["--log", str(data / "actuations.jsonl")]
    words += ["--no-camera"] if options.no_camera else []
    # A copy: it may be changed from the page.
    description = data / "agv.yaml"
    description.write_text(example(VEHICLE).read_text())
    return _Robot(
        VEHICLE, description, "vehicle", words, "sim.log", world, domain.environment(world)
    )


def _observatory(options: argparse.Namespace, data: Path) -> _Robot:
    # A domain of its own: two robots in one would be one robot.
    world = domain.reserve().domain
    words = ["sim", "observatory", "--domain", str(world), "--seed", str(options.seed)]
    words += ["--log", str(data / "observatory.jsonl"), "--fits", str(data / "fits")]
    # It observes by night only, and somewhere it is night.
    now = time.time()
    words += ["--longitude", str(longitude_of_night(now))]
    description = data / "observatory.yaml"
    description.write_text(dump_site(at_night(read_site(example(OBSERVATORY)), now)))
    here = domain.environment(world)
    return _Robot(OBSERVATORY, description, "observatory", words, "observatory.log", world, here)


async def _gateway(robot: _Robot, settings: Settings) -> list[str]:
    """Make a gateway's key and give the words that start it."""
    suffix = "" if robot.site == VEHICLE else f"-{robot.site}"
    key = settings.data / f"gateway{suffix}.key"
    key.write_text(await accounts.create_gateway(settings, robot.site))
    key.chmod(0o600)
    return [
        "gateway", str(robot.description), "--hub", f"ws://127.0.0.1:{settings.port}",
        "--key-file", str(key), "--allow-plain", "--data", str(settings.data / f"gateway{suffix}"),
        "--ros-domain", str(robot.domain), "--accept-changes", "all",
    ]  # fmt: skip
