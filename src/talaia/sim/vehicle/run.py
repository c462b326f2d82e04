"""Starts the simulated vehicle: reads the command line, builds every part, ends them cleanly."""

from __future__ import annotations

import argparse
import logging
import threading
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.clock import SystemClock
from talaia.sim.startup import Start, join_ros, needing_ros, run_robot
from talaia.sim.vehicle.drives.kinematics import DriveKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.sim.vehicle.drives.raw_listening import RawListening

__all__ = ["main", "make_parser"]


def make_parser() -> argparse.ArgumentParser:
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
    parser.add_argument(
        "--friction",
        type=float,
        default=0.0,
        help="rolling friction of the wheels, N per m/s (default 0; 40 costs 9 %% of the speed)",
    )
    parser.add_argument(
        "--drive",
        choices=[kind.value for kind in DriveKind],
        default=DriveKind.DIFFERENTIAL.value,
        help="its wheels: two that turn it on the spot (default), four that move it sideways too "
        "(Twist with linear.y), or steered ones (Twist, and AckermannDriveStamped on "
        "/ackermann_cmd)",
    )
    parser.add_argument(
        "--arm",
        action="store_true",
        help="a small arm of three joints on it, moved by velocities on "
        "/arm_velocity_controller/commands (Float64MultiArray)",
    )
    parser.add_argument("--wander", action="store_true", help="drive about from the start")
    return parser


def main(argv: Sequence[str] | None = None, listen: RawListening | None = None) -> int:
    """Run the vehicle until SIGINT or SIGTERM.

    Args:
        argv: the command line.
        listen: hears types whose package is not installed; None where nothing can.

    Prints one JSON line when all topics are up: ``{"ready": true, "domain": …, "pid": …,
    "camera": "egl" | "osmesa" | null, "seconds": …}``.

    Returns:
        0 after a signal, 1 when it cannot run here, 2 for a wrong command line.

    """
    options = make_parser().parse_args(argv)
    if not 0.1 <= options.camera_rate <= 60.0:
        make_parser().error("--camera-rate: expected a number from 0.1 to 60")
    if not 0.0 <= options.friction <= 1000.0:
        make_parser().error("--friction: expected a number from 0 to 1000")
    if options.wander and options.drive == DriveKind.ACKERMANN:
        make_parser().error("--wander: turns on the spot, and steered wheels do not")
    # It reports at length which accelerators it does without.
    logging.getLogger("OpenGL").setLevel(logging.WARNING)
    return run_robot(
        "sim vehicle", options.domain, lambda start: _run_vehicle(options, start, listen)
    )


def _run_vehicle(options: argparse.Namespace, start: Start, listen: RawListening | None) -> None:
    """Build every part, last built first ended."""
    with needing_ros():
        import rclpy

        from talaia.sim.vehicle import node as shell
        from talaia.sim.vehicle.actuation_log import ActuationLog
        from talaia.sim.vehicle.base import Base
        from talaia.sim.vehicle.camera_process import CameraProcess
        from talaia.sim.vehicle.drives.jogged_arm import JoggedArm
        from talaia.sim.vehicle.world import World

    clock = SystemClock()
    log = ActuationLog(options.log, clock)
    start.stack.callback(log.close)
    eye = None
    # Early: its process builds its world while this one builds another.
    if not options.no_camera:
        eye = CameraProcess(options.seed, options.camera_rate)
        start.stack.callback(eye.close)
    world = World(options.seed, friction=options.friction)
    join_ros(start.stack)
    node = rclpy.create_node("vehicle", enable_rosout=False, start_parameter_services=False)
    start.stack.callback(node.destroy_node)
    drive = DriveKind(options.drive)
    base = Base(wandering=options.wander, drive=drive)
    arm = JoggedArm() if options.arm else None
    # Of `base` and `arm`: commands come in one thread, and time passes in another.
    lock = threading.Lock()
    inputs = shell.Inputs(node, base=base, lock=lock, log=log, clock=clock, arm=arm, listen=listen)
    loop = shell.Loop(
        node,
        world=world,
        base=base,
        lock=lock,
        log=log,
        clock=clock,
        seed=options.seed,
        eye=eye,
        inputs=inputs,
        drive=drive,
        arm=arm,
    )
    way = eye.wait_ready() if eye else None
    inputs.start()
    start.stack.callback(inputs.close)

    loop.run(start.ended, lambda: start.say_ready(camera=way))
