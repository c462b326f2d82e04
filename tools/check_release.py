"""Refuse a tag that is not the version that is written down: check_release.py v1.2.3.

The version stands in ``src/talaia/__init__.py`` and ``CITATION.cff``, and its changes in
``CHANGELOG.md``. Needs nothing installed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from changes_of import changes_of

ROOT = Path(__file__).resolve().parent.parent
# Where the version is written, and how.
WRITTEN = {
    "src/talaia/__init__.py": r'(?m)^__version__ = "([^"]+)"$',
    "CITATION.cff": r'(?m)^version: "?([^"\n]+)"?$',
}


def differences(tag: str, root: Path) -> list[str]:
    """Say in a sentence each what is written otherwise than the tag says; nothing if all is well.

    Args:
        tag: as git has it: ``v1.2.3``.
        root: of the checkout.

    """
    if not re.fullmatch(r"v\d+\.\d+\.\d+((a|b|rc)\d+)?", tag):
        return [f"the tag is {tag!r}; expected one like v1.2.3 or v1.2.3rc1"]
    version, said = tag.removeprefix("v"), []
    for name, pattern in WRITTEN.items():
        found = re.search(pattern, (root / name).read_text(encoding="utf-8"))
        written = found[1] if found else "nothing"
        if written != version:
            said.append(f"the tag is {tag} and {name} says {written}; set one of them right")
    try:
        changes_of((root / "CHANGELOG.md").read_text(encoding="utf-8"), version)
    except LookupError as error:
        said.append(str(error.args[0]))
    return said


def main(arguments: list[str]) -> int:
    """Say all that differs; 2 if anything does."""
    if len(arguments) != 1:
        print("give one tag: tools/check_release.py v1.2.3", file=sys.stderr)
        return 2
    said = differences(arguments[0], ROOT)
    for each in said:
        # As a workflow shows it beside the run.
        print(f"::error::{each}")
    return 2 if said else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
