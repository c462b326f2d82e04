"""The words of ``talaia demo-indi``, before anything is imported that runs it.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Run until Ctrl-C; everything it started is ended and removed again."""
    options = _parse_options(argv)
    # The hub's accounts and the simulated weather: a second of a core.
    from talaia.cli.demo.indi import run_indi_demo

    return run_indi_demo(options)


def _parse_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia demo-indi",
        description="Start INDI's own simulators of an observatory, a gateway, the hub and the "
        "dashboard.",
    )
    parser.add_argument("--port", type=int, default=0, help="of the dashboard (default: a free)")
    parser.add_argument("--data", type=Path, help="keep accounts, history and pictures here")
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    return parser.parse_args(argv)
