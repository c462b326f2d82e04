"""Refuse a tag of which nothing is written down: check_release.py v1.2.3.

The version is the tag's (see `src/talaia/own_version.py`); its changes stand in ``CHANGELOG.md``.
Needs nothing installed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from changes_of import changes_of

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "src" / "talaia"))

from own_version import version_of_checkout  # noqa: E402


def differences(tag: str, root: Path) -> list[str]:
    """Say in a sentence each what is not as the tag says; nothing if all is well.

    Args:
        tag: as git has it: ``v1.2.3``.
        root: of the checkout.

    """
    if not re.fullmatch(r"v\d+\.\d+\.\d+((a|b|rc)\d+)?", tag):
        return [f"the tag is {tag!r}; expected one like v1.2.3 or v1.2.3rc1"]
    version, said = tag.removeprefix("v"), []
    found = version_of_checkout(root)
    if found != version:
        said.append(
            f"the tag is {tag} and the checkout is {found}; check out the tag, with all tags"
        )
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
