"""Line coverage of a run of the tests, held by the floors of `tools/coverage_floors.json`.

`make test` measures the quick ring's files and the pages': that costs next to nothing. To measure
all files and the processes that they start (`make coverage`) costs too much for each run on
Python 3.11, whose tracer is called for each line.
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FLOORS = ROOT / "tools" / "coverage_floors.json"
QUICK, ALL, WEB = "Python, quick ring", "Python, all", "pages"
# What a change may take away by chance: property tests do not draw the same examples each time.
CHANCE = 0.3


def is_measurable(*, pages: bool = False) -> bool:
    """Tell whether this project has floors, and what measures is installed.

    The runner's own tests run it in projects without floors; `make setup` installs the rest.
    """
    installed = (
        (ROOT / "web/node_modules/@vitest/coverage-v8").exists()
        if pages
        else importlib.util.find_spec("coverage") is not None
    )
    return FLOORS.exists() and installed


def words_before(module: str, *, processes: bool) -> list[str]:
    """Give the words that run ``module`` measured, with ``processes`` those that it starts, too."""
    options = ["--rcfile=pyproject.toml"] if processes else ["--rcfile=tools/quick_coverage.ini"]
    return [sys.executable, "-m", "coverage", "run", *options, "-m", module]


def environment(folder: Path) -> dict[str, str]:
    """Give what measured processes find in their environment; the data lies in ``folder``."""
    (folder / "coverage").mkdir(exist_ok=True)
    (folder / "coverage").chmod(0o777)
    return {"COVERAGE_FILE": str(folder / "coverage" / "data")}


def report_folder(folder: Path) -> Path:
    """Where the pages' tests write what they covered."""
    return folder / "coverage-of-pages"


def python_share(folder: Path) -> float | None:
    """Give the share of lines of Python that ran (%), or None when nothing was measured."""
    surroundings = {**os.environ, **environment(folder)}
    coverage = [sys.executable, "-m", "coverage"]
    quiet = {"cwd": ROOT, "env": surroundings, "capture_output": True, "text": True}
    subprocess.run([*coverage, "combine", "-q"], check=False, **quiet)
    words = [*coverage, "report", "--format=total", "--precision=1"]
    done = subprocess.run(words, check=False, **quiet)
    return float(done.stdout) if done.returncode == 0 and done.stdout.strip() else None


def pages_share(folder: Path) -> float | None:
    """Give the share of lines of the pages that ran (%), or None when nothing was measured."""
    summary = report_folder(folder) / "coverage-summary.json"
    if not summary.exists():
        return None
    return float(json.loads(summary.read_text())["total"]["lines"]["pct"])


def print_shares(folder: Path, *, everything: bool, whole_ring: bool) -> bool:
    """Print each share beside its floor; tell whether none lies below.

    Args:
        folder: the run's.
        everything: all of Python was measured, not only the quick ring.
        whole_ring: all files of the ring ran; only then the floors hold.

    """
    if not FLOORS.exists():
        return True
    if not (is_measurable() and is_measurable(pages=True)):
        print("line coverage: not measured, for what measures is missing; run `make setup`")
    floors = json.loads(FLOORS.read_text())
    good = True
    python = python_share(folder) if is_measurable() else None
    shares = {ALL if everything else QUICK: python, WEB: pages_share(folder)}
    for name, share in shares.items():
        if share is None:
            continue
        floor = floors.get(name, 0.0)
        print(f"line coverage, {name}: {share:.1f} % (at least {floor:.1f} %)")
        if whole_ring and share < floor - CHANCE:
            good = False
            print(
                f"✗ fewer lines of {name} are covered than before; see tools/coverage_floors.json"
            )
    return good
