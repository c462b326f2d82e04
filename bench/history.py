"""History: blocks and rollups against one row a sample, in one run, each figure beside its limit.

Run ``python bench/history.py``: a day of one signal at 100 Hz on SQLite, and three million samples
on each database server that answers on this machine; or, for example, ``python bench/history.py
--samples 3000000 --signals 10 --servers 0``. ``--large 12 --samples 0 --servers 0`` measures reads
only, in a store of a thousand million samples (twelve days of ten signals); that takes 3 GB of disk
and some minutes. It ends with the number of limits that are missed.

Batches come one after the other: each is durable before the next is sent, so none shares a commit.
DuckDB stands beside the many short series where it is installed (requirements/bench.txt).

The file is longer than 300 lines because what is measured and its limits are read together.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import large
import numpy as np
import sqlalchemy as sa
from rows import RowTables, database_bytes

from talaia.clock import SystemClock
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

START = 1_700_000_000_000_000
BATCH = 1_000
PIXELS = 1_000
MEANWHILE_US = 600_000_000
SERVERS = {
    "PostgreSQL": "postgresql+pg8000://postgres@127.0.0.1/postgres",
    "MariaDB": "mysql+pymysql://root@127.0.0.1/mysql",
}


class Figures(NamedTuple):
    """What one way of storing costs; NaN is not measured."""

    rate: float
    cpu: float
    commit_ms: float
    size: float
    written: float
    meanwhile_ms: float
    cold_ms: float
    warm_ms: float
    warm_cpu_ms: float


class Row(NamedTuple):
    """A line of the table: what, which figure, its limit, and how much better than rows."""

    what: str
    name: str
    limit: float = float("nan")
    more: bool = False
    times: float = float("nan")


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


def written_bytes() -> int:
    """Give what this process has had written to devices so far."""
    lines = Path("/proc/self/io").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("write_bytes"))


def path_of(url: str) -> Path | None:
    """Give a SQLite database's file."""
    parsed = sa.make_url(url)
    return Path(parsed.database or "") if parsed.get_backend_name() == "sqlite" else None


def size_of(url: str) -> int:
    """Give what a database takes (bytes)."""
    path = path_of(url)
    if path is None:
        return database_bytes(url)
    return sum(file.stat().st_size for file in path.parent.glob(path.name + "*"))


