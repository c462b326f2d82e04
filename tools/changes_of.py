"""Print what the changelog says of a release: changes_of.py v1.2.3."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def changes_of(changelog: str, version: str) -> str:
    """Give the text below ``## VERSION``, up to the next heading of its level.

    Raises:
        LookupError: there is no such heading, or nothing is below it.

    """
    found = re.search(rf"(?ms)^## {re.escape(version)}\b[^\n]*\n(.*?)(?=^## |\Z)", changelog)
    if found is None or not found[1].strip():
        raise LookupError(f"CHANGELOG.md says nothing under '## {version}'; rename 'Unreleased'")
    return found[1].strip() + "\n"


def main(arguments: list[str]) -> int:
    """Print them; 2 when there are none."""
    if len(arguments) != 1:
        print("give one tag: tools/changes_of.py v1.2.3", file=sys.stderr)
        return 2
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    try:
        sys.stdout.write(changes_of(changelog, arguments[0].removeprefix("v")))
    except LookupError as error:
        print(error.args[0], file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
