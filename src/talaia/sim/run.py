"""``talaia sim``: runs a simulated robot by its name."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.sim.vehicle.drives.raw_listening import RawListening

__all__ = ["ROBOTS", "main", "parse_words"]

# Modules with a ``main(argv)``, imported only for the one that is named.
ROBOTS = {
    "vehicle": (
        "talaia.sim.vehicle.run",
        "a TurtleBot3-like vehicle in a furnished house, as ROS 2 nodes",
    ),
    "observatory": (
        "talaia.sim.observatory.run",
        "dome, telescope, weather, camera, power and CCTV, as ROS 2 or ROS 1 nodes",
    ),
    "run": (
        "talaia.sim.observatory.client",
        "a program of the observatory, in place of `ros2 run`",
    ),
}


def parse_words(argv: Sequence[str]) -> None:
    """Refuse wrong words, which end the process; a program of the observatory has its own."""
    name = argv[0] if argv else ""
    if name not in ROBOTS:
        raise SystemExit(main(argv))
    make_parser = getattr(importlib.import_module(ROBOTS[name][0]), "make_parser", None)
    if make_parser is not None:
        make_parser().parse_args(argv[1:])


def main(argv: Sequence[str], listen: RawListening | None = None) -> int:
    """Run the robot that is named; 2 when there is none of that name.

    Args:
        argv: its name, and its own command line.
        listen: hears types whose package is not installed; None where nothing can.

    """
    name = argv[0] if argv else "--help"
    if name == "vehicle":
        from talaia.sim.vehicle import run as vehicle

        return vehicle.main(argv[1:], listen)
    if name in ROBOTS:
        done: int = importlib.import_module(ROBOTS[name][0]).main(argv[1:])
        return done
    rows = "\n".join(f"  {name:<12} {what}" for name, (_, what) in ROBOTS.items())
    usage = f"usage: talaia sim ROBOT …\n\n{rows}\n\ntalaia sim ROBOT --help shows its options.\n"
    if name in ("-h", "--help"):
        sys.stdout.write(usage)
        raise SystemExit(0)
    sys.stderr.write(f"talaia sim: unknown robot {name!r}\n\n{usage}")
    return 2
