"""``talaia demo``: a simulated vehicle and observatory, their gateways, the hub, its dashboard.

Beside them the observatory once more, which lives through its nights at high speed when asked to.
Long, because each robot of the demo is described, started and waited for here.
"""

from __future__ import annotations

import asyncio
import re
import time
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from talaia.cli.child_processes import ChildProcess, run_together, start_talaia
from talaia.cli.demo.session import (
    data_folder,
    find_example,
    is_changed,
    make_logins,
    print_greeting,
    write_description,
)
from talaia.cli.demo.time_lapse.lapse_site import TIME_LAPSE, lapse_site
from talaia.cli.errors import CliError
from talaia.cli.local_machine import free_port, has_screen, open_page
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.model.detection import DetectionSource
from talaia.model.twins.twin_topics import device_text, twins_of
from talaia.model.yaml_text.load import dump_site, load_site, read_site
from talaia.model.yaml_text.save import save_into_text
from talaia.objects.availability import detection_availability
from talaia.sim import ros_domain
from talaia.sim.observatory.night import at_night, longitude_of_night

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

__all__ = ["run_demo"]

VEHICLE, OBSERVATORY, TWIN = "agv", "observatory", "twin"
# What is added to the vehicle's example where the libraries for it are there.
RECORDING = """
# The topics of all signals, on demand and around STOP; any camera on demand.
recording: {before: 10, triggers: [stop]}
"""
# A small computer that is busy draws the first picture after a minute; what fails is told at once.
READY_S = 120.0


def run_demo(options: argparse.Namespace) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again.

    Args:
        options: as `talaia.cli.demo.command_line` reads them.

    """
    began = time.monotonic()
    with data_folder(options.data, "talaia-demo-") as data:
        asyncio.run(run_together(lambda parts: _start_robots(options, data, parts, began)))
    return 0


async def _start_robots(
    options: argparse.Namespace, data: Path, parts: list[ChildProcess], began: float
) -> None:
    port = free_port(options.port)
    address = f"http://localhost:{port}"
    # Simulators first: they start while the accounts are made.
    robots = [_start_vehicle(options, data, number) for number in range(1, options.vehicles + 1)]
    if not options.no_observatory:
        robots.append(_start_observatory(options, data))
    for robot in robots:
        name = f"simulated {robot.name}"
        parts.append(await start_talaia(name, robot.words, data / robot.log, robot.environment))
    if options.twin:
        parts.append(await _start_twin(robots[0], options.seed, data))
    settings = Settings(
        data=data, host="127.0.0.1", port=port, plain=True, database_url=Settings.url_from()
    )
    logins = await make_logins(settings)
    hub = ["hub", "--data", str(data), "--host", "127.0.0.1", "--port", str(port), "--plain"]
    hub += ["--simulated-site", OBSERVATORY, "--simulated-site", TIME_LAPSE]
    hub += [] if options.mqtt is None else ["--mqtt", str(options.mqtt)]
    gateways = [await _gateway_command(robot, settings) for robot in robots]
    parts.append(await start_talaia("hub", hub, data / "hub.log", restart=True))
    for robot, words in zip(robots, gateways, strict=True):
        suffix = "" if robot.site == VEHICLE else f"-{robot.site}"
        log = data / f"gateway{suffix}.log"
        name = f"gateway of the {robot.name}"
        parts.append(await start_talaia(name, words, log, robot.environment, restart=True))
    # The order of `parts`: robots, twin and hub, which say "ready", then the gateways.
    ready = len(robots) + options.twin + 1
    await asyncio.gather(
        *(part.wait_line("ready", READY_S) for part in parts[:ready]),
        *(part.wait_line("linked to", READY_S) for part in parts[ready:]),
    )
    if not options.no_observatory and not options.no_time_lapse:
        # Not waited for: nobody needs it before the first look around.
        words = await _time_lapse_command(options, settings)
        log = data / "time-lapse.log"
        parts.append(await start_talaia("time lapse", words, log, {}, restart=True))
    changed = [robot.description for robot in robots if robot.changed]
    blind = [
        sight
        for sight in detection_availability(read_site(robots[0].description), data)
        if not sight.well
    ]
    print_greeting(
        address,
        logins,
        data=data,
        took=time.monotonic() - began,
        changed=changed,
        notes=[sight.said for sight in blind],
    )
    if not options.no_browser and has_screen():
        await asyncio.to_thread(open_page, address)


async def _make_key(settings: Settings, site: str) -> Path:
    suffix = "" if site == VEHICLE else f"-{site}"
    key = settings.data / f"gateway{suffix}.key"
    key.write_text(await accounts.create_gateway(settings, site))
    # Whoever can read it can speak as this gateway.
    key.chmod(0o600)
    return key


class _Robot(NamedTuple):
    """A simulated robot: the site it plays, its description, and how it is started.

    ``changed``: the description is not the example, for somebody changed it in an earlier run.
    """

    # Short name of the site, by which its key and its log are named.
    site: str
    description: Path
    changed: bool
    name: str
    words: list[str]
    log: str
    # ROS domain that robot and gateway share with nobody else.
    domain: int
    environment: dict[str, str]


def _start_vehicle(options: argparse.Namespace, data: Path, number: int = 1) -> _Robot:
    """Start the first one, or one beside it: a site of its own with another seed."""
    suffix = "" if number == 1 else str(number)
    site = f"{VEHICLE}{suffix}"
    world = ros_domain.reserve_domain().domain  # kept until this process ends
    words = ["sim", "vehicle", "--domain", str(world), "--seed", str(options.seed + number - 1)]
    words += ["--log", str(data / f"actuations{suffix}.jsonl")]
    words += ["--no-camera"] if options.no_camera else []
    # A copy: it may be changed from the page, and is then somebody's work.
    description = data / f"{site}.yaml"
    changed = is_changed(description)
    if not changed:
        text = find_example(VEHICLE).read_text()
        # Without them its gateway would not start: what is to be recorded must be.
        text += RECORDING if find_spec("mcap") and find_spec("av") else ""
        text = _without_detections(text) if options.no_camera else text
        text = _with_twin(text) if options.twin and number == 1 else text
        write_description(description, text if number == 1 else _renamed(text, site, number))
    here = ros_domain.domain_environment(world)
    log = f"sim{suffix}.log"
    return _Robot(site, description, changed, f"vehicle {suffix}".strip(), words, log, world, here)


def _renamed(text: str, site: str, number: int) -> str:
    """Give one of several vehicles a name of its own."""
    described = load_site(text)
    return save_into_text(text, replace(described, site=site, name=f"{described.name} {number}"))


def _with_twin(text: str) -> str:
    """Add a twin of the vehicle's base, and let pages see where it is."""
    device = device_text(TWIN, "base")
    # After the first device, which is what it is of.
    text = re.sub(r"\n\n(?=  \w+:\n)", f"\n\n{device}\n", text, count=1)
    return text.replace(
        "\ntopics:\n", f"\ntopics:\n  - {{pattern: /{TWIN}/odom, right: view}}\n", 1
    )


