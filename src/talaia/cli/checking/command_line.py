"""The words of ``talaia check``, before anything is imported that checks.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main", "make_parser"]


def make_parser() -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = argparse.ArgumentParser(
        "talaia check", description="Check site descriptions and report what is wrong, and where."
    )
    parser.add_argument("file", type=Path, nargs="+", help="a site description (YAML)")
    parser.add_argument(
        "--json", action="store_true", help="print the mistakes as JSON, for editors"
    )
    return parser


def main(argv: Sequence[str]) -> int:
    """Check each file; 0 when all are right, 1 when one is not."""
    options = make_parser().parse_args(argv)
    # The whole model with its units: half a second of a core.
    from talaia.cli.checking.check import check_files

    return check_files(options.file, as_json=options.json)
