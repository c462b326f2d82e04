"""Files of the history beside DuckDB's of the same samples, in one run and by turns.

    PYTHONPATH=src:bench python bench/history_export.py [--samples 8640000] [--turns 5]

(``pip install --no-deps -r requirements/bench.txt`` first.) Both have the samples in a database of
their own on the disk, and write all of them into a Parquet file; DuckDB is given one thread, since
the history uses one, and then as many as it likes. Each file is read again by DuckDB and compared
with what was made: the same rows, none more and none less. Times are of the processor; the wall's
stand beside them.
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import duckdb
import numpy as np
import pyarrow as pa

from talaia.clock import SystemClock
from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
from talaia.hub.history.store import HistoryStore
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Callable

START = 1_700_000_000_000_000
BATCH = 20_000
WINDOW = (START - 10**9, START + 10**14)


class Samples(NamedTuple):
    """What is stored: the arrays have the shape (n,), and each channel's times rise."""

    channel: np.ndarray
    time_us: np.ndarray
    value: np.ndarray

    def addresses(self) -> list[str]:
        """Name the channels."""
        return [f"base/s{at}" for at in range(int(self.channel.max()) + 1)]


class Took(NamedTuple):
    """Seconds of one export, and the file's size in bytes."""

    cpu_s: float
    wall_s: float
    size: int


def make_samples(count: int, signals: int, *, together: bool, decimals: int = 3) -> Samples:
    """Make 100 Hz of noise on a drift; ``together``: with the same times."""
    chance = np.random.default_rng(signals)
    index = np.arange(count) // signals
    channel = (np.arange(count) % signals).astype(np.uint16)
    jitter = chance.integers(0, 300, index[-1] + 1)[index] if together else 0
    own = 0 if together else channel * 900 + chance.integers(0, 300, count)
    value = np.round(np.sin(index / 10_000) + chance.normal(0, 0.1, count), decimals)
    return Samples(channel, START + index * 10_000 + jitter + own, value)


async def store_samples(url: str, samples: Samples) -> None:
    """Put them into a history."""
    store = HistoryStore(url, SystemClock())
    await store.create_tables()
    await store.open()
    addresses = tuple(samples.addresses())
    for first in range(0, samples.time_us.size, BATCH):
        part = [column[first : first + BATCH] for column in samples]
        await store.append_samples(
            "agv", "b", first, addresses=addresses, columns=Columns(*part, {})
        )
    await store.close()


def wide_table(samples: Samples) -> pa.Table:
    """Make the rows that are due: one for each time, one column for each channel."""
    times, row = np.unique(samples.time_us, return_inverse=True)
    arrays = [pa.array(times).cast(pa.timestamp("us", "UTC"))]
    names = ["time", *samples.addresses()]
    for at in range(len(names) - 1):
        mine = samples.channel == at
        value, empty = np.zeros(times.size), np.ones(times.size, bool)
        value[row[mine]], empty[row[mine]] = samples.value[mine], False
        arrays.append(pa.array(value, mask=empty))
    return pa.table(arrays, names=names)


def long_table(samples: Samples) -> pa.Table:
    """Make a row for each sample, as one keeps signals that are read at times of their own."""
    time_us = pa.array(samples.time_us).cast(pa.timestamp("us", "UTC"))
    return pa.table([time_us, samples.channel, samples.value], names=["time", "channel", "value"])


def timed(work: Callable[[], Path]) -> Took:
    """Run an export."""
    cpu, wall = time.process_time(), time.perf_counter()
    file = work()
    return Took(time.process_time() - cpu, time.perf_counter() - wall, file.stat().st_size)


async def export_history(url: str, addresses: list[str], file: Path) -> Took:
    """Export by the history."""
    store = HistoryStore(url, SystemClock())
    await store.open()
    columns = [ExportColumn(address) for address in addresses]
    cpu, wall = time.process_time(), time.perf_counter()
    with file.open("wb") as out:
        async for piece in store.export_samples("agv", columns, *WINDOW, form=FileForm.PARQUET):
            out.write(piece)
    took = Took(time.process_time() - cpu, time.perf_counter() - wall, file.stat().st_size)
    await store.close()
    return took