async def _start_twin(robot: _Robot, seed: int, data: Path) -> ChildProcess:
    """Start it in the vehicle's house, so that walls stop both."""
    if not twins_of(read_site(robot.description)):
        raise CliError(
            f"{robot.description.name} was changed in an earlier run and has no twin; add what "
            f"`talaia twin {robot.description} --print` prints, or run without --twin"
        )
    words = ["twin", str(robot.description), "--domain", str(robot.domain), "--house", str(seed)]
    return await start_talaia("digital twin", words, data / "twin.log", robot.environment)


def _without_detections(text: str) -> str:
    """Take away what goes by the pictures of a camera that is not there."""
    site = load_site(text)
    camera = site.devices["camera"]
    streams = {name: replace(stream, detect=None) for name, stream in camera.streams.items()}
    # Names of signals that count what the camera sees.
    seen = {
        name
        for name, signal in camera.signals.items()
        if isinstance(signal.source, DetectionSource)
    }
    signals = {name: signal for name, signal in camera.signals.items() if name not in seen}
    # Their addresses; rules that go by them would be mistakes of the description.
    gone = {f"camera/{name}" for name in seen}
    without = replace(
        site,
        devices={**site.devices, "camera": replace(camera, signals=signals, streams=streams)},
        interlocks={
            name: rule
            for name, rule in site.interlocks.items()
            if not any(condition.signal in gone for condition in rule.when)
        },
        alarms={name: alarm for name, alarm in site.alarms.items() if alarm.signal not in gone},
    )
    return save_into_text(text, without)


def _start_observatory(options: argparse.Namespace, data: Path) -> _Robot:
    # A domain of its own: two robots in one would be one robot.
    world = ros_domain.reserve_domain().domain
    words = ["sim", "observatory", "--domain", str(world), "--seed", str(options.seed)]
    words += ["--log", str(data / "observatory.jsonl"), "--fits", str(data / "fits")]
    # It observes by night only, and somewhere it is night.
    now = time.time()
    words += ["--longitude", str(longitude_of_night(now))]
    description = data / "observatory.yaml"
    changed = is_changed(description)
    if changed:
        # Somebody's work, but its place must still be where it is night now.
        text = description.read_text()
        description.write_text(save_into_text(text, at_night(read_site(description), now)))
    else:
        write_description(
            description, dump_site(at_night(read_site(find_example(OBSERVATORY)), now))
        )
    here = ros_domain.domain_environment(world)
    return _Robot(
        OBSERVATORY, description, changed, "observatory", words, "observatory.log", world, here
    )


async def _time_lapse_command(options: argparse.Namespace, settings: Settings) -> list[str]:
    """Write its description and its key, and give the words that start it."""
    data = settings.data
    description = data / f"{TIME_LAPSE}.yaml"
    site = lapse_site(read_site(find_example(OBSERVATORY)), time.time())
    description.write_text(dump_site(site))
    key = await _make_key(settings, TIME_LAPSE)
    words = ["demo", "time-lapse", str(description), "--hub", f"ws://127.0.0.1:{settings.port}"]
    words += ["--key-file", str(key), "--data", str(data / f"gateway-{TIME_LAPSE}")]
    return [*words, "--seed", str(options.seed)]


async def _gateway_command(robot: _Robot, settings: Settings) -> list[str]:
    """Make a gateway's key and give the words that start it."""
    suffix = "" if robot.site == VEHICLE else f"-{robot.site}"
    key = await _make_key(settings, robot.site)
    return [
        "gateway",
        str(robot.description),
        "--hub",
        f"ws://127.0.0.1:{settings.port}",
        "--key-file",
        str(key),
        "--allow-plain",
        "--data",
        str(settings.data / f"gateway{suffix}"),
        "--ros-domain",
        str(robot.domain),
        # The demo shows that too: everything may be changed on the page.
        "--accept-changes",
        "all",
    ]
