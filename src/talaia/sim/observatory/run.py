"""``talaia sim observatory``: reads the command line, builds every server, ends them cleanly."""

from __future__ import annotations

import argparse
import json
import logging
import os
import signal
import sys
import threading
import time
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.sim.domain import environment, reserve
from talaia.sim.errors import RosMissing, SimError
from talaia.sim.observatory.ledger import Ledger
from talaia.sim.observatory.servers import DEVICES, MONTSEC, make

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.sim.observatory.ros2_shell import Shells

__all__ = ["arguments", "main"]


def arguments() -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = argparse.ArgumentParser(
        prog="talaia sim observatory",
        description="A simulated observatory: dome, telescope, weather, camera, power, CCTV.",
    )
    parser.add_argument("--ros1", action="store_true", help="as ROS 1 nodes, by Debian's rospy")
    parser.add_argument(
        "--domain", type=int, help="ROS domain, 1 to 101, reserved by whoever starts this"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the weather (default 1)")
    parser.add_argument(
        "--only", action="append", choices=DEVICES, metavar="DEVICE",
        help=f"only this server, may be given again: {', '.join(DEVICES)}",
    )  # fmt: skip
    parser.add_argument(
        "--speed", type=float, default=1.0, metavar="FACTOR",
        help="everything moves so many times faster, 1 to 20 (default 1); for tests",
    )  # fmt: skip
    parser.add_argument(
        "--longitude", type=float, default=MONTSEC.longitude, metavar="DEG",
        help=f"where it stands, -180 to 180 (default {MONTSEC.longitude})",
    )  # fmt: skip
    parser.add_argument("--fits", type=Path, metavar="DIR", help="keep the pictures here")
    parser.add_argument("--log", type=Path, metavar="FILE", help="write what is asked (JSON lines)")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run until SIGINT or SIGTERM.

    Prints one JSON line when all services are up: ``{"ready": true, "domain": …, "pid": …,
    "servers": […], "seconds": …}``.

    Returns:
        0 after a signal, 1 when it cannot run here, 2 for a wrong command line.

    """
    words = list(sys.argv[1:] if argv is None else argv)
    options = arguments().parse_args(words)
    if not 1.0 <= options.speed <= 20.0:
        arguments().error("--speed: expected a number from 1 to 20")
    if not -180.0 <= options.longitude <= 180.0:
        arguments().error("--longitude: expected a number from -180 to 180")
    if options.ros1:
        from talaia.sim.observatory.ros1_start import run_ros1

        return run_ros1("ros1_shell", [word for word in words if word != "--ros1"])
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
    ended = threading.Event()
    try:
        with ExitStack() as stack:
            for number in (signal.SIGINT, signal.SIGTERM):
                before = signal.signal(number, lambda *_: ended.set())
                stack.callback(signal.signal, number, before)
            domain = options.domain
            if domain is None:
                domain = stack.enter_context(reserve()).domain
            os.environ.update(environment(domain))
            _run(options, domain, ended, stack)
    except (SimError, OSError) as error:
        sys.stderr.write(f"talaia sim observatory: {error}\n")
        return 1
    return 0


def _run(
    options: argparse.Namespace, domain: int, ended: threading.Event, stack: ExitStack
) -> None:
    """Build every part, last built first ended."""
    began = time.monotonic()
    # Wheels of ROS need their library path before anything of ROS is imported; a ROS installation
    # of the machine brings its own.
    with suppress(ImportError):
        import ros_wheels_bootstrapper  # noqa: F401
    try:
        import rclpy
        from rclpy.signals import SignalHandlerOptions

        from talaia.sim.observatory.ros2_shell import Shells
    except ImportError as error:
        raise RosMissing(str(error)) from error
    names: list[str] = options.only or list(DEVICES)
    if options.fits is not None:
        options.fits.mkdir(parents=True, exist_ok=True)
    ledger = Ledger(options.log)
    stack.callback(ledger.close)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    stack.callback(rclpy.try_shutdown)
    shells: Shells = Shells(options.fits, ledger, options.speed)
    stack.callback(shells.close)
    place = MONTSEC._replace(longitude=options.longitude)
    for name in names:
        server = make(name, seed=options.seed, unix_s=time.time(), call=shells.call, place=place)
        shells.add(server)

    def say_ready() -> None:
        line = {
            "ready": True,
            "domain": domain,
            "pid": os.getpid(),
            "servers": names,
            "seconds": round(time.monotonic() - began, 2),
        }
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()

    shells.run(ended, say_ready)
