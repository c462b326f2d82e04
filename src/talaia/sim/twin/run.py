"""Starts a twin: reads the description, builds every part, ends them cleanly."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.model.checks.site_checks import raise_first
from talaia.model.connection import Ros2Connection
from talaia.model.twins.twin_topics import device_text, position_source, twins_of
from talaia.model.yaml_text.load import load_site
from talaia.sim.errors import NoTwin
from talaia.sim.startup import Start, join_ros, needing_ros, run_robot

if TYPE_CHECKING:
    import argparse
    from pathlib import Path

    from talaia.model.site import Site

__all__ = ["run_twin"]


def run_twin(options: argparse.Namespace) -> int:
    """Run the twin of a site until SIGINT or SIGTERM.

    Prints one JSON line when all topics are up: ``{"ready": true, "domain": …, "pid": …}``.

    Returns:
        0 after a signal, 1 when it cannot run here.

    Raises:
        DescriptionError: the description has mistakes.
        NoTwin: it describes no twin of that name, or none at all.

    """
    site = raise_first(load_site(_read_text(options.site)))
    if options.print:
        driven = [name for name, device in site.devices.items() if device.drive is not None]
        if not driven:
            raise NoTwin("the description drives no device")
        sys.stdout.write(device_text("twin", driven[0]))
        return 0
    name = _choose_twin(site, options.device)
    domain = options.domain if options.domain is not None else _domain_of(site, name)
    return run_robot(
        "twin",
        domain,
        lambda start: _run_twin(site, name, start, house=options.house),
        shared=True,
    )


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise NoTwin(f"{path} cannot be read: {error}") from error


def _choose_twin(site: Site, asked: str) -> str:
    names = [name for name, _ in twins_of(site).values()]
    if not names:
        raise NoTwin("the description has no twin; talaia twin SITE --print writes one to add")
    if asked:
        if asked not in names:
            raise NoTwin(f"{asked!r} is no twin; there is {', '.join(names)}")
        return asked
    if len(names) > 1:
        raise NoTwin(f"there are several twins: name one with --device ({', '.join(names)})")
    return names[0]


def _domain_of(site: Site, name: str) -> int | None:
    link = site.links()[site.connection_of(name)]
    return link.domain if isinstance(link, Ros2Connection) else None


def _run_twin(site: Site, name: str, start: Start, *, house: int | None) -> None:
    """Build every part, last built first ended."""
    with needing_ros():
        import rclpy

        from talaia.sim.twin.follower import TwinFollower
        from talaia.sim.twin.node import TwinNode
        from talaia.sim.vehicle.world import World

    twin = site.devices[name].twin
    drive = None if twin is None else site.devices[twin.of].drive
    odometry = None if twin is None else position_source(site, twin.of)
    # The check has seen to it; without it the twin would stand and say nothing.
    if twin is None or drive is None or odometry is None:
        raise NoTwin(f"{name!r} cannot be run; see: talaia check")
    world = World(
        house or 0,
        friction=twin.friction,
        track_width=twin.track_width,
        furnished=house is not None,
    )
    join_ros(start.stack)
    node = rclpy.create_node(f"{name}_twin", enable_rosout=False, start_parameter_services=False)
    start.stack.callback(node.destroy_node)
    shell = TwinNode(
        node,
        name=name,
        drive=drive,
        odometry=odometry.topic,
        world=world,
        follower=TwinFollower(twin),
        clock=SystemClock(),
    )
    start.stack.callback(shell.close)
    shell.run(start.ended, start.say_ready)
