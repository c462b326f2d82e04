"""``talaia sim``: runs a simulated robot by its name."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from talaia.sim.observatory import client as programs, run as observatory
from talaia.sim.vehicle import run as vehicle

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.sim.vehicle.drives.raw_listening import RawListening

__all__ = ["ROBOTS", "main"]

ROBOTS: dict[str, tuple[Callable[[Sequence[str]], int], str]] = {
    "vehicle": (vehicle.main, "a TurtleBot3-like vehicle in a furnished house, as ROS 2 nodes"),
    "observatory": (
        observatory.main,
        "dome, telescope, weather, camera, power and CCTV, as ROS 2 or ROS 1 nodes",
    ),
    "run": (programs.main, "a program of the observatory, in place of `ros2 run`"),
}


def main(argv: Sequence[str], listen: RawListening | None = None) -> int:
    """Run the robot that is named; 2 when there is none of that name.

    Args:
        argv: its name, and its own command line.
        listen: hears types whose package is not installed; None where nothing can.

    """
    name = argv[0] if argv else "--help"
    if name == "vehicle":
        return vehicle.main(argv[1:], listen)
    if name in ROBOTS:
        return ROBOTS[name][0](argv[1:])
    rows = "\n".join(f"  {name:<12} {what}" for name, (_, what) in ROBOTS.items())
    usage = f"usage: talaia sim ROBOT …\n\n{rows}\n\ntalaia sim ROBOT --help shows its options.\n"
    if name in ("-h", "--help"):
        sys.stdout.write(usage)
        raise SystemExit(0)
    sys.stderr.write(f"talaia sim: unknown robot {name!r}\n\n{usage}")
    return 2