def export_duckdb(database: Path, threads: int, file: Path, compression: str) -> Took:
    """Export by DuckDB, in the order of time, as ours is."""
    with duckdb.connect(str(database), config={"threads": threads} if threads else {}) as opened:

        def copy() -> Path:
            opened.execute(f"COPY samples TO '{file}' (FORMAT parquet, COMPRESSION {compression})")
            return file

        return timed(copy)


def fill_duckdb(database: Path, table: pa.Table) -> None:
    """Put rows into a database of DuckDB's."""
    with duckdb.connect(str(database)) as filling:
        filling.execute("SET TimeZone = 'UTC'")
        filling.register("made", table)
        filling.execute("CREATE TABLE samples AS SELECT * FROM made")


def differing_rows(file: Path, due: pa.Table) -> int:
    """Count rows that are in one of both and not in the other, or not as often."""
    with duckdb.connect() as judge:
        judge.execute("SET TimeZone = 'UTC'")
        judge.register("due", due)
        ours = f"(SELECT * FROM read_parquet('{file}'))"  # noqa: S608 - a name of ours
        return sum(
            judge.execute(f"SELECT count(*) FROM ({one} EXCEPT ALL {other})").fetchone()[0]  # noqa: S608
            for one, other in ((ours, "SELECT * FROM due"), ("SELECT * FROM due", ours))
        )


def measure(title: str, samples: Samples, *, long: bool, turns: int) -> int:
    """Print a table of both; give how many limits are missed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        url = f"sqlite:///{folder}/talaia.db"
        asyncio.run(store_samples(url, samples))
        due, database = wide_table(samples), folder / "peer.duckdb"
        fill_duckdb(database, due)
        ways = {
            "history": lambda file: asyncio.run(export_history(url, samples.addresses(), file)),
            "DuckDB, one thread": lambda file: export_duckdb(database, 1, file, "snappy"),
            "DuckDB, its own threads": lambda file: export_duckdb(database, 0, file, "snappy"),
            "DuckDB, one thread, zstd": lambda file: export_duckdb(database, 1, file, "zstd"),
        }
        if long:
            rows = folder / "rows.duckdb"
            fill_duckdb(rows, long_table(samples))
            ways["DuckDB, a row a sample"] = lambda file: export_duckdb(rows, 1, file, "snappy")
        found: dict[str, list[Took]] = {way: [] for way in ways}
        for _ in range(turns):
            for way, export in ways.items():
                found[way].append(export(folder / f"{len(way)}.parquet"))
        wrong = differing_rows(folder / f"{len('history')}.parquet", due)
    count = samples.time_us.size
    print(f"\n{title}: {count} samples, {due.num_rows} rows, median of {turns}")
    print(f"{'':28}{'CPU s':>8}{'wall s':>8}{'bytes a sample':>16}")
    medians = {way: [float(np.median(column)) for column in zip(*took, strict=True)]
               for way, took in found.items()}  # fmt: skip
    for way, (cpu, wall, size) in medians.items():
        print(f"{way:28}{cpu:8.2f}{wall:8.2f}{size / count:16.2f}")
    ratio = medians["history"][0] / medians["DuckDB, one thread"][0]
    print(f"history beside DuckDB's one thread: {ratio:.2f} of its processor time (limit 1)"
          f"{'  missed' if ratio > 1 else ''}; {wrong} rows differ")  # fmt: skip
    return (ratio > 1) + (wrong > 0)


def main() -> int:
    """Measure and print; give how many limits are missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=8_640_000)
    parser.add_argument("--turns", type=int, default=5)
    chosen = parser.parse_args()
    size, turns = chosen.samples, chosen.turns
    missed = measure("a signal", make_samples(size, 1, together=True), long=False, turns=turns)
    missed += measure(
        "a signal of fifteen decimals", make_samples(size // 2, 1, together=True, decimals=15),
        long=False, turns=turns,
    )  # fmt: skip
    missed += measure(
        "ten signals with the same times", make_samples(size, 10, together=True), long=False,
        turns=turns,
    )  # fmt: skip
    missed += measure(
        "ten signals with times of their own",
        make_samples(size // 4, 10, together=False), long=True, turns=turns,
    )  # fmt: skip
    print(f"\n{missed} limits missed" if missed else "\nall limits kept")
    return missed


if __name__ == "__main__":
    sys.exit(main())
