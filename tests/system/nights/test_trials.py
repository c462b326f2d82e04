"""Three seeded nights; `make proofs ONLY=nights` lives through thirty from dusk to dawn."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("scipy")

from .trials import run_trial


@pytest.mark.parametrize(
    ("seed", "hours", "faults"),
    [
        # From dusk to dawn; it is one of the shortest.
        (105, None, ("lost guide star", "stuck dome", "person commands", "hub away all night")),
        (2, 0.6, ("camera time-out", "full disk", "rapid request")),
        # Power comes back while the roof closes, with the telescope still standing.
        (8, 0.6, ("power cut", "dead gateway", "hands on site")),
    ],
)
def test_a_night_with_faults_and_people_ends_well(
    seed: int, hours: float | None, faults: tuple[str, ...], tmp_path: Path
) -> None:
    trial = run_trial(seed, tmp_path, hours=hours, faults=faults)
    print(f"{trial.night_s / trial.took_s:.0f} times as fast")
    assert trial.wrong == ()
    # It was a night.
    assert trial.frames
