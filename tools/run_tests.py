"""Run all tests: Python's in two groups side by side, then the pages'.

    .venv/bin/python tools/run_tests.py              all
    .venv/bin/python tools/run_tests.py ARGUMENTS    pytest alone, with these arguments

The first group holds a real robot, gateway and browser and mostly waits for them; the second the
hub and all the rest, mostly on one core. Each group's words are printed when it has ended,
the longer one's last.
"""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ROBOT = (
    "tests/gateway",
    "tests/sim",
    "tests/system",
)


def main(arguments: list[str]) -> int:
    """Give 0 when all passed."""
    if arguments:
        return subprocess.run(_pytest(*arguments), cwd=ROOT, check=False).returncode
    others = [f"--ignore={each}" for each in ROBOT]
    groups = {"robot": _pytest("-q", *ROBOT), "hub": _pytest("-q", "tests", *others)}
    worst = 0
    with ThreadPoolExecutor(len(groups)) as pool:
        running = {pool.submit(_run, words): name for name, words in groups.items()}
        for done in as_completed(running):
            code, said = done.result()
            print(f"── {running[done]}\n{said}", flush=True)
            worst = max(worst, code)
    pages = [sys.executable, "tools/node.py", "run", "test"]
    return subprocess.run(pages, cwd=ROOT, check=False).returncode or worst


def _pytest(*words: str) -> list[str]:
    # Both write nothing into the tree, so that they do not meet there.
    return [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *words]


def _run(words: list[str]) -> tuple[int, str]:
    done = subprocess.run(
        words, cwd=ROOT, check=False, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    return abs(done.returncode), done.stdout


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
