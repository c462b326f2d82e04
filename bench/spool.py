"""The spool by itself, in a process of its own; prints one JSON object.

    python bench/spool.py rate     100 000 samples/s and more, each batch forced to disk
    python bench/spool.py day      what a day at 1 000 samples/s takes on disk, from ten minutes

The values are white noise in every bit of a double, and the times jitter by up to 0.9 ms: nothing
real compresses worse.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

# All that a gateway loads, so that its memory is counted.
import talaia.gateway.adapters.ros2.adapter
import talaia.gateway.run  # noqa: F401
from talaia.gateway.samples.batching import records_of
from talaia.gateway.spool.journal import SegmentHead, Spool
from talaia.gateway.spool.segment import read_records
from talaia.gateway.spool.sizes import USUAL
from talaia.wire.columns import Columns

CHANNELS = 20


def batches(count: int, size: int, period_us: int) -> list[Columns]:
    """Make batches ahead of the measurement."""
    noise = np.random.default_rng(1)
    made, now = [], 1_700_000_000_000_000
    for _ in range(count):
        times = now + np.arange(size) * period_us + noise.integers(0, 900, size)
        now += size * period_us
        channel = (np.arange(size) % CHANNELS).astype(np.uint16)
        made.append(Columns(channel, times, noise.normal(size=size), {}))
    return made


def spool_in(folder: str) -> Spool:
    """Open a spool for one boot."""
    head = SegmentHead("bench", "catalogue", [f"base/s{each}" for each in range(CHANNELS)])
    return Spool(folder=Path(folder), head=head, bound=4 << 30)


def rate() -> dict[str, float]:
    """Write batches of 20 ms at 100 000 samples/s as fast as they go, each forced to disk."""
    ready = batches(250, 2000, 10)
    with tempfile.TemporaryDirectory(prefix="talaia-spool-", dir=Path.cwd()) as folder:
        spool = spool_in(folder)
        first, began, cpu = 0, time.perf_counter(), time.process_time()
        for columns in ready:
            for record in records_of(columns, "bench", "catalogue", first):
                spool.append_record(record)
                first = record.end
            spool.sync_to_disk()
        took, used = time.perf_counter() - began, time.process_time() - cpu
        spool.close()
    return {
        "samples_per_s": first / took,
        "samples_per_cpu_s": first / used,
        "rss_mib": psutil.Process().memory_info().rss / 2**20,
    }


def day() -> dict[str, float]:
    """Keep ten minutes of 1 000 samples/s, as they come in batches of 20 ms."""
    with tempfile.TemporaryDirectory(prefix="talaia-spool-", dir=Path.cwd()) as folder:
        spool = spool_in(folder)
        first, began = 0, time.process_time()
        for columns in batches(30_000, 20, 1000):
            for record in records_of(columns, "bench", "catalogue", first):
                spool.append_record(record)
                first = record.end
        used = time.process_time() - began
        # The segment that is being written is not packed yet; there is one, however long it takes.
        *closed, current = sorted(Path(folder).glob("*.seg"))
        packed = sum(each.stat().st_size for each in closed)
        kept = next(each.first for _, each in read_records(current.read_bytes()) if each.samples)
        spool.close()
    whole = packed / kept * 86_400_000 + USUAL.segment
    return {"gib_a_day": whole / 2**30, "bytes_a_sample": packed / kept, "cpu_s": used}


if __name__ == "__main__":
    print(json.dumps({"rate": rate, "day": day}[sys.argv[1]]()))
