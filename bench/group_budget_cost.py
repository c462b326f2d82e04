"""What 200 signals at 1 Hz in groups of 20 cost where a site has a budget of false alarms.

    PYTHONPATH=src python bench/group_budget_cost.py [--beside 44] [--steps 200]

Each group has a day behind it: its signals are judged by their distance and each against the
others, with as many numbers of other devices beside as are asked for. Memory is all that Python and
NumPy take for the ten groups, traced, at its greatest while they run, the covariance's inversion
included; the learning is counted as well, of a group that has not learned yet. Time is the
processor's, sample by sample as live. A limit that is missed makes the exit code 1.
"""

from __future__ import annotations

import argparse
import copy
import sys
import time
import tracemalloc

import numpy as np

from talaia.hub.anomaly.budget.score_tail import ScoreTail
from talaia.hub.anomaly.groups.group_runner import GroupRunner
from talaia.model.alarms.anomaly import SignalGroup
from talaia.model.alarms.signal_groups import GroupSignals

GROUPS, SIGNALS, MOST_CORE, MOST_MB = 10, 20, 0.05, 40.0
_DAY_S, _ROWS = 86_400, 4_096
# A covariance is inverted anew at the latest after so many rows.
_RENEWED = 1_024


def _new_runner(beside: int) -> GroupRunner:
    names = tuple(f"device/signal_{at}" for at in range(SIGNALS))
    others = tuple(f"other/signal_{at}" for at in range(beside))
    group = SignalGroup(device="device", modes=4)
    asked = GroupSignals("device", group, names, names, "device", beside=others)
    runner = GroupRunner(asked)
    runner.tail = ScoreTail()
    return runner


def _show(runners: list[GroupRunner], first: int, rows: np.ndarray) -> float:
    """Show rows sample by sample as live; give the processor's time (s)."""
    began = time.process_time()
    for at, row in enumerate(rows.tolist()):
        for runner in runners:
            for place, value in enumerate(row):
                runner.score_sample(place, (first + at) * 1_000_000, value)
    return time.process_time() - began


def _measure(beside: int, steps: int) -> bool:
    rng = np.random.default_rng(1)
    width = SIGNALS + beside
    tracemalloc.start()
    fresh = [_new_runner(beside) for _ in range(GROUPS)]
    _show(fresh, 0, rng.normal(size=(700, width)))
    learning = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    runner = fresh[0]
    del fresh
    now = 700
    while now < _DAY_S + 2 * _RENEWED:
        times = (now + np.arange(_ROWS)) * 1_000_000
        runner.residuals.see_rows(times, rng.normal(size=(_ROWS, width)))
        now += _ROWS
    runner.set_needs((1e9,) * (1 + runner.residuals.magnitude_count))
    tracemalloc.start()
    runners = [copy.deepcopy(runner) for _ in range(GROUPS)]
    for one in runners:
        one.residuals.see_rows(
            (now + np.arange(_RENEWED)) * 1_000_000, rng.normal(size=(_RENEWED, width))
        )
    now += _RENEWED
    _show(runners, now, rng.normal(size=(20, width)))
    most = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    now += 20
    core = _show(runners, now, rng.normal(size=(steps, width))) / steps
    kept = len(runner.dump_state()) / 1e6
    print(
        f"{GROUPS * SIGNALS} signals at 1 Hz in groups of {SIGNALS}, under a budget, each group"
        f" beside {beside} other numbers: {core:.2%} of a core (limit {MOST_CORE:.0%}), at most"
        f" {learning:.1f} MB in their first minutes and {most:.1f} MB after a day (limit"
        f" {MOST_MB:.0f}); kept {kept:.2f} MB a group"
    )
    return core <= MOST_CORE and max(learning, most) <= MOST_MB


def main() -> int:
    """Print what it costs; 1 when a limit is missed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--beside", type=int, default=44)
    parser.add_argument("--steps", type=int, default=200)
    asked = parser.parse_args()
    return 0 if _measure(asked.beside, asked.steps) else 1


if __name__ == "__main__":
    sys.exit(main())
