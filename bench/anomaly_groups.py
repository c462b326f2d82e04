"""Judge detectors on tables of several signals in which somebody has marked what is anomalous.

    python bench/anomaly_groups.py FOLDER [--learn-rows 400] [--detectors group together]

``FOLDER`` holds CSV files as ``talaia anomalies backtest`` reads them, with a column ``anomaly``
of 0 and 1; files without one are passed over. The detectors see what that command's do: each row
once, in order, and nothing of the labels. They learn from the first rows of each file, which do
not count; of all others, true and false ones are added over the files:

- F1 = 2 TP / (2 TP + FP + FN),
- FAR, false alarms of the normal rows,
- MAR, missed ones of the anomalous rows.

Saying "anomalous" always is the measure that a detector has to beat. *A* are every other file in
the order of their names, beginning with the first; *B* those between.

Last, what 200 signals at 1 Hz in groups of 20 cost. A limit that is missed makes the exit code 1.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
import tracemalloc
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.cli.anomalies.judges import DETECTORS, make_judge
from talaia.cli.anomalies.signal_rows import SignalRows
from talaia.hub.anomaly.base import dump_detector
from talaia.hub.anomaly.groups.modal_group import ModalGroup

if TYPE_CHECKING:
    from collections.abc import Sequence

LEAST_F1 = 0.82
# 200 signals: share of a core, and MB.
GROUPS, SIGNALS, MOST_CORE, MOST_MB = 10, 20, 0.05, 40.0
LEARNED, LOOKED = 600, 1200
ALWAYS = "always anomalous"


class Counts(NamedTuple):
    """How rows were judged, against what is known of them."""

    hit: int = 0
    false: int = 0
    missed: int = 0
    calm: int = 0

    def plus(self, other: Counts) -> Counts:
        """Add those of another file."""
        return Counts(*(mine + its for mine, its in zip(self, other, strict=True)))

    def f1(self) -> float:
        """Give F1; 0 where nothing was anomalous and nothing said so."""
        return 2 * self.hit / max(1, 2 * self.hit + self.false + self.missed)

    def false_share(self) -> float:
        """Give the false alarms' share of the normal rows."""
        return self.false / max(1, self.false + self.calm)

    def missed_share(self) -> float:
        """Give the missed rows' share of the anomalous ones."""
        return self.missed / max(1, self.missed + self.hit)


def judge_file(path: Path, detector: str, learn_rows: int) -> tuple[Counts, int]:
    """Judge one file; give the counts, and how many rows it has."""
    counts, number = [0, 0, 0, 0], 0
    rows = SignalRows(path)
    try:
        always = detector == ALWAYS
        judge = None if always else make_judge(detector, rows.signals, learn_rows)
        for number, row in enumerate(rows.read_rows(), 1):
            found = always
            if judge is not None:
                times, values = np.array([row.time_us]), np.array([row.values])
                found = judge.judge_rows(times, values)[0].anomalous
            if number > learn_rows:
                counts[2 * (not found) + (row.labelled is not found)] += 1
    finally:
        rows.close()
    # In the order of the bits above: found and right, found and wrong, then those not found.
    hit, false, calm, missed = counts
    return Counts(hit, false, missed, calm), number


def labelled_files(folder: Path) -> list[Path]:
    """List the CSV files that have a column ``anomaly``."""
    found = []
    for path in sorted(folder.glob("*.csv")):
        rows = SignalRows(path)
        if "anomaly" in [heading.lower() for heading in rows.left_out]:
            found.append(path)
        rows.close()
    return found


def print_judged(files: Sequence[Path], detectors: Sequence[str], learn_rows: int) -> bool:
    """Print a line for each detector; false if a limit is missed."""
    good = True
    print(f"{len(files)} files, learned from the first {learn_rows} rows of each\n")
    print("| detector | F1 | FAR | MAR | F1 A | F1 B | µs a row |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for name in (ALWAYS, *detectors):
        began, halves, rows = time.process_time(), [Counts(), Counts()], 0
        for at, path in enumerate(files):
            counts, length = judge_file(path, name, learn_rows)
            halves[at % 2] = halves[at % 2].plus(counts)
            rows += length
        cost = (time.process_time() - began) / max(1, rows) * 1e6
        both = halves[0].plus(halves[1])
        print(
            f"| {name} | {both.f1():.3f} | {both.false_share():.1%} | {both.missed_share():.1%} |"
            f" {halves[0].f1():.3f} | {halves[1].f1():.3f} | {cost:.0f} |",
            flush=True,
        )
        good = good and (name != "group" or both.f1() >= LEAST_F1)
    return good


def print_cost() -> bool:
    """Print what many groups cost, samples by samples; false if a limit is missed."""
    chance = random.Random(1)  # noqa: S311 - noise
    names = [f"signal {at}" for at in range(SIGNALS)]
    tracemalloc.start()
    groups = [ModalGroup(signals=names, learn_rows=LEARNED) for _ in range(GROUPS)]
    spent, most = 0.0, 0.0
    for second in range(LEARNED + 1 + LOOKED):
        values = [chance.gauss(0.0, 1.0) for _ in range(SIGNALS)]
        if second == LEARNED + 1:
            # Most memory is used when what was learned is reckoned; time is measured without what
            # counts that.
            most = tracemalloc.get_traced_memory()[1] / 1e6
            tracemalloc.stop()
        began = time.process_time()
        for group in groups:
            for at, value in enumerate(values):
                group.see(second * 1_000_000, at, value)
        spent += (time.process_time() - began) if second > LEARNED else 0.0
    core = spent / LOOKED
    kept = max(len(dump_detector(group)) for group in groups) / 1e3
    print(
        f"\n{GROUPS * SIGNALS} signals at 1 Hz in groups of {SIGNALS}: {core:.2%} of a core (limit"
        f" {MOST_CORE:.0%}), at most {most:.1f} MB while they learn (limit {MOST_MB:.0f}), then"
        f" {kept:.0f} kB a group"
    )
    return core <= MOST_CORE and most <= MOST_MB


def main() -> int:
    """Judge a folder; 1 when a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("folder", type=Path, help="CSV files with a column anomaly")
    parser.add_argument("--learn-rows", type=int, default=400, metavar="N")
    parser.add_argument(
        "--detectors", nargs="+", choices=DETECTORS, default=["group", "together"], metavar="NAME"
    )
    options = parser.parse_args()
    files = labelled_files(options.folder)
    if not files:
        print(f"{options.folder}: expected CSV files with a column 'anomaly'", file=sys.stderr)
        return 2
    good = print_judged(files, options.detectors, options.learn_rows)
    return 0 if print_cost() and good else 1


if __name__ == "__main__":
    sys.exit(main())
