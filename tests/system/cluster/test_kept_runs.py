"""Runs that are kept for the next proof of the same code."""

from __future__ import annotations

from pathlib import Path

from ..faults.ledgers import Findings
from .kept_runs import KeptRuns


def test_a_good_run_is_found_again_with_all_that_it_measured(tmp_path: Path) -> None:
    found = Findings(stops_ms=[1.5], turn=2)
    found.counted["acknowledged"] += 7
    found.figures["another led after, s"] += [1.4, 1.5]
    KeptRuns((200, 50), tmp_path / "build" / "kept.jsonl").keep("K1", 2, found)

    kept = KeptRuns((200, 50), tmp_path / "build" / "kept.jsonl").find("K1", 2)

    assert kept == found
    assert kept is not found
    kept.figures["back, s"].append(1.0)
    kept.counted["lost"] += 1


def test_a_run_with_another_crowd_or_another_turn_is_not_found(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    KeptRuns((200, 50), file).keep("K1", 0, Findings())

    assert KeptRuns((20, 5), file).find("K1", 0) is None
    assert KeptRuns((200, 50), file).find("K1", 1) is None


def test_a_run_with_a_violation_is_counted_and_done_again(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    KeptRuns((200, 50), file).keep("K2", 0, Findings(violations=["I1: one was lost"]))

    again = KeptRuns((200, 50), file)

    assert again.find("K2", 0) is None
    assert again.failed == ["K2, run 1: I1: one was lost"]
