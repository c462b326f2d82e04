"""What a test on a month of stored history takes: one signal at 1 Hz, by the hub's own code.

    PYTHONPATH=src python bench/back_test.py [--days 30] [--runs 1] [--detector together]

The signal has a rhythm of the day, a drift and noise, rounded to three decimals; it is written to a
store on SQLite in a temporary folder and read from there. A test computes half of the time at most,
so the wait is twice the time of a core. A limit that is missed makes the exit code 1.
"""

from __future__ import annotations

import argparse
import asyncio
import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from talaia.clock import SystemClock
from talaia.hub.anomaly.runner import DetectorRunner
from talaia.hub.history.store import HistoryStore
from talaia.hub.live.detection.back_test import BackTest, BackTests, SignalTrial, TestState
from talaia.model.alarms.anomaly import DetectorKind, Watch
from talaia.wire.columns import Columns

# Of a core, for a month (s).
MOST_S = 30.0
DAY_S = 86_400
_BEGAN_S = 1_790_000_000 // DAY_S * DAY_S
_BATCH = 3_600


async def _fill_store(store: HistoryStore, days: int) -> None:
    rng, level = np.random.default_rng(1), 0.0
    for first in range(0, days * DAY_S, _BATCH):
        at = np.arange(first, first + _BATCH)
        drift = level + np.cumsum(rng.normal(0, 0.002, _BATCH))
        level = float(drift[-1])
        values = 20 + 3 * np.sin(2 * np.pi * at / DAY_S) + drift + rng.normal(0, 0.1, _BATCH)
        columns = Columns(
            np.zeros(_BATCH, np.uint16), (_BEGAN_S + at) * 1_000_000, np.round(values, 3), {}
        )
        await store.append_samples("agv", "b", first, addresses=("base/s",), columns=columns)


async def _test_past(store: HistoryStore, days: int, detector: str) -> BackTest:
    runner = DetectorRunner("base/s", "", Watch(detector=DetectorKind(detector)))
    tests = BackTests(store)
    from_us, to_us = _BEGAN_S * 1_000_000, (_BEGAN_S + days * DAY_S) * 1_000_000
    test = tests.begin_test("agv", SignalTrial(runner), from_us, to_us)
    while test.state is TestState.RUNNING:
        await asyncio.sleep(0.05)
    return test


async def _measure(folder: str, days: int, runs: int, detector: str) -> float:
    store = HistoryStore(f"sqlite:///{Path(folder) / 'history.db'}", SystemClock())
    await store.create_tables()
    await store.open()
    await _fill_store(store, days)
    least = math.inf
    for _ in range(runs):
        began, used = time.perf_counter(), time.process_time()
        test = await _test_past(store, days, detector)
        took, used = time.perf_counter() - began, time.process_time() - used
        if test.state is not TestState.DONE:
            raise SystemExit(f"the test is {test.state}: {test.problem}")
        print(
            f"{detector}: {test.rows} samples, {test.count} anomalies; of a core {used:.1f} s with"
            f" all that reads, {test.cpu_s:.1f} s the detector:"
            f" {test.cpu_s / max(1, test.rows) * 1e6:.1f} µs a sample; waited for {took:.1f} s",
            flush=True,
        )
        least = min(least, used * 30 / days)
    await store.close()
    print(f"a month, by the least of them: {least:.0f} s of a core (limit {MOST_S:g})")
    return least


def main() -> int:
    """Print what it took; 1 when that is above the limit."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--days", type=int, default=30)
    parser.add_argument("--runs", type=int, default=1, help="the least of them counts")
    parser.add_argument("--detector", default="together")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        return int(asyncio.run(_measure(folder, asked.days, asked.runs, asked.detector)) > MOST_S)


if __name__ == "__main__":
    sys.exit(main())
