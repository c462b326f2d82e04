"""What trials came to, a line each in a file, and the table that is published of them."""

from __future__ import annotations

import json
import os
from collections import Counter
from pathlib import Path
from statistics import median
from typing import NamedTuple

from .rows import ROWS
from .trial import DISKS, Row, Run

PROTOCOLS = ("ROS 2", "ROS 1", "INDI")
# How many seeds a whole proof has; at least one for each kind of disk.
SEEDS = {"ROS 2": 20, "ROS 1": 5, "INDI": 4}


class Trial(NamedTuple):
    """A row, done once.

    Attributes:
        state: of the code, see `tools/proofs.py`.

    """

    state: str
    protocol: str
    row: str
    seed: int
    closed_s: list[float]
    told_s: list[float]
    violations: list[str]
    counted: dict[str, int]
    disk: str = DISKS[0]


class Results:
    """The file. Many processes may write to it; each line is written by one call."""

    def __init__(self, path: Path) -> None:
        """Take where it is, or will be."""
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)

    def add(self, state: str, row: Row, seed: int, run: Run) -> None:
        kept = Trial(
            state,
            run.protocol,
            row.name,
            seed,
            [round(each, 2) for each in run.closed_s],
            [round(each, 2) for each in run.told_s],
            run.violations,
            run.counted,
            run.disk,
        )
        file = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
        try:
            os.write(file, (json.dumps(kept._asdict()) + "\n").encode())
        finally:
            os.close(file)

    def trials(self, state: str) -> list[Trial]:
        """Give all trials of a state of the code, in the order in which they ended."""
        if not self._path.exists():
            return []
        lines = self._path.read_text().splitlines()
        found = [Trial(**json.loads(each)) for each in lines if each.strip()]
        return [each for each in found if each.state == state]

    def passed(self, state: str) -> set[tuple[str, str, int]]:
        """Give what passed: protocol, row and seed. What did not is done again."""
        return {(x.protocol, x.row, x.seed) for x in self.trials(state) if not x.violations}


def table(trials: list[Trial]) -> str:
    """Write the table, in Markdown. Every violation counts, also where a repetition passed."""
    lines = [
        "| row | | runs | seeds | disk healthy / full / read-only / failing | violations"
        " | closed after, least / median / most (s) | limit (s)"
        " | told after, least / median / most (s) | what else |",
        "| --- | --- | --: | --- | --- | --: | --- | --: | --- | --- |",
    ]
    notes: list[str] = []
    for row in ROWS:
        for protocol in PROTOCOLS:
            mine = [x for x in trials if x.row == row.name and x.protocol == protocol]
            if mine:
                lines.append(_line(row, protocol, mine))
                notes += [
                    f"- {row.name}, {protocol}, seed {each.seed}, disk {each.disk}: {text}"
                    for each in mine
                    for text in each.violations
                ]
    lines += ["", _missing(trials), ""]
    return "\n".join([*lines, *notes, ""] if notes else lines)


def _line(row: Row, protocol: str, mine: list[Trial]) -> str:
    seeds = sorted({each.seed for each in mine})
    counted: Counter[str] = Counter()
    for each in mine:
        counted.update(each.counted)
    wrong = sum(len(each.violations) for each in mine)
    what = row.what + (" (limit from its end)" if row.obstacle else "")
    shown = f"{seeds[0]}–{seeds[-1]}" if len(seeds) > 1 else f"{seeds[0]}"
    limit = f"{row.limit(protocol):g}" if row.limit_s else "–"
    disks = " / ".join(str(sum(each.disk == disk for each in mine)) for disk in DISKS)
    return (
        f"| {what} | {protocol} | {len(mine)} | {shown} | {disks if row.disks else '–'} | {wrong}"
        f" | {_three([x for each in mine for x in each.closed_s])} | {limit}"
        f" | {_three([x for each in mine for x in each.told_s])}"
        f" | {', '.join(f'{number} × {name}' for name, number in sorted(counted.items()))} |"
    )


def _three(numbers: list[float]) -> str:
    if not numbers:
        return "–"
    return f"{min(numbers):.1f} / {median(numbers):.1f} / {max(numbers):.1f}"


def _missing(trials: list[Trial]) -> str:
    """Say what a whole proof would have run beside these."""
    done = {(each.protocol, each.row, each.seed) for each in trials}
    told = []
    for protocol in PROTOCOLS:
        rows = [row for row in ROWS if protocol in row.protocols]
        wanted = len(rows) * SEEDS[protocol]
        have = sum(
            (protocol, row.name, seed) in done
            for row in rows
            for seed in range(1, SEEDS[protocol] + 1)
        )
        told.append(f"{protocol}: {have} of {wanted} ({len(rows)} rows, {SEEDS[protocol]} seeds)")
    wrong = sum(len(each.violations) for each in trials)
    return f"{len(trials)} runs, {wrong} violations. Run of a whole proof: {'; '.join(told)}."
