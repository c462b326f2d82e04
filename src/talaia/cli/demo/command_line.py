"""The words of ``talaia demo``, before anything is imported that runs it.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.errors import PartMissing
from talaia.cli.local_machine import DEFAULT_PORT

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main", "parse_words"]


def main(argv: Sequence[str]) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again."""
    # It has options of its own, and is started by the demo.
    if argv and argv[0] == "time-lapse":
        from talaia.cli.demo.time_lapse.main import main as run_time_lapse

        return run_time_lapse(argv[1:])
    options = _parse_options(argv)
    for module in ("rclpy", "mujoco"):
        if importlib.util.find_spec(module) is None:
            raise PartMissing("talaia demo", module, "hub,sim")
    # The hub's accounts and the simulators: a second of a core.
    from talaia.cli.demo.ros2 import run_demo

    return run_demo(options)


def parse_words(argv: Sequence[str]) -> None:
    """Refuse wrong words, which end the process."""
    if argv[:1] != ["time-lapse"]:
        _parse_options(argv)


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
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
    parser.add_argument(
        "--vehicles",
        type=int,
        choices=range(1, 5),
        default=1,
        help="how many vehicles, each in a house of its own (default: 1)",
    )
    parser.add_argument("--no-camera", action="store_true", help="simulate without pictures")
    parser.add_argument(
        "--twin", action="store_true", help="a digital twin beside the (first) vehicle"
    )
    parser.add_argument("--no-observatory", action="store_true", help="only the vehicle")
    parser.add_argument(
        "--no-time-lapse", action="store_true", help="without the nights at high speed"
    )
    parser.add_argument(
        "--mqtt", type=Path, metavar="FILE", help="of `talaia hub`: publish to an MQTT broker"
    )
    return parser.parse_args(argv)
