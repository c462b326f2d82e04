"""``talaia docs``: the documentation's guides, as they came with this version.

Messages of all parts name a guide by this command, so that who installed a package finds it without
a copy of the project and without a network.
"""

from __future__ import annotations

import argparse
import sys
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from importlib.resources.abc import Traversable

__all__ = ["main", "read_guides"]

# In a package, and beside the code that is worked on.
_INSTALLED, _WORKED_ON = "how_to", Path(__file__).parents[4] / "docs" / "how-to"


def main(argv: Sequence[str]) -> int:
    """Print a guide, or list them all."""
    parser = argparse.ArgumentParser(
        "talaia docs", description="Print a guide of the documentation, or list them all."
    )
    parser.add_argument("guide", nargs="?", default="", help="its name (default: list them)")
    wanted = parser.parse_args(argv).guide
    guides = read_guides()
    if wanted in guides:
        print(guides[wanted].rstrip("\n"))
        return 0
    if not wanted:
        width = max(map(len, guides), default=0)
        for name, text in guides.items():
            print(f"{name:{width}}  {_title_of(text)}")
        return 0
    near = get_close_matches(wanted, guides, n=1)
    remedy = f"did you mean {near[0]}?" if near else "`talaia docs` lists them"
    print(f"talaia docs: there is no guide {wanted!r}; {remedy}", file=sys.stderr)
    return 2


def read_guides() -> dict[str, str]:
    """Give the text of each guide by its name, in the order of their names."""
    installed = files("talaia").joinpath(_INSTALLED)
    found = dict(_guides_in(installed if installed.is_dir() else _WORKED_ON))
    return dict(sorted(found.items()))


def _guides_in(folder: Path | Traversable, above: str = "") -> list[tuple[str, str]]:
    guides: list[tuple[str, str]] = []
    for one in folder.iterdir() if folder.is_dir() else ():
        if one.is_dir():
            guides += _guides_in(one, f"{above}{one.name}/")
        elif one.name.endswith(".md"):
            name = above + one.name.removesuffix(".md")
            guides.append((name, one.read_text(encoding="utf-8")))
    return guides


def _title_of(text: str) -> str:
    return next((line[2:] for line in text.splitlines() if line.startswith("# ")), "")
