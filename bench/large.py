"""The history's reads in a large store: cost must grow with what is asked, not with what is kept.

A thousand million samples would take half an hour to come in, so one day of a signal is made into
blocks and rollups by the store's own sealing and written again and again for further days and
signals, at their own times.
"""

from __future__ import annotations

import time
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SystemClock
from talaia.hub.history.blocks.block import BlockSamples, encode_block
from talaia.hub.history.engine import open_engine
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.store import HistoryStore
from talaia.hub.history.writing.bulk_writes import insert_rows
from talaia.hub.history.writing.compaction import Newest, Sealed, seal_tail
from talaia.hub.store import history_tables as tables
from talaia.hub.store.tables import metadata

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy import Engine

__all__ = ["SAMPLES_A_DAY", "SIGNALS", "Reads", "build", "measure_reads"]

DAY_US = 86_400_000_000
FIRST_DAY_US = 1_700_000_000_000_000 // DAY_US * DAY_US
SAMPLES_A_DAY = 8_640_000
SIGNALS = 10
PIXELS = 1_000
SITE = "agv"


class Reads(NamedTuple):
    """Milliseconds, all of them warm: the median of several, and of the windows the slowest.

    ``outliers_s`` is what the exact outliers of ``outliers_of`` samples take (s), where blocks have
    to be looked at twice: once for the quartiles, and once more to count.
    """

    day_ms: float
    widest_ms: float
    slowest_ms: float
    slowest_s: float
    week_of_all_ms: float
    outliers_s: float
    outliers_of: int


def build(url: str, signals: int, days: int) -> None:
    """Fill an empty database with days of 100 Hz of so many signals."""
    engine = open_engine(url, writes=True)
    metadata.create_all(engine, list(tables.HISTORY_TABLES))
    day = _day()
    made = seal_tail(
        1,
        0,
        first_block=1,
        longest_us=0,
        samples=day,
        block=HistoryLimits().largest,
        was_saved=False,
    )
    # Where in the day each block begins, to give the bodies of other days their own times.
    starts = np.cumsum([0, *(row["samples"] for row in made.blocks)]).tolist()
    parts = [day.slice_positions(first, past) for first, past in pairwise(starts)]
    with engine.begin() as connection:
        names = [_channel(number) for number in range(1, signals + 1)]
        insert_rows(connection, tables.channel, names)
    number = 1
    for channel in range(1, signals + 1):
        newest: Newest = {}
        for at in range(days):
            newest = _write(engine, made, parts, channel, number, at * DAY_US, newest)
            number += len(parts)
    engine.dispose()


def _day() -> BlockSamples:
    random = np.random.default_rng(7)
    at = np.arange(SAMPLES_A_DAY)
    time_us = FIRST_DAY_US + at * 10_000 + random.integers(0, 300, at.size)
    value = np.round(np.sin(at / 10_000) + random.normal(0, 0.1, at.size), 3)
    return BlockSamples(time_us, value, {})


def _channel(number: int) -> dict[str, object]:
    return {
        "id": number, "site": SITE, "address": f"base/s{number - 1}", "since_us": 0,
        "saved_row": 0, "longest_us": 0,
    }  # fmt: skip


def _write(
    engine: Engine,
    made: Sealed,
    parts: Sequence[BlockSamples],
    channel: int,
    number: int,
    shift_us: int,
    newest: Newest,
) -> Newest:
    """Write the day once more for a channel, so much later, with block numbers of its own."""
    times = ("first_us", "low_us", "high_us", "last_us")
    blocks, bodies = [], []
    for at, (row, part) in enumerate(zip(made.blocks, parts, strict=True), number):
        moved = {name: row[name] + shift_us for name in times}
        blocks.append({**row, **moved, "id": at, "channel_id": channel})
        body = encode_block(part._replace(time_us=part.time_us + shift_us))
        bodies.append({"block_id": at, "body": body})
    rollups = {
        width_us: cells._replace(
            bucket_us=cells.bucket_us + shift_us,
            low_us=cells.low_us + shift_us,
            high_us=cells.high_us + shift_us,
            last_us=cells.last_us + shift_us,
        )
        for width_us, cells in made.rollups.items()
    }
    sealed = made._replace(
        channel=channel, first_block=number, blocks=blocks, bodies=bodies, rollups=rollups
    )
    with engine.begin() as connection:
        newest = sealed.write_blocks(connection, newest)
    if engine.dialect.name == "sqlite":
        # The store does this beside its commits.
        opened = engine.raw_connection()
        opened.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)")
        opened.close()
    return newest


async def measure_reads(url: str, signals: int, days: int, windows: int = 60) -> Reads:
    """Ask for charts of 1000 pixels, each time after having asked for the same once."""
    store = HistoryStore(url, SystemClock())
    await store.open()

    async def took(addresses: Sequence[str], from_us: int, to_us: int, times: int) -> float:
        each = []
        for _ in range(times + 1):
            before = time.perf_counter()
            found = await store.read_series(SITE, addresses, from_us, to_us, width=PIXELS)
            each.append(time.perf_counter() - before)
            assert all(0 < series.time_us.size <= 2 * PIXELS for series in found)
        return float(np.median(each[1:])) * 1e3

    past = FIRST_DAY_US + days * DAY_US
    day_ms = await took(["base/s0"], FIRST_DAY_US, FIRST_DAY_US + DAY_US - 1, 15)
    widest_ms = await took(["base/s0"], FIRST_DAY_US, past - 1, 9)
    random = np.random.default_rng(3)
    slowest = (0.0, 0.0)
    for _ in range(windows):
        # As many short ones as long ones, anywhere.
        span_us = int(60e6 * (days * DAY_US / 60e6) ** random.random())
        first = int(random.integers(FIRST_DAY_US, past - span_us + 1))
        slowest = max(slowest, (await took(["base/s0"], first, first + span_us, 3), span_us / 1e6))
    everything = [f"base/s{at}" for at in range(signals)]
    week = min(days, 7) * DAY_US
    week_ms = await took(everything, FIRST_DAY_US, FIRST_DAY_US + week - 1, 7)
    outliers, many = [], 0
    for _ in range(3):
        before = time.perf_counter()
        # Nearly as long as exact ones are given for; so near the quartiles each block has some.
        upto = min(past, FIRST_DAY_US + int(11.5 * DAY_US)) - 1
        async for each in store.count_outliers(SITE, "base/s0", FIRST_DAY_US, upto, k=0.1):
            if each is not None:
                assert each.exact
                assert each.outliers > 0
                many = each.samples
        outliers.append(time.perf_counter() - before)
    await store.close()
    return Reads(day_ms, widest_ms, *slowest, week_ms, float(np.median(outliers)), many)
