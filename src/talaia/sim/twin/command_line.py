"""The words of ``talaia twin``, before anything is imported that runs it.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main", "parse_words"]


def main(argv: Sequence[str]) -> int:
    """Run the twin of a site until SIGINT or SIGTERM; see `run.run_twin`."""
    options = parse_words(argv)
    # The whole model and the vehicle: a quarter of a second of a core.
    from talaia.sim.twin.run import run_twin

    return run_twin(options)


def parse_words(argv: Sequence[str]) -> argparse.Namespace:
    """Read the options; wrong words and ``--help`` end the process."""
    parser = argparse.ArgumentParser(
        prog="talaia twin",
        description="Run the simulated vehicle beside the real one, following it.",
    )
    parser.add_argument("site", type=Path, help="the site description")
    parser.add_argument(
        "--device", default="", help="the twin's device; needed where there are several"
    )
    parser.add_argument(
        "--domain", type=int, help="ROS domain; by default the description's, or ROS_DOMAIN_ID"
    )
    parser.add_argument(
        "--house",
        type=int,
        metavar="SEED",
        help="its floor is the demo's house of this seed; without it an open floor",
    )
    parser.add_argument(
        "--print",
        action="store_true",
        help="print the device to add to the description, and run nothing",
    )
    return parser.parse_args(argv)
