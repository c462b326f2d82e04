"""Two seeded nights; `make proofs ONLY=nights` lives through thirty, and longer ones."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("scipy")

from .trials import run_trial

# A full disk and a camera that hangs; a gateway that is killed while people are at work.
SEEDS = (2, 4)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_night_with_faults_and_people_ends_well(seed: int, tmp_path: Path) -> None:
    trial = run_trial(seed, tmp_path, hours=0.6)
    print(f"{trial.night_s / trial.took_s:.0f} times as fast")
    assert trial.wrong == ()
    # It was a night.
    assert trial.frames
