"""Live through seeded nights from dusk to dawn and write their table.

    PYTHONPATH=src:tests python -m system.nights [--seeds N] [--table FILE]

Goes on where it was: nights that went well for this state of the code are kept in
build/nights.jsonl. The exit code is 1 when a night has gone wrong. A machine that stands still
makes a run longer and changes nothing, so no run has to be repeated; a seed gives the same night
again.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
import tempfile
import traceback
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from ..proof_state import ROOT, code_state
from .trials import Trial, run_trial

SEEDS = 30
KEPT = ROOT / "build" / "nights.jsonl"


def run_seed(seed: int) -> Trial:
    """Live through one; what it raises is what is wrong with it."""
    logging.disable(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as folder:
        try:
            return run_trial(seed, Path(folder))
        except Exception:  # noqa: BLE001 - a night that raises has gone wrong, and others go on
            why = traceback.format_exc().splitlines()
            return Trial(seed, (), tuple(why[-3:]), 0.0, 0.0, 0, 0, 0)


def kept_trials(state: str) -> dict[int, Trial]:
    """Give the nights that went well for this code, by seed."""
    lines = KEPT.read_text().splitlines() if KEPT.exists() else []
    rows = [json.loads(line) for line in lines]
    known = [Trial(**row["trial"]) for row in rows if row["state"] == state]
    return {one.seed: one for one in known}


def keep_trial(state: str, trial: Trial) -> None:
    """Keep a night that went well."""
    KEPT.parent.mkdir(exist_ok=True)
    with KEPT.open("a") as file:
        file.write(json.dumps({"state": state, "trial": trial._asdict()}) + "\n")


def table_of(trials: list[Trial]) -> str:
    """Give the page."""
    wrong = sum(bool(one.wrong) for one in trials)
    computed = sum(one.took_s for one in trials)
    lived = sum(one.night_s for one in trials)
    rows = "\n".join(
        f"| {one.seed} | {', '.join(one.faults)} | {one.night_s / 3600:.1f} h | "
        f"{one.night_s / max(one.took_s, 1e-9):.0f} × | {one.completed} of {one.requests} | "
        f"{one.frames} | {'; '.join(one.wrong) or 'nothing'} |"
        for one in trials
    )
    return f"""# Seeded nights

Written by `make proofs ONLY=nights`. Each is a night from dusk, when somebody arms it, to the morning, on one [moved clock](decisions/0101-a-night-on-one-moved-clock.md): the simulated observatory, the gateway's interlocks, guard, commands and executor, with seeded weather, faults and people. What is judged is in `tests/system/nights/judge.py`: the roof by the simulator's own ledger (never open when unsafe or unknown for longer than closing takes, never begun to open), every request's end explained, no exposure archived twice or lost, a safe morning.

{len(trials)} nights, {wrong} of them wrong. {lived / 3600:.0f} hours were lived through in {computed:.0f} s of processor time, {lived / max(computed, 1e-9):.0f} times as fast as they go by.

| seed | what happened, beside weather | length | speed | completed | frames | wrong |
|---|---|---|---|---|---|---|
{rows}
"""  # noqa: E501 - a page of Markdown


def main() -> int:
    """Give 0 when none has gone wrong."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--table", type=Path)
    options = parser.parse_args()
    state = code_state()
    trials = kept_trials(state)
    left = [seed for seed in range(1, options.seeds + 1) if seed not in trials]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for one in pool.map(run_seed, left):
            trials[one.seed] = one
            if not one.wrong:
                keep_trial(state, one)
            speed = one.night_s / max(one.took_s, 1e-9)
            print(f"{one.seed}: {', '.join(one.faults)}: {speed:.0f} ×: {one.wrong or 'good'}")
            sys.stdout.flush()
    nights = [trials[seed] for seed in range(1, options.seeds + 1)]
    text = table_of(nights)
    if options.table is not None:
        options.table.write_text(text)
    return 1 if any(one.wrong for one in nights) else 0


if __name__ == "__main__":
    raise SystemExit(main())
