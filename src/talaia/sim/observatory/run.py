"""``talaia sim observatory``: reads the command line, builds every server, ends them cleanly."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.sim.observatory.control_pipe import ControlPipe
from talaia.sim.observatory.request_log import RequestLog
from talaia.sim.observatory.servers.devices import DEVICES, ENCLOSURES, MONTSEC
from talaia.sim.startup import Start, join_ros, needing_ros, run_robot

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main", "make_parser"]


def make_parser() -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = argparse.ArgumentParser(
        prog="talaia sim observatory",
        description="A simulated observatory: dome, telescope, weather, camera, power, CCTV.",
    )
    parser.add_argument("--ros1", action="store_true", help="as ROS 1 nodes, with Debian's rospy")
    parser.add_argument(
        "--domain", type=int, help="ROS domain, 1 to 101, reserved by whoever starts this"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the weather (default 1)")
    parser.add_argument(
        "--only",
        action="append",
        choices=DEVICES,
        metavar="DEVICE",
        help=f"run only this server; may be repeated: {', '.join(DEVICES)}",
    )
    parser.add_argument(
        "--speed",
        type=float,
        default=1.0,
        metavar="FACTOR",
        help="factor by which everything moves faster, 1 to 20 (default 1); for tests",
    )
    parser.add_argument(
        "--longitude",
        type=float,
        default=MONTSEC.longitude,
        metavar="DEG",
        help=f"longitude of the site, -180 to 180 (default {MONTSEC.longitude})",
    )
    parser.add_argument(
        "--enclosure",
        choices=ENCLOSURES,
        default=ENCLOSURES[0],
        help="a dome that turns, or a clamshell of two shells that does not (default dome)",
    )
    parser.add_argument("--fits", type=Path, metavar="DIR", help="keep the pictures here")
    parser.add_argument("--log", type=Path, metavar="FILE", help="log every request (JSON lines)")
    parser.add_argument(
        "--orders",
        type=Path,
        metavar="PIPE",
        help="a named pipe that takes faults and manual operation, a line each; for tests",
    )
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run until SIGINT or SIGTERM.

    Prints one JSON line when all services are up: ``{"ready": true, "domain": …, "pid": …,
    "servers": […], "seconds": …}``.

    Returns:
        0 after a signal, 1 when it cannot run here, 2 for a wrong command line.

    """
    words = list(sys.argv[1:] if argv is None else argv)
    options = make_parser().parse_args(words)
    if not 1.0 <= options.speed <= 20.0:
        make_parser().error("--speed: expected a number from 1 to 20")
    if not -180.0 <= options.longitude <= 180.0:
        make_parser().error("--longitude: expected a number from -180 to 180")
    if options.ros1:
        from talaia.sim.observatory.ros1_start import run_ros1

        # The other Python reads the same words once more.
        return run_ros1("ros1_shell", [word for word in words if word != "--ros1"])
    return run_robot("sim observatory", options.domain, lambda start: _run_servers(options, start))


def _run_servers(options: argparse.Namespace, start: Start) -> None:
    """Build every part, last built first ended."""
    # With NumPy, which wrong words need not wait for.
    from talaia.sim.observatory.servers.catalog import make_server

    with needing_ros():
        from talaia.sim.observatory.ros2_shell import Shells
    names: list[str] = options.only or list(DEVICES)
    if options.fits is not None:
        options.fits.mkdir(parents=True, exist_ok=True)
    ledger = RequestLog(options.log)
    start.stack.callback(ledger.close)
    join_ros(start.stack)
    orders = ControlPipe(options.orders)
    start.stack.callback(orders.close)
    shells = Shells(options.fits, ledger, options.speed, orders)
    # Pushed last, so ended first: nodes go before ROS does.
    start.stack.callback(shells.close)
    place = MONTSEC._replace(longitude=options.longitude)
    for name in names:
        server = make_server(
            name,
            seed=options.seed,
            unix_s=time.time(),
            call=shells.call_server,
            place=place,
            roof=options.enclosure,
        )
        shells.add_server(server)
    shells.run(start.ended, lambda: start.say_ready(servers=names))
