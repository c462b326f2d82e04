"""Look over the tracked files: no path of one machine, no package host, no unfinished mark.

.venv/bin/python tools/check_tree.py
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# Written in pieces, so that this file does not find itself.
NOT_HERE = re.compile(
    "|".join(
        (
            r"(?<![\w.])/(wo" r"rk|ro" r"ot|ho" r"me)/[a-z]",
            r"\bTO" r"DO\b", r"\bFIX" r"ME\b", r"\bX" r"XX\b",
            r"NotImplemented" r"Error", r"registry\.np" r"mjs", r"py" r"pi\.org",
            r"files\.python" r"hosted", r"deb\.deb" r"ian\.org",
        )
    )
)  # fmt: skip
SKIP = {".png", ".jpg", ".woff2", ".svg"}
LONG = 300


def main() -> int:
    """Print each place; 1 when there is one."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.split("\n")  # fmt: skip
    wrong = 0
    for name in filter(None, listed):
        path = ROOT / name
        # What a real peer said is kept as it said it.
        if path.suffix in SKIP or "/recorded/" in name or not path.is_file():
            continue
        text = path.read_text(errors="replace")
        for number, line in enumerate(text.splitlines(), 1):
            if NOT_HERE.search(line):
                print(f"{name}:{number}: {line.strip()[:120]}")
                wrong += 1
        if name.startswith("src/") and path.suffix == ".py" and text.count("\n") > LONG:
            head = text.split('"""')[1] if '"""' in text else ""
            if "long" not in head.lower() and "one place" not in head.lower():
                print(f"{name}: {text.count(chr(10))} lines; over {LONG} it opens with the reason")
                wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
