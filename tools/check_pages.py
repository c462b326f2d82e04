"""Hold the structure of the pages: folders, lengths, names said once, tests beside their source.

.venv/bin/python tools/check_pages.py
"""

from __future__ import annotations

import re
import sys
from collections import defaultdict
from pathlib import Path

WEB = Path(__file__).resolve().parent.parent / "web"
MOST_FILES = 20  # in one folder
MOST_LINES = 500  # in one file
# Said alone, these verbs name nothing that is done.
VAGUE = "take|look|tell|say|said|told|put|give|note|go|do|ask|hear|heard|see|beat"
TYPE = re.compile(
    r"^(?:export )?(?:declare )?(?:abstract )?(?:class|interface|type) (\w+)", re.MULTILINE
)
FUNCTION = re.compile(
    rf"(?:\bfunction |^  (?:(?:private|protected|readonly|async|static|get|set|override) )*)"
    rf"({VAGUE})(?:<[^>]*>)?(?:\(| = (?:async )?\([^()]*\)(?:: [^=]+)? =>)",
    re.MULTILINE,
)
LOOP = re.compile(r"\b(?:const|let) (each|one)\b|\(?\b(each|one)\)? =>")


def folders() -> list[str]:
    """Folders of sources and tests that hold too many files."""
    return [
        f"{path.relative_to(WEB)}: {count} files; a folder holds at most {MOST_FILES}"
        for top in ("src", "tests")
        for path in [WEB / top, *(WEB / top).rglob("*")]
        if path.is_dir() and (count := sum(each.is_file() for each in path.iterdir())) > MOST_FILES
    ]


def sources() -> list[str]:
    """What is wrong in one file, and type names that two files declare."""
    wrong: list[str] = []
    owners: dict[str, list[str]] = defaultdict(list)
    for path in sorted((WEB / "src").rglob("*.ts")):
        name = str(path.relative_to(WEB))
        text = path.read_text(encoding="utf-8")
        for found in set(TYPE.findall(text)):
            owners[found].append(name)
        if "/generated/" in name:
            continue
        if text.count("\n") > MOST_LINES:
            wrong.append(f"{name}: {text.count(chr(10))} lines; at most {MOST_LINES}")
        for number, line in enumerate(text.splitlines(), 1):
            wrong += [
                f"{name}:{number}: says nothing alone: {match.group(0).strip()}"
                for match in (FUNCTION.search(line), LOOP.search(line))
                if match
            ]
    wrong += [
        f"{name} stands in {', '.join(files)}; a type has one name of its own"
        for name, files in sorted(owners.items())
        if len(files) > 1
    ]
    return wrong


def mirrored() -> list[str]:
    """Tests that stand beside no source of their name."""
    return [
        f"{path.relative_to(WEB)}: no source of this name"
        for path in sorted((WEB / "tests").rglob("*.test.ts"))
        for stem in [str(path.relative_to(WEB / "tests")).removesuffix(".test.ts")]
        if not any((WEB / "src" / f"{stem}{suffix}").exists() for suffix in (".ts", ".css"))
        and not (WEB / f"{stem}.mjs").exists()
    ]


def main() -> int:
    """Print each place; 1 when there is one."""
    wrong = [*folders(), *sources(), *mirrored()]
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
