"""How many examples a property is tried with: few in `make test`, many in `make proofs`.

    python -m many_examples --table docs/properties-table.md

runs each test file that asks here with many, and writes what it found as a table.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
_MANY = "TALAIA_MANY_EXAMPLES"
# Of one test (s); few of them take as long as an hour.
TIMEOUT_S = 7200


def examples(few: int, *, many: int) -> int:
    """Give the number of examples of a property in this run."""
    return many if os.environ.get(_MANY) else few


class Counts:
    """Counts the tests of a file, as a plugin of pytest."""

    def __init__(self) -> None:
        """Begin with none."""
        self.passed = self.failed = 0

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count a test when it has run."""
        self.passed += report.when == "call" and report.passed
        self.failed += report.failed


def files_that_ask() -> list[Path]:
    """List the test files whose properties are tried with few examples in `make test`."""
    asking = "from many_examples import"
    return sorted(path for path in TESTS.rglob("test_*.py") if asking in path.read_text())


def main(arguments: list[str]) -> int:
    """Give 0 when all held."""
    parser = argparse.ArgumentParser(description="Run what is generated with many examples.")
    parser.add_argument("--table", type=Path, required=True, help="the file to write")
    chosen = parser.parse_args(arguments)
    os.environ[_MANY] = "1"
    words = ["-q", "-p", "no:cacheprovider", f"--timeout={TIMEOUT_S}"]
    rows, failed = [], 0
    for path in files_that_ask():
        counts, began = Counts(), time.monotonic()
        failed += int(pytest.main([*words, str(path)], plugins=[counts])) != 0
        name = path.relative_to(TESTS.parent)
        minutes = (time.monotonic() - began) / 60
        rows.append(f"| `{name}` | {counts.passed} | {counts.failed} | {minutes:.1f} |")
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
    return int(failed != 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
