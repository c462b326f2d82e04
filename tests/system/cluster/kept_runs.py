"""Runs of rows that were good for this state of the code: a proof that was ended goes on there."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from ..faults.ledgers import Findings
from ..proof_state import ROOT, code_state

KEPT = ROOT / "build" / "cluster.jsonl"


class KeptRuns:
    """What was found for this code, by row and turn; runs that failed are counted."""

    def __init__(self, crowd: tuple[int, int], file: Path = KEPT) -> None:
        """Read what was kept of runs with so many gateways and pages."""
        self._file = file
        self._of = {"state": code_state(), "crowd": list(crowd)}
        self._good: dict[tuple[str, int], Findings] = {}
        # What was wrong with runs that were repeated since.
        self.failed: list[str] = []
        lines = file.read_text().splitlines() if file.exists() else []
        for kept in map(json.loads, lines):
            if {name: kept[name] for name in self._of} == self._of:
                self._take(kept["row"], kept["turn"], _findings_of(kept["found"]))

    def find(self, row: str, turn: int) -> Findings | None:
        """Give a run that was good."""
        return self._good.get((row, turn))

    def keep(self, row: str, turn: int, found: Findings) -> None:
        """Keep a run, good or not."""
        self._file.parent.mkdir(exist_ok=True)
        # Not `dataclasses.asdict`: it makes mappings anew by their class, and a defaultdict's first
        # argument is no mapping.
        written = {"row": row, "turn": turn, "found": vars(found)}
        with self._file.open("a") as file:
            file.write(json.dumps({**self._of, **written}) + "\n")
        self._take(row, turn, found)

    def _take(self, row: str, turn: int, found: Findings) -> None:
        if found.violations:
            self.failed.append(f"{row}, run {turn + 1}: {'; '.join(found.violations)}")
        else:
            self._good[row, turn] = found


def _findings_of(kept: dict[str, Any]) -> Findings:
    found = Findings(**kept)
    found.counted = Counter(found.counted)
    found.figures = defaultdict(list, found.figures)
    return found
