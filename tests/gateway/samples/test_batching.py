"""Samples become numbered batches, and come back from them."""

from __future__ import annotations

import asyncio

import numpy as np
from hypothesis import given, strategies as st

from talaia.gateway.samples.batching import Batcher, records_of
from talaia.gateway.spool.segment import SampleRecord
from talaia.wire.columns import Columns, unpack_columns
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch


def columns(times: list[int], texts: dict[int, str] | None = None) -> Columns:
    count = len(times)
    return Columns(
        np.zeros(count, np.uint16),
        np.array(times, np.int64),
        np.arange(count, dtype=np.float64),
        texts or {},
    )


@given(st.lists(st.integers(0, 2**40), max_size=50), st.sets(st.integers(0, 49)))
def test_columns_come_back_from_their_batches_however_far_apart(
    times: list[int], marked: set[int]
) -> None:
    texts = {at: f"t{at}" for at in marked if at < len(times)}
    made = records_of(columns(times, texts), "b", "c", 100)
    back, words, sequence = [], {}, 100
    for record in made:
        frame = LINK_FROM_GATEWAY.decode(record.body)
        assert isinstance(frame, SampleBatch)
        assert (frame.first, record.first) == (sequence, sequence)
        part = unpack_columns(frame)
        words |= {sequence - 100 + at: text for at, text in part.texts.items()}
        back += list(part.time_us)
        sequence = record.end
    assert back == times
    assert words == texts


async def test_batches_are_numbered_and_made_once_per_flush() -> None:
    kept: list[SampleRecord] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(),
        boot="b",
        catalogue="c",
        flush=60.0,
        keep=kept.append,
        lose=lambda *_: None,
    )
    batcher.put_samples(columns([1, 2]))
    batcher.put_samples(columns([3], {0: "three"}))
    batcher.flush_batches()
    frame = LINK_FROM_GATEWAY.decode(kept[0].body)
    assert isinstance(frame, SampleBatch)
    assert frame.texts == {2: "three"}
    batcher.put_samples(columns([4]))
    batcher.flush_batches()
    batcher.flush_batches()
    assert [(each.first, each.end) for each in kept] == [(0, 3), (3, 4)]


async def test_time_in_which_nothing_was_heard_is_a_gap_with_a_number_of_its_own() -> None:
    kept: list[SampleRecord] = []
    lost: list[tuple[SampleRecord, str]] = []
    batcher = Batcher(
        loop=asyncio.get_running_loop(), boot="b", catalogue="c", flush=60.0, keep=kept.append,
        lose=lambda record, why: lost.append((record, why)),
    )  # fmt: skip
    batcher.put_samples(columns([1, 2]))
    batcher.flush_batches()
    batcher.record_gap(10, 20, "stood still")
    batcher.put_samples(columns([3]))
    batcher.flush_batches()
    assert lost == [(SampleRecord(2, 1, 10, 20, b""), "stood still")]
    assert [(each.first, each.end) for each in kept] == [(0, 2), (3, 4)]
