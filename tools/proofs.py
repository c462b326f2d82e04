"""Run the proofs: what takes too long for each change, each writing its table under docs/.

    .venv/bin/python tools/proofs.py                all that have not passed for this code
    .venv/bin/python tools/proofs.py faults         this one
    .venv/bin/python tools/proofs.py --again        also what has passed for this code
    .venv/bin/python tools/proofs.py --list         what there is

A proof that has passed is not run again for the same code (every tracked file but those of docs/
and texts in Markdown), so a run that was ended goes on where it was. Each has a short form in
`make test`. To add one, add a line to `JOBS`.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PASSED = ROOT / "build" / "proofs.json"
PYTEST = ("-m", "pytest", "-s", "-p", "no:cacheprovider")


class Job(NamedTuple):
    """One proof.

    Attributes:
        name: what it is asked for by.
        proves: what holds when it passes.
        command: the words after ``python``, run in the project's folder with src and tests on
            Python's path; ``{minutes}``, ``{hours}`` and ``{table}`` are filled in.
        table: the file that it writes, below the project's folder.
        minutes: how long it runs.

    The command also finds ``TALAIA_PROOF_MINUTES`` and ``TALAIA_PROOF_TABLE`` in its environment.
    It exits with 0 when all holds.
    """

    name: str
    proves: str
    command: tuple[str, ...]
    table: str
    minutes: float


JOBS = (
    Job(
        "faults",
        "a site survives every fault: nothing unsafe moves, no recorded value is lost",
        (*PYTEST, "tests/system/faults/test_rows.py"),
        "docs/faults-table.md",
        minutes=20,
    ),
    # Runs that were good are kept, and what is left after so many minutes waits for the next proof.
    Job(
        "cluster",
        "three hubs, 200 gateways and 50 pages survive every fault: nothing acknowledged is lost or"
        " there twice, no alarm is told twice, no robot is left moving",
        (*PYTEST, "tests/system/cluster/test_rows.py"),
        "docs/cluster-table.md",
        minutes=20,
    ),
    # What has passed for this code is kept row by row and seed by seed, and is not run again.
    Job(
        "enclosure",
        "a roof closes in time after every fault, and people are told when it does not",
        ("-m", "system.enclosure", "--table", "{table}"),
        "docs/enclosure-table.md",
        minutes=60,
    ),
    Job(
        "nights",
        "thirty seeded nights, dusk to dawn, with faults and people: no roof open when unsafe,"
        " nothing lost, a safe morning",
        ("-m", "system.nights", "--table", "{table}"),
        "docs/nights-table.md",
        minutes=20,
    ),
    Job(
        "tiles",
        "each tile of boards, in each of its states, keeps the rules of axe and fits: on four"
        " widths, in three themes",
        (*PYTEST, "tests/hub/features/test_gallery_in_browser.py"),
        "docs/tiles-table.md",
        minutes=10,
    ),
    Job(
        "words",
        "no page says anything that no catalogue has, or is wider than its window, in a language"
        " whose texts are 30 % longer",
        (*PYTEST, "tests/hub/features/test_pseudo_language_in_browser.py"),
        "docs/words-table.md",
        minutes=5,
    ),
    Job(
        "crash-loop",
        "a hundred killed gateways and ROS 2 nodes leave nothing in /dev/shm",
        (*PYTEST, "tests/test_shared_memory.py", "tests/system/test_link.py", "-k", "crash_loop"),
        "docs/crash-loop-table.md",
        minutes=15,
    ),
    Job(
        "properties",
        "what is true of any description, history or alarm is true of many more examples",
        ("-m", "many_examples", "--table", "{table}"),
        "docs/properties-table.md",
        minutes=120,
    ),
    Job(
        "fuzz",
        "what is made up reaches no reader of foreign bytes with more than its declared errors",
        ("-m", "system.fuzz", "--minutes", "{minutes}", "--table", "{table}"),
        "docs/fuzz-table.md",
        minutes=20,
    ),
    # These two ask the index that pip is set up with; nothing of arm64 runs.
    Job(
        "images",
        "what the images' recipes install comes from the index into clean environments, and works",
        (*PYTEST, "tests/deploy/test_image_recipes.py"),
        "docs/images-table.md",
        minutes=5,
    ),
    Job(
        "arm64",
        "each locked package of a gateway has a wheel for arm64, for each Python",
        ("-m", "deploy.arm64_wheels", "--table", "{table}"),
        "docs/arm64-table.md",
        minutes=3,
    ),
    Job(
        "bridge",
        "a gateway does all with the ROS 2 of Python 3.10, and its robot stops when it dies",
        ("-m", "gateway.adapters.ros2.system_ros_proof", "--table", "{table}"),
        "docs/bridge-table.md",
        minutes=6,
    ),
    # Two hours are run by `make soak`, which writes docs/soak-table.md; 24 before a release.
    Job(
        "soak",
        "hub and gateway run on, and nothing of theirs grows without end",
        ("-m", "system.soak", "{hours}", "--table", "{table}"),
        "docs/soak-20-minutes.md",
        minutes=20,
    ),
    # It needs other versions of what we use, so it has an environment of its own.
    Job(
        "home-assistant",
        "Home Assistant's own schemas take every discovery message of every example",
        ("tools/home_assistant.py", "{table}"),
        "docs/home-assistant-table.md",
        minutes=2,
    ),
)


def code_state() -> str:
    """Name the state of the code: a hash over all files but docs/ and Markdown."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    found = hashlib.sha256()
    for name in sorted(filter(None, listed.split("\0"))):
        path = ROOT / name
        if name.startswith("docs/") or name.endswith(".md") or not path.is_file():
            continue
        found.update(f"{name}\0".encode() + hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()[:16]


def run_job(job: Job, minutes: float, table: Path) -> bool:
    """Run one to its end; tell whether it passed."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join((str(ROOT / "src"), str(ROOT / "tests"))),
        "TALAIA_PROOF_MINUTES": f"{minutes:g}",
        "TALAIA_PROOF_TABLE": str(table),
    }
    filled = {"minutes": f"{minutes:g}", "hours": f"{minutes / 60:g}", "table": str(table)}
    words = [sys.executable, *(word.format(**filled) for word in job.command)]
    return subprocess.run(words, cwd=ROOT, env=environment, check=False).returncode == 0


def main(arguments: list[str]) -> int:
    """Give 0 when each that was asked for has passed."""
    parser = argparse.ArgumentParser(description="Run the proofs.")
    parser.add_argument("names", nargs="*", help="which; all when none is named")
    parser.add_argument("--again", action="store_true", help="also what has passed already")
    parser.add_argument("--list", action="store_true", help="name them and run none")
    parser.add_argument("--minutes", type=float, help="shorter or longer; not written down")
    chosen = parser.parse_args(arguments)
    if unknown := set(chosen.names) - {job.name for job in JOBS}:
        there = ", ".join(job.name for job in JOBS)
        parser.error(f"no proof is called {', '.join(sorted(unknown))}; there are {there}")
    passed: dict[str, str] = json.loads(PASSED.read_text()) if PASSED.exists() else {}
    failed = []
    for job in JOBS:
        if chosen.names and job.name not in chosen.names:
            continue
        state = code_state()
        done = passed.get(job.name) == state
        if chosen.list or (done and not chosen.again):
            shown = "passed for this code" if done else f"{job.minutes:g} min"
            print(f"{job.name}: {shown}. {job.proves} ({job.table})")
            continue
        print(f"── {job.name}: {job.proves}", flush=True)
        began = time.monotonic()
        PASSED.parent.mkdir(exist_ok=True)
        # A run of another length is a look, and no proof: its table stays beside.
        table = PASSED.parent / f"{job.name}.md" if chosen.minutes else ROOT / job.table
        holds = run_job(job, chosen.minutes or job.minutes, table)
        minutes = (time.monotonic() - began) / 60
        print(f"── {job.name}: {'passed' if holds else 'FAILED'} in {minutes:.1f} min: {table}")
        if not holds:
            failed.append(job.name)
        elif not chosen.minutes:
            passed[job.name] = state
            PASSED.write_text(json.dumps(passed, indent=1) + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
