"""The order of a channel's samples is the order of their times, however late they are taken."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.arrival_times import Arrivals
from talaia.gateway.samples.batching import OVERRUN, Batcher
from talaia.gateway.samples.monotonic_times import STEP_BACK_US, MonotonicTimes
from talaia.gateway.spool.segment import SampleRecord
from talaia.wire.columns import Columns, slice_columns, unpack_columns
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

pytestmark = pytest.mark.pure

BEGAN_US = 1_700_000_000_000_000


def columns(channels: list[int], times: list[int]) -> Columns:
    return Columns(
        np.array(channels, np.uint16), np.array(times, np.int64), np.arange(len(times)) * 1.0, {}
    )


@given(
    st.lists(st.integers(1_000, 100_000), min_size=1, max_size=60),
    st.lists(st.integers(1_000, 5_000_000), min_size=1, max_size=30),
)
def test_messages_keep_their_order_and_their_times_however_long_the_thread_was_away(
    steps: list[int], away: list[int]
) -> None:
    came = (BEGAN_US + np.cumsum(steps)).tolist()
    arrivals, stamps, waiting, now = Arrivals(0), [], list(came), BEGAN_US
    while waiting:
        now += away[len(stamps) % len(away)]
        while waiting and waiting[0] <= now:
            stamps.append(arrivals.arrival_time(waiting.pop(0), now, (now - BEGAN_US) * 1000))
            now += 50
        arrivals.mark_awake((now - BEGAN_US) * 1000)
    assert stamps == came


def test_time_of_arrival_that_a_jump_of_the_clock_made_untrue_is_not_believed() -> None:
    arrivals = Arrivals(0)
    assert arrivals.arrival_time(BEGAN_US - 3_600_000_000, BEGAN_US, 5_000_000) == BEGAN_US
    assert arrivals.arrival_time(BEGAN_US + 3_600_000_000, BEGAN_US, 5_000_000) == BEGAN_US


# Two times lie less than a step back apart, also when each of 80 was mended by a microsecond.
MIXED_UP_US = STEP_BACK_US // 2 - 80


@given(
    st.lists(
        st.tuples(st.integers(0, 3), st.integers(-MIXED_UP_US, MIXED_UP_US)),
        min_size=1,
        max_size=80,
    ),
    st.integers(1, 20),
)
def test_times_of_a_channel_rise_whatever_was_mixed_up_on_the_way(
    jitter: list[tuple[int, int]], size: int
) -> None:
    told = columns([each for each, _ in jitter], [BEGAN_US + late for _, late in jitter])
    times = MonotonicTimes()
    made = [
        times.make_monotonic(slice_columns(told, at, at + size)) for at in range(0, len(told), size)
    ]
    mended = np.concatenate([each.time_us for each in made])
    for channel in range(4):
        mine = told.channel == channel
        assert (np.diff(mended[mine]) > 0).all()
        # Nothing is earlier than it was told, nor later than it must be.
        least, last = [], -(2**62)
        for time_us in told.time_us[mine].tolist():
            last = max(time_us, last + 1)
            least.append(last)
        assert mended[mine].tolist() == least


def test_clock_that_is_set_back_by_much_is_another_time_and_taken_as_it_is() -> None:
    times = MonotonicTimes()
    back = BEGAN_US - 3_600_000_000
    told = columns([1, 1, 1, 1], [BEGAN_US, back, back, back + 5])
    assert times.make_monotonic(told).time_us.tolist() == [BEGAN_US, back, back + 1, back + 5]


async def test_batches_carry_rising_times_when_threads_hand_over_late() -> None:
    kept: list[SampleRecord] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(),
        boot="b",
        catalogue="c",
        flush=60.0,
        keep=kept.append,
        lose=lambda *_: None,
    )
    batcher.put_samples(columns([7], [BEGAN_US + 10]))
    batcher.flush_batches()
    batcher.put_samples(columns([7, 7], [BEGAN_US + 9, BEGAN_US + 20]))
    batcher.flush_batches()
    times = []
    for record in kept:
        frame = LINK_FROM_GATEWAY.decode(record.body)
        assert isinstance(frame, SampleBatch)
        times += unpack_columns(frame).time_us.tolist()
    assert times == [BEGAN_US + 10, BEGAN_US + 11, BEGAN_US + 20]


async def test_gap_of_what_could_not_be_kept_up_with_spans_all_of_it(monkeypatch) -> None:
    monkeypatch.setattr("talaia.gateway.samples.batching.MAX_WAITING", 1)
    lost: list[tuple[SampleRecord, str]] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(), boot="b", catalogue="c", flush=60.0, keep=lambda _: None,
        lose=lambda record, why: lost.append((record, why)),
    )  # fmt: skip
    batcher.put_samples(columns([0, 0], [1, 2]))
    batcher.put_samples(columns([0, 0], [30, 40]))
    batcher.put_samples(columns([0], [50]))
    batcher.flush_batches()
    assert lost == [(SampleRecord(2, 3, 30, 50, b""), OVERRUN)]
