"""Starts the simulated vehicle: reads the command line, builds every part, ends them cleanly."""

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

from talaia.clock import SystemClock
from talaia.sim.domain import environment, reserve
from talaia.sim.errors import RosMissing, SimError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["arguments", "main"]


def arguments() -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = argparse.ArgumentParser(
        prog="talaia sim vehicle",
        description="A simulated TurtleBot3-like vehicle in a furnished house, as ROS 2 topics.",
    )
    parser.add_argument(
        "--domain",
        type=int,
        help="ROS domain, 1 to 101, reserved by whoever starts this; "
        "without it a free one is reserved and named in the line that says ready",
    )
    parser.add_argument("--seed", type=int, default=0, help="the house and its noise (default 0)")
    parser.add_argument(
        "--log", type=Path, metavar="FILE", help="write every actuation as JSON lines"
    )
    parser.add_argument(
        "--no-camera", action="store_true", help="no pictures, and no renderer needed"
    )
    parser.add_argument(
        "--camera-rate", type=float, default=30.0, help="pictures a second at most (default 30)"
    )
    parser.add_argument("--wander", action="store_true", help="drive about from the start")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the vehicle until SIGINT or SIGTERM.

    Prints one JSON line when all topics are up: ``{"ready": true, "domain": …, "pid": …,
    "camera": "egl" | "osmesa" | null, "seconds": …}``.

    Returns:
        0 after a signal, 1 when it cannot run here, 2 for a wrong command line.

    """
    options = arguments().parse_args(argv)
    if not 0.1 <= options.camera_rate <= 60.0:
        arguments().error("--camera-rate: expected a number from 0.1 to 60")
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
    # It reports at length which accelerators it does without.
    logging.getLogger("OpenGL").setLevel(logging.WARNING)
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
        sys.stderr.write(f"talaia sim vehicle: {error}\n")
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

        from talaia.sim.vehicle import node as shell
        from talaia.sim.vehicle.actuation_log import ActuationLog
        from talaia.sim.vehicle.base import Base
        from talaia.sim.vehicle.eye import Eye
        from talaia.sim.vehicle.world import World
    except ImportError as error:
        raise RosMissing(str(error)) from error

    clock = SystemClock()
    log = ActuationLog(options.log, clock)
    stack.callback(log.close)
    eye = None
    if not options.no_camera:
        eye = Eye(options.seed, options.camera_rate)
        stack.callback(eye.close)
    world = World(options.seed)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    stack.callback(rclpy.try_shutdown)
    node = rclpy.create_node("vehicle", enable_rosout=False, start_parameter_services=False)
    stack.callback(node.destroy_node)
    base = Base(wandering=options.wander)
    lock = threading.Lock()
    loop = shell.Loop(node, world, base, lock, log, clock, seed=options.seed, eye=eye)
    inputs = shell.Inputs(node, base, lock, log, clock)
    way = eye.wait() if eye else None
    inputs.start()
    stack.callback(inputs.close)

    def say_ready() -> None:
        line = {
            "ready": True,
            "domain": domain,
            "pid": os.getpid(),
            "camera": way,
            "seconds": round(time.monotonic() - began, 2),
        }
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()

    loop.run(ended, say_ready)
