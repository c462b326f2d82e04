"""History: blocks and rollups against one row a sample, in one run, as ratios.

Run ``python bench/history.py``: a day of one signal at 100 Hz, under a minute; or, for example,
``python bench/history.py --samples 3000000 --signals 10``. Beside the comparison, it measures what
the hub spends to store 20 channels at 100 Hz in 20 ms batches.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sqlite3
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SystemClock
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Callable

START = 1_700_000_000_000_000
BATCH = 1_000
PIXELS = 1_000


class Figures(NamedTuple):
    """What one way of storing costs."""

    rate: float
    cpu_s_per_million: float
    bytes_per_sample: float
    cold_ms: float
    warm_ms: float
    slowest_commit_ms: float


def batch(first: int, signals: int, count: int = BATCH, rate: int = 100) -> Columns:
    """Make noise rounded to 3 decimals on a drift, with jittered times, of so many signals."""
    random = np.random.default_rng(first)
    index = np.arange(first, first + count)
    at = index // signals
    time_us = START + at * (1_000_000 // rate) + random.integers(-300, 300, count)
    value = np.round(np.sin(at / 10_000) + random.normal(0, 0.1, count), 3)
    return Columns((index % signals).astype(np.uint16), time_us, value, {})


def drop_caches(path: Path) -> None:
    """Ask the kernel to forget the file, so that the next read comes from the disk."""
    for file in path.parent.glob(path.name + "*"):
        with file.open("rb") as opened:
            os.fsync(opened.fileno())
            os.posix_fadvise(opened.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


async def measure_blocks(path: Path, samples: int, signals: int) -> Figures:
    """Store and read by `HistoryStore`."""
    url = f"sqlite:///{path}"
    addresses = tuple(f"base/s{i}" for i in range(signals))
    store = HistoryStore(url, SystemClock())
    await store.create_tables()
    await store.open()
    commits, cpu = [], 0.0
    for first in range(0, samples, BATCH):
        columns = batch(first, signals)
        before, cpu_before = time.perf_counter(), time.process_time()
        await store.append("agv", "b", first, addresses, columns)
        commits.append(time.perf_counter() - before)
        cpu += time.process_time() - cpu_before
    await store.close()
    size = sum(file.stat().st_size for file in path.parent.glob(path.name + "*"))
    window = (START, START + samples // signals * 10_000)
    drop_caches(path)
    store = HistoryStore(url, SystemClock())
    await store.open()
    times = []
    for _ in range(6):
        before = time.perf_counter()
        (series,) = await store.read("agv", ["base/s0"], *window, PIXELS)
        times.append(time.perf_counter() - before)
        assert 0 < series.time_us.size <= 2 * PIXELS
    await store.close()
    return _figures(samples, sum(commits), cpu, size, times, commits)


def measure_rows(path: Path, samples: int, signals: int) -> Figures:
    """Store and read one row a sample, with the index such a table needs."""
    database = sqlite3.connect(path, isolation_level=None)
    database.execute("pragma journal_mode=wal")
    database.execute("pragma synchronous=full")
    database.execute(
        "create table sample (signal integer, time_us integer, value real,"
        " primary key (signal, time_us)) without rowid"
    )
    commits, cpu = [], 0.0
    for first in range(0, samples, BATCH):
        columns = batch(first, signals)
        before, cpu_before = time.perf_counter(), time.process_time()
        rows = zip(
            columns.channel.tolist(), columns.time_us.tolist(), columns.value.tolist(), strict=True
        )
        database.execute("begin immediate")
        database.executemany("insert or ignore into sample values (?, ?, ?)", rows)
        database.execute("commit")
        commits.append(time.perf_counter() - before)
        cpu += time.process_time() - cpu_before
    database.close()
    size = sum(file.stat().st_size for file in path.parent.glob(path.name + "*"))
    past = START + samples // signals * 10_000
    drop_caches(path)
    database = sqlite3.connect(path)
    times = []
    for _ in range(4):
        before = time.perf_counter()
        database.execute(
            "select (time_us - ?) / ?, min(value), max(value) from sample"
            " where signal = 0 and time_us between ? and ? group by 1",
            (START, max(1, (past - START) // PIXELS), START, past),
        ).fetchall()
        times.append(time.perf_counter() - before)
    database.close()
    return _figures(samples, sum(commits), cpu, size, times, commits)


def _figures(
    samples: int, spent: float, cpu: float, size: int, times: list[float], commits: list[float]
) -> Figures:
    return Figures(
        rate=samples / spent,
        cpu_s_per_million=cpu / samples * 1e6,
        bytes_per_sample=size / samples,
        cold_ms=times[0] * 1e3,
        warm_ms=float(np.median(times[1:])) * 1e3,
        slowest_commit_ms=float(np.percentile(commits, 99)) * 1e3,
    )


async def measure_idle_hub(path: Path, seconds: float) -> tuple[float, float]:
    """Store 20 channels at 100 Hz in 20 ms batches; give CPU in % of a core, and p99 wait in ms."""
    store = HistoryStore(f"sqlite:///{path}", SystemClock())
    await store.create_tables()
    await store.open()
    addresses = tuple(f"base/s{i}" for i in range(20))
    waits: list[float] = []

    async def append(first: int, columns: Columns) -> None:
        before = time.perf_counter()
        await store.append("agv", "b", first, addresses, columns)
        waits.append(time.perf_counter() - before)

    made = [batch(40 * at, 20, 40) for at in range(int(seconds * 50))]
    began, cpu = time.perf_counter(), time.process_time()
    async with asyncio.TaskGroup() as tasks:
        for at, columns in enumerate(made):
            await asyncio.sleep(max(0.0, began + at * 0.02 - time.perf_counter()))
            tasks.create_task(append(40 * at, columns))
    percent = (time.process_time() - cpu) / (time.perf_counter() - began) * 100
    await store.close()
    return percent, float(np.percentile(waits, 99)) * 1e3


def report(ours: Figures, rows: Figures, samples: int, signals: int) -> None:
    """Print the comparison."""
    each = samples // signals
    print(f"{samples} samples of {signals} signal(s), {BATCH} a durable commit, SQLite")
    print(f"{'':38}{'blocks':>10}{'rows':>10}{'ratio':>8}")

    def line(what: str, of: Callable[[Figures], float], more_is_better: bool = False) -> None:  # noqa: FBT001, FBT002
        mine, other = of(ours), of(rows)
        ratio = mine / other if more_is_better else other / mine
        print(f"{what:38}{mine:10.2f}{other:10.2f}{ratio:7.1f}×")

    line("ingest, k samples/s", lambda f: f.rate / 1e3, more_is_better=True)
    line("CPU, s per million samples", lambda f: f.cpu_s_per_million)
    line("p99 commit, ms", lambda f: f.slowest_commit_ms)
    line("bytes a sample", lambda f: f.bytes_per_sample)
    line(f"chart of {each} samples, cold, ms", lambda f: f.cold_ms)
    line(f"chart of {each} samples, warm, ms", lambda f: f.warm_ms)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=8_640_000, help="samples in all")
    parser.add_argument("--signals", type=int, default=1, help="signals they are of")
    parser.add_argument("--seconds", type=float, default=8.0, help="length of the hub's load")
    chosen = parser.parse_args()
    size = (chosen.samples, chosen.signals)
    with tempfile.TemporaryDirectory() as folder:
        ours = asyncio.run(measure_blocks(Path(folder) / "blocks.db", *size))
        rows = measure_rows(Path(folder) / "rows.db", *size)
        report(ours, rows, *size)
        percent, wait = asyncio.run(measure_idle_hub(Path(folder) / "load.db", chosen.seconds))
    load = "20 × 100 Hz in 20 ms batches"
    print(f"{load}: {percent:.1f} % of a core, acknowledged in {wait:.0f} ms (p99)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
