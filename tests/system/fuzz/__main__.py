"""Fuzz every reader of foreign bytes, guided by what each input reaches.

    PYTHONPATH=src:tests python -m system.fuzz --minutes 20 [--table FILE] [--keep] [TARGET ...]

Atheris, which finds what to try next, comes from requirements/fuzz.txt into ``build/fuzz``. What an
input makes fail is printed as a line for the target's file in ``seeds/``, where it stays when it is
mended. ``--keep`` adds to these files the small inputs that reach what none before had reached.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from .target import load_seeds, save_seeds
from .targets import all_targets

ROOT = Path(__file__).resolve().parents[3]
LOCK = ROOT / "requirements" / "fuzz.txt"
PLACE = ROOT / "build" / "fuzz"
WORK = ROOT / "build" / "fuzz-run"
# Of the process that reads for minutes (MiB): the fuzzer's own corpus is in it, which is bounded.
MOST_GROWN = 150
# Of a target's file of seeds, so that the tree stays small and `make test` short.
MOST_SEEDS, MOST_SEED_BYTES = 60, 1500
_PATIENCE_S = 120


class FuzzResult(NamedTuple):
    """What came of one target.

    Attributes:
        tried: inputs.
        reached: edges of our code, and of what we read formats with in Python.
        grown: MiB, from before the first input to the end.
        failures: one sentence each.

    """

    name: str
    tried: int
    reached: int
    grown: float
    failures: tuple[str, ...]


def install_atheris() -> bool:
    """Have the fuzzer in a folder of its own; tell whether it could be had."""
    done = PLACE / "lock.txt"
    if done.exists() and done.read_bytes() == LOCK.read_bytes():
        return True
    shutil.rmtree(PLACE, ignore_errors=True)
    pip = [sys.executable, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    wanted = [*pip, "--no-deps", "--require-hashes", "--target", str(PLACE), "-r", str(LOCK)]
    if subprocess.run(wanted, check=False).returncode:
        return False
    done.write_bytes(LOCK.read_bytes())
    return True


def fuzz_target(group: str, name: str, seconds: int) -> FuzzResult:
    """Fuzz one target in a process of its own."""
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    words = [sys.executable, "-m", "system.fuzz.child", group, name, "corpus", str(seconds)]
    paths = (str(ROOT / "src"), str(ROOT / "tests"), str(PLACE))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    with (folder / "log.txt").open("wb") as log:
        try:
            done = subprocess.run(
                words, cwd=folder, env=environment, stdout=log, stderr=log, check=False,
                timeout=seconds + _PATIENCE_S,
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            done = 1
    printed = (folder / "log.txt").read_text("utf-8", "replace")
    # libFuzzer leaves what failed under these names.
    failures = [
        f"{found.name.partition('-')[0]} on {found.read_bytes()[:2000]!r}"
        for found in sorted(folder.glob("[cto]*-*"))
    ]
    if done and not failures:
        failures.append("it ended by itself; see its log")
    if failures:
        failures.append(printed[-3000:])
    grown = _last_number(r"grew (-?\d+)", printed) / 1024
    if grown > MOST_GROWN:
        failures.append(f"it grew by {grown:.0f} MiB; at most {MOST_GROWN}")
    return FuzzResult(
        name,
        _last_number(r"number_of_executed_units: (\d+)", printed),
        _last_number(r"\bcov: (\d+)", printed),
        grown,
        tuple(failures),
    )


def _last_number(pattern: str, printed: str) -> int:
    found = re.findall(pattern, printed)
    return int(found[-1]) if found else 0


def keep_seeds(name: str) -> None:
    """Add what reached something new to a target's seeds: small ones, the smallest first."""
    kept = load_seeds(name)
    # What libFuzzer itself added; named after its contents.
    found = [path.read_bytes() for path in (WORK / name / "corpus").iterdir()]
    room = max(0, MOST_SEEDS - len(kept))
    small = sorted((data for data in found if len(data) <= MOST_SEED_BYTES), key=len)
    # Spread over all lengths: the smallest alone would all be of one kind.
    step = max(1, len(small) // room) if room else len(small) + 1
    save_seeds(name, [*kept, *small[::step][:room]])


def write_table(results: list[FuzzResult], minutes: float, table: Path) -> None:
    """Write what was seen as Markdown."""
    lines = [
        "# Readers of foreign bytes, fuzzed",
        "",
        f"What `make fuzz` saw on {datetime.now(UTC):%Y-%m-%d} in {minutes:.0f} minutes. Each"
        " reader is given inputs that Atheris makes from kept seeds, guided by what they"
        " reach. It may raise what it declares; anything else, more than 1 s of processor time for"
        f" one input, or more than {MOST_GROWN} MiB of growth is a failure.",
        "",
        "| reader | inputs | reached | grew (MiB) | failed |",
        "| --- | --: | --: | --: | --: |",
    ]
    # A target whose work is done by a library in C reaches little of ours.
    lines += [
        f"| {result.name.replace('_', ' ')} | {result.tried} | {result.reached} |"
        f" {max(0.0, result.grown):.0f} | {len(result.failures)} |"
        for result in results
    ]
    table.write_text("\n".join(lines) + "\n")


def main(arguments: list[str]) -> int:
    """Give 0 when nothing failed."""
    parser = argparse.ArgumentParser(description="Fuzz the readers of foreign bytes.")
    parser.add_argument("names", nargs="*", help="these targets; all when none is named")
    parser.add_argument("--minutes", type=float, default=20.0, help="of all together")
    parser.add_argument("--table", type=Path, help="the file to write")
    parser.add_argument("--keep", action="store_true", help="add to the kept seeds")
    parser.add_argument("--jobs", type=int, default=max(1, (os.cpu_count() or 2) - 1))
    chosen = parser.parse_args(arguments)
    if not install_atheris():
        sys.stderr.write("Atheris could not be installed; its message stands above\n")
        return 1
    wanted = [
        (group, target.name)
        for group, target in all_targets()
        if not chosen.names or target.name in chosen.names
    ]
    seconds = max(3, round(chosen.minutes * 60 * chosen.jobs / max(1, len(wanted))))
    began = time.monotonic()
    with ThreadPoolExecutor(chosen.jobs) as workers:
        results = list(workers.map(lambda each: fuzz_target(*each, seconds), wanted))
    for result in results:
        sys.stdout.write(f"{result.name}: {result.tried} inputs, {result.reached} reached\n")
        for failure in result.failures:
            sys.stdout.write(f"{result.name} FAILED: {failure}\n")
        if chosen.keep and not result.failures:
            keep_seeds(result.name)
    if chosen.table:
        write_table(results, (time.monotonic() - began) / 60, chosen.table)
    return int(any(result.failures for result in results))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
