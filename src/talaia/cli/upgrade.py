"""``talaia upgrade``: write an older site description as it is written today."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.version import FORMAT

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Show what would change, or write it; 0 when all are as they should be, else 1.

    With ``--write`` a description that still has mistakes is written all the same, for they were
    there before; the mistakes are told.
    """
    parser = argparse.ArgumentParser(
        "talaia upgrade",
        description=f"Upgrade site descriptions to the newest format (version {FORMAT}). Comments "
        "stay. Shows what would change; --write changes it.",
    )
    parser.add_argument("file", type=Path, nargs="+", help="a site description (YAML)")
    parser.add_argument("--write", action="store_true", help="change the file")
    options = parser.parse_args(argv)
    # The whole model, which --help and wrong words do not wait for.
    from talaia.cli.describing.upgrade_file import upgrade_file

    left = 0
    for path in options.file:
        try:
            left += upgrade_file(path, write=options.write)
        except DescriptionError as error:
            said = str(error)
            # Of a file that is not there it says the path itself.
            print(said if said.startswith(str(path)) else f"{path}: {said}", file=sys.stderr)
            left += 1
    return 1 if left else 0
