"""The words of ``talaia init``, before anything is imported that describes robots.

So ``--help`` and wrong words are answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.cli.probe import add_options

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """Write the description; 0 when it runs as it is, 1 when something in it must be mended."""
    parser = argparse.ArgumentParser(
        "talaia init",
        description="Write a site description of the robot that is running now. Then: "
        "talaia up site.yaml",
    )
    add_options(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("site.yaml"),
        help="the file to write; - for the screen (default: site.yaml)",
    )
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")
    parser.add_argument("--found", help="what `talaia probe --json` printed, in a file or - ")
    parser.add_argument("--site", help="short name of the site (default: of the robot)")
    parser.add_argument(
        "--name", help="what people call it (default: the robot's namespace, else its machine)"
    )
    parser.add_argument("--zone", help="its time zone, such as Europe/Madrid (default: this one's)")
    parser.add_argument(
        "--no-questions",
        action="store_true",
        help="ask nothing: all devices are taken, and STOP is a velocity of zero alone until the "
        "file says more",
    )
    parser.add_argument(
        "--web",
        action="store_true",
        help="ask in a page of this machine's browser, with the newest values; ends when answered",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="with --web: print the address and open nothing"
    )
    options = parser.parse_args(argv)
    # The whole model: a quarter of a second of a core.
    from talaia.cli.describing.describe_robot import describe_robot

    return describe_robot(options)
