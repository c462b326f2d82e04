"""How many examples a property is tried with: few in `make test`, many in `make proofs`.

    python -m many_examples --table docs/properties-table.md [FILES]

runs the properties of each test file, or of these, with many, and writes what it found as a table.
A property that says nothing is tried as often as the profile in `tests/conftest.py` says.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

TESTS = Path(__file__).parent
_MANY = "TALAIA_MANY_EXAMPLES"
# Of one test (s); few of them take as long as an hour.
TIMEOUT_S = 7200
# pytest's exit codes of a file that passed, and of one with no test to run.
PASSED, NOTHING = 0, 5
_OUTCOMES = ("passed", "(?:failed|error)")


def examples(few: int, *, many: int) -> int:
    """Give the number of examples of a property in this run."""
    return many if os.environ.get(_MANY) else few


def files_with_properties() -> list[Path]:
    """List the test files in which Hypothesis makes up examples."""
    making = "from hypothesis import"
    return sorted(path for path in TESTS.rglob("test_*.py") if making in path.read_text())


def run_file(path: Path) -> tuple[int, int, str]:
    """Run a file's properties with many examples.

    Returns:
        How many passed, how many failed, and what was printed; a file that cannot be run counts as
        one that failed.

    """
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    words += [f"--timeout={TIMEOUT_S}", str(path)]
    if "examples(" not in path.read_text():
        # Where a test asks how many, Hypothesis may be at work inside of it, unmarked.
        words += ["-m", "hypothesis"]
    done = subprocess.run(
        words, env={**os.environ, _MANY: "1"}, capture_output=True, text=True, check=False
    )
    printed = done.stdout + done.stderr
    passed, failed = (sum(map(int, re.findall(rf"(\d+) {w}", printed[-400:]))) for w in _OUTCOMES)
    if done.returncode not in (PASSED, NOTHING):
        failed = max(1, failed)
    return passed, failed, printed


def main(arguments: list[str]) -> int:
    """Give 0 when all held."""
    parser = argparse.ArgumentParser(description="Run what is generated with many examples.")
    parser.add_argument("--table", type=Path, required=True, help="the file to write")
    parser.add_argument("files", nargs="*", type=Path, help="these files only")
    chosen = parser.parse_args(arguments)
    rows, all_failed = [], 0
    for path in [path.resolve() for path in chosen.files] or files_with_properties():
        began = time.monotonic()
        passed, failed, printed = run_file(path)
        all_failed += failed
        name = path.relative_to(TESTS.parent)
        minutes = (time.monotonic() - began) / 60
        rows.append(f"| `{name}` | {passed} | {failed} | {minutes:.1f} |")
        sys.stdout.write(rows[-1] + "\n")
        sys.stdout.flush()
        if failed:
            sys.stdout.write(printed)
    head = [
        "# Properties, with many examples",
        "",
        f"What `make proofs ONLY=properties` found on {datetime.now(UTC):%Y-%m-%d}: each file of"
        " tests that `make test` runs with few generated examples, run with many.",
        "",
        "| file | tests that passed | that failed | minutes |",
        "| --- | --: | --: | --: |",
    ]
    chosen.table.write_text("\n".join([*head, *rows]) + "\n")
    return int(all_failed != 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
