"""The words of ``talaia anomalies``, before anything is imported that judges.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]

_LEARN_ROWS = 400
# Those of `judges.DETECTORS`, which knows them with all that they reckon; a test holds both.
DETECTOR_NAMES = (
    *("group", "together", "change", "nearest", "season", "baseline"),
    *("context", "iqr", "still", "rate"),
)


def main(argv: Sequence[str]) -> int:
    """Judge a table and print what is said of it; 0: it was judged."""
    options = _parse_options(argv)
    # Detectors with their arrays: a third of a second of a core.
    from talaia.cli.anomalies.main import judge_table

    return judge_table(options)


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia anomalies", description="Try anomaly detectors on tables of signals."
    )
    what = parser.add_subparsers(dest="what", required=True)
    backtest = what.add_parser(
        "backtest",
        help="print what a detector would have said of a CSV file",
        description="Judge a CSV file with a heading, a column of times and one for each signal,"
        " row by row as if it came live, and print the anomalies as CSV. Columns called anomaly,"
        " changepoint or label are not looked at.",
    )
    backtest.add_argument("file", type=Path, metavar="FILE.csv", help="UTF-8; , ; or tabs between")
    backtest.add_argument(
        "--detector",
        choices=DETECTOR_NAMES,
        default=DETECTOR_NAMES[0],
        metavar="NAME",
        help="group: all signals together (default); on each signal: "
        + ", ".join(DETECTOR_NAMES[1:]),
    )
    backtest.add_argument(
        "--learn-rows",
        type=int,
        default=_LEARN_ROWS,
        metavar="N",
        help="first rows, of which nothing is told; nothing should be wrong in them (400)",
    )
    backtest.add_argument(
        "--rows", action="store_true", help="print time,score,anomalous,signals of each row"
    )
    backtest.add_argument("--time", default="", metavar="HEADING", help="column of the times")
    backtest.add_argument(
        "--signals", nargs="+", metavar="HEADING", help="only these columns (default: all)"
    )
    backtest.add_argument(
        "--ignore", nargs="+", default=[], metavar="HEADING", help="columns that are no signals"
    )
    backtest.add_argument(
        "--zone", default="UTC", metavar="ZONE", help="of times that say none (UTC)"
    )
    return parser.parse_args(argv)
