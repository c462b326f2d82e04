"""The words of ``talaia plan``, before anything is imported that plans.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Plan; 0 when done."""
    parser = argparse.ArgumentParser(
        "talaia plan", description="Plan a night of one telescope (files of talaia-night/1)."
    )
    words = parser.add_subparsers(dest="word", required=True)
    drive = words.add_parser("drive", help="answer a judge's lines on standard input")
    night = words.add_parser("night", help="print the plan of a clear night, and its bound")
    night.add_argument("file", type=Path, help="a night (JSON)")
    for word in (drive, night):
        word.add_argument(
            "--fair",
            action="store_true",
            help="hold proposals to their shares; costs some of the value",
        )
    options = parser.parse_args(argv)
    # The planner with its arrays, which --help and wrong words do not wait for.
    from talaia.cli.planning.main import answer_lines, print_night
    from talaia.planner.fairness import EVEN_HANDED, INDIFFERENT

    fairness = EVEN_HANDED if options.fair else INDIFFERENT
    if options.word == "drive":
        return answer_lines(sys.stdin.buffer, sys.stdout.buffer, fairness)
    return print_night(options.file, fairness)