async def measure_blocks(url: str, samples: int, signals: int) -> Figures:
    """Store and read by `HistoryStore`; a chart is asked for meanwhile."""
    addresses = tuple(f"base/s{i}" for i in range(signals))
    store = HistoryStore(url, SystemClock())
    await store.create_tables()
    await store.open()
    commits: list[float] = []
    meanwhile: list[float] = []
    cpu, before_written = 0.0, written_bytes()

    async def look() -> None:
        while True:
            await asyncio.sleep(0.1)
            past = START + len(commits) * BATCH // signals * 10_000
            before = time.perf_counter()
            await store.read_series("agv", ["base/s0"], past - MEANWHILE_US, past, width=PIXELS)
            meanwhile.append(time.perf_counter() - before)

    looking = asyncio.create_task(look())
    for first in range(0, samples, BATCH):
        columns = batch(first, signals)
        before, cpu_before = time.perf_counter(), time.process_time()
        await store.append_samples("agv", "b", first, addresses=addresses, columns=columns)
        commits.append(time.perf_counter() - before)
        cpu += time.process_time() - cpu_before
    looking.cancel()
    await asyncio.gather(looking, return_exceptions=True)
    await store.close()
    written = written_bytes() - before_written
    size = size_of(url)
    window = (START, START + samples // signals * 10_000)
    path = path_of(url)
    if path is not None:
        drop_caches(path)
    store = HistoryStore(url, SystemClock())
    await store.open()
    times = []
    for _ in range(20):
        before = time.perf_counter(), time.process_time()
        (series,) = await store.read_series("agv", ["base/s0"], *window, width=PIXELS)
        times.append((time.perf_counter() - before[0], time.process_time() - before[1]))
        assert 0 < series.time_us.size <= 2 * PIXELS
    await store.close()
    return figures(url, samples, commits, cpu, size, written, meanwhile, times)


def measure_rows(url: str, samples: int, signals: int) -> Figures:
    """Store and read one row a sample."""
    tables = RowTables(url, signals)
    cpu, commits, before_written = 0.0, [], written_bytes()
    for first in range(0, samples, BATCH):
        columns = batch(first, signals)
        cpu_before = time.process_time()
        commits.append(tables.store(columns))
        cpu += time.process_time() - cpu_before
    tables.engine.dispose()
    written, size = written_bytes() - before_written, size_of(url)
    path = path_of(url)
    if path is not None:
        drop_caches(path)
    past = START + samples // signals * 10_000
    times = []
    for _ in range(4):
        cpu_before = time.process_time()
        took = tables.chart(START, past, PIXELS)
        times.append((took, time.process_time() - cpu_before))
    tables.engine.dispose()
    return figures(url, samples, commits, cpu, size, written, [], times)


def figures(
    url: str,
    samples: int,
    commits: list[float],
    cpu: float,
    size: int,
    written: int,
    meanwhile: list[float],
    times: list[tuple[float, float]],
) -> Figures:
    """Sum up what was measured; ``times`` are each chart's, of the wall and of the processor."""
    ours = path_of(url) is not None  # what a server writes is not in our process's account
    return Figures(
        rate=samples / sum(commits) / 1e3,
        cpu=cpu / samples * 1e6,
        commit_ms=float(np.percentile(commits, 99)) * 1e3,
        size=size / samples,
        written=written / samples if ours else float("nan"),
        meanwhile_ms=float(np.percentile(meanwhile, 95)) * 1e3 if meanwhile else float("nan"),
        cold_ms=times[0][0] * 1e3,
        warm_ms=float(np.median([wall for wall, _ in times[1:]])) * 1e3,
        warm_cpu_ms=float(np.median([of_core for _, of_core in times[1:]])) * 1e3,
    )


def report(title: str, rows: list[Row], ours: Figures, peer: Figures | None) -> int:
    """Print a table; give how many limits are missed."""
    print(f"\n{title}")
    print(f"{'':36}{'blocks':>9}{'limit':>9}{'rows':>10}{'ratio':>8}{'limit':>7}")
    missed = 0
    for row in rows:
        mine = getattr(ours, row.name)
        other = getattr(peer, row.name) if peer is not None else float("nan")
        ratio = mine / other if row.more else other / mine
        bad = mine < row.limit if row.more else mine > row.limit
        bad = bad or ratio < row.times
        missed += bool(bad)
        limit = "" if np.isnan(row.limit) else f"{'≥' if row.more else '≤'} {row.limit:g}"
        times = "" if np.isnan(row.times) else f"≥{row.times:g}×"
        print(
            f"{row.what:36}{mine:9.2f}{limit:>9}{other:10.2f}{ratio:7.1f}×{times:>7}"
            f"{'  missed' if bad else ''}"
        )
    return missed


def lines(rate: float, smaller: float, chart: str, *, day: bool) -> list[Row]:
    """Give the figures with the limits that hold for a database."""
    nan = float("nan")
    return [
        Row("ingest, k samples/s", "rate", rate, more=True),
        Row("CPU, s per million samples", "cpu"),
        Row("p99 commit, ms", "commit_ms", 25),
        Row("bytes a sample", "size", 5 if day else nan, times=smaller),
        Row("bytes written a sample", "written", 40),
        Row("chart of 10 min meanwhile, p95, ms", "meanwhile_ms", 25),
        Row(f"{chart}, cold, ms", "cold_ms", 60 if day else nan),
        Row(f"{chart}, warm, ms", "warm_ms", 10 if day else nan, times=100 if day else nan),
        # What a server computes for it is not in our process's account.
        Row("the same, ms of CPU", "warm_cpu_ms", 5 if day else nan),
    ]


def on_servers(samples: int) -> int:
    """Measure each server that answers; give how many limits are missed."""
    missed = 0
    for name, server in SERVERS.items():
        admin = sa.create_engine(server, isolation_level="AUTOCOMMIT")
        try:
            admin.connect().close()
        except (sa.exc.SQLAlchemyError, OSError):
            print(f"\n{name}: no server answers here")
            continue
        found = []
        for kind in ("blocks", "rows"):
            database = f"talaia_bench_{os.getpid()}"
            url = sa.make_url(server).set(database=database).render_as_string(hide_password=False)
            with admin.connect() as connection:
                connection.exec_driver_sql(f"CREATE DATABASE {database}")
            try:
                if kind == "blocks":
                    found.append(asyncio.run(measure_blocks(url, samples, 1)))
                else:
                    found.append(measure_rows(url, samples, 1))
            finally:
                with admin.connect() as connection:
                    connection.exec_driver_sql(f"DROP DATABASE {database}")
        admin.dispose()
        rate = 300 if name == "PostgreSQL" else 200
        shown = lines(rate, 8, f"chart of {samples}", day=False)
        title = f"{name}, {samples} samples of 1 signal, {BATCH} a durable commit"
        missed += report(title, shown, *found)
    return missed


def on_large(folder: str, days: int) -> int:
    """Measure reads in a small store and in a large one; give how many limits are missed."""
    few, many = f"sqlite:///{folder}/day.db", f"sqlite:///{folder}/large.db"
    large.build(few, 1, 1)
    small = asyncio.run(large.measure_reads(few, 1, 1, windows=1))
    began = time.perf_counter()
    large.build(many, large.SIGNALS, days)
    took, size = time.perf_counter() - began, size_of(many)
    found = asyncio.run(large.measure_reads(many, large.SIGNALS, days))
    samples = large.SIGNALS * days * large.SAMPLES_A_DAY
    per_signal = days * large.SAMPLES_A_DAY / 1e6
    print(
        f"\nSQLite, {samples / 1e6:.0f} M samples of {large.SIGNALS} signals at 100 Hz, warm, "
        f"{PIXELS} pixels ({size / samples:.2f} bytes a sample, built in {took:.0f} s)"
    )
    missed = 0
    for what, measured, limit, unit in (
        (f"chart of all {per_signal:.0f} M samples of a signal", found.widest_ms, 40, "ms"),
        (f"slowest window of 60 (of {found.slowest_s:.0f} s)", found.slowest_ms, 40, "ms"),
        ("ten signals over a week", found.week_of_all_ms, 100, "ms"),
        (f"exact outliers of {found.outliers_of / 1e6:.0f} M samples", found.outliers_s, 5, "s"),
        ("chart of a day", found.day_ms, 40, "ms"),
        (f"beside {small.day_ms:.1f} ms with 8.64 M in the store", found.day_ms / small.day_ms, 2,
         "times"),
    ):  # fmt: skip
        bad = measured > limit
        missed += bad
        print(f"{what:48}{measured:9.2f} {unit:6}≤ {limit}{'  missed' if bad else ''}")
    return missed


async def measure_idle_hub(path: Path, seconds: float) -> tuple[float, float]:
    """Store 20 channels at 100 Hz in 20 ms batches; give CPU in % of a core, and p99 wait in ms."""
    store = HistoryStore(f"sqlite:///{path}", SystemClock())
    await store.create_tables()
    await store.open()
    addresses = tuple(f"base/s{i}" for i in range(20))
    waits: list[float] = []

    async def append(first: int, columns: Columns) -> None:
        before = time.perf_counter()
        await store.append_samples("agv", "b", first, addresses=addresses, columns=columns)
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


async def measure_short_series(
    path: Path, series: int, each: int, size: int
) -> tuple[float, float, float]:
    """Store a few samples of many signals.

    Gives CPU in s a million samples, bytes a sample, and the same with a plain row of each signal,
    which a hub writes for views within two seconds.
    """
    url = f"sqlite:///{path}"
    # Whether a turn of plain rows comes within the run must not be the disk's to say.
    store = HistoryStore(url, SystemClock(), HistoryLimits(show_s=0.0))
    await store.create_tables()
    await store.open()
    addresses = tuple(f"base/s{i}" for i in range(series))
    made = [(first, batch(first, series, size, 1)) for first in range(0, series * each, size)]
    cpu = time.process_time()
    for first, columns in made:
        await store.append_samples("agv", "b", first, addresses=addresses, columns=columns)
    await store.close()
    cpu = time.process_time() - cpu
    room = size_of(url)
    store = HistoryStore(url, SystemClock(), HistoryLimits(show_s=0.0))
    await store.open()
    await store.write_plain_rows()
    await store.close()
    count = series * each
    return cpu / count * 1e6, room / count, size_of(url) / count


def measure_duckdb(path: Path, series: int, each: int, size: int) -> tuple[float, float] | None:
    """Store the same in DuckDB, each batch durable by itself; None where it is not installed."""
    try:
        import duckdb
        import pyarrow as pa
    except ImportError:
        return None
    made = [batch(first, series, size, 1) for first in range(0, series * each, size)]
    tables = [pa.table([b.channel, b.time_us, b.value], names=["c", "t", "v"]) for b in made]
    cpu = time.process_time()
    with duckdb.connect(str(path), config={"threads": 1}) as peer:
        peer.execute("CREATE TABLE samples (c USMALLINT, t BIGINT, v DOUBLE)")
        for table in tables:
            peer.register("made", table)
            peer.execute("INSERT INTO samples SELECT * FROM made")
    cpu = time.process_time() - cpu
    size = sum(file.stat().st_size for file in path.parent.glob(path.name + "*"))
    return cpu / (series * each) * 1e6, size / (series * each)


def on_short_series(folder: str, series: int, each: int = 30) -> int:
    """Measure many signals that have said little; give how many limits are missed."""
    missed = 0
    for size in (1_000, 10_000):
        ours, theirs = [], []
        # By turns, of which the median counts: one takes half a second.
        for turn in range(5):
            path = Path(folder) / f"short{size}-{turn}.db"
            ours.append(asyncio.run(measure_short_series(path, series, each, size)))
            peer = measure_duckdb(path.with_suffix(".duckdb"), series, each, size)
            theirs += [peer] if peer is not None else []
        cpu, room, shown = (float(np.median(column)) for column in zip(*ours, strict=True))
        missed += (cpu > 0.8) + (room > 6)
        print(
            f"{series} signals of {each} samples, {size} a commit: {cpu:.2f} s of CPU a million "
            f"(limit 0.8), {room:.1f} bytes a sample (limit 6), {shown:.1f} with plain rows"
        )
        if theirs:
            cpu, room = (float(np.median(column)) for column in zip(*theirs, strict=True))
            print(f"{'':4}DuckDB, one thread: {cpu:.2f} s of CPU a million, {room:.1f} bytes")
    return missed


def on_sqlite(folder: str, chosen: argparse.Namespace) -> int:
    """Measure SQLite; give how many limits are missed."""
    size = (chosen.samples, chosen.signals)
    each = chosen.samples // chosen.signals
    ours = asyncio.run(measure_blocks(f"sqlite:///{folder}/blocks.db", *size))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    peer = measure_rows(f"sqlite:///{folder}/rows.db", *size) if chosen.rows else None
    day = each == 8_640_000
    chart = "chart of a day at 100 Hz" if day else f"chart of {each}"
    title = f"SQLite, {size[0]} samples of {size[1]} signal(s), {BATCH} a durable commit"
    missed = report(title, lines(600, 4, chart, day=day), ours, peer)
    if chosen.seconds:
        percent, wait = asyncio.run(measure_idle_hub(Path(folder) / "l.db", chosen.seconds))
        load = "20 × 100 Hz in 20 ms batches"
        print(f"{load}: {percent:.1f} % of a core, acknowledged in {wait:.0f} ms (p99)")
    print(f"memory of the process that stored the blocks: {memory:.0f} MiB (limit 300)")
    return missed + (memory > 300)


def main() -> int:
    """Measure and print; give how many limits are missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=8_640_000, help="samples in all, on SQLite")
    parser.add_argument("--signals", type=int, default=1, help="signals they are of")
    parser.add_argument("--rows", type=int, default=1, help="0 leaves the tables of rows out")
    parser.add_argument("--servers", type=int, default=3_000_000, help="samples on each server")
    parser.add_argument("--large", type=int, default=0, help="days of a large store; 0 for none")
    parser.add_argument("--series", type=int, default=10_000, help="signals of 30 samples each")
    parser.add_argument("--seconds", type=float, default=8.0, help="length of the hub's load")
    chosen = parser.parse_args()
    missed = 0
    with tempfile.TemporaryDirectory() as folder:
        if chosen.samples:
            missed += on_sqlite(folder, chosen)
        if chosen.series:
            missed += on_short_series(folder, chosen.series)
        if chosen.large:
            missed += on_large(folder, chosen.large)
    if chosen.servers:
        missed += on_servers(chosen.servers)
    print(f"\n{missed} limits missed" if missed else "\nall limits kept")
    return missed


if __name__ == "__main__":
    sys.exit(main())
