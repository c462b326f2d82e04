"""Blocks and journal rows: samples as bytes, every bit kept."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.blocks.block import (
    BlockSamples,
    LastTimes,
    concatenate_samples,
    decode_block,
    decode_run,
    encode_block,
    in_order,
    split_blocks,
)
from talaia.hub.history.blocks.journal import part_of, read_row, write_row
from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import Columns

pytestmark = pytest.mark.pure

BLOCK = 4096
times = st.one_of(st.integers(-(2**61), 2**61), st.integers(0, 10_000_000))
bits = st.integers(0, 2**64 - 1)


@st.composite
def many(draw, least=1):
    pairs = draw(st.lists(st.tuples(times, bits), min_size=least, max_size=50))
    texts = draw(st.dictionaries(st.integers(0, max(0, len(pairs) - 1)), st.text(), max_size=5))
    return BlockSamples(
        np.array([t for t, _ in pairs], np.int64),
        np.array([b for _, b in pairs], np.uint64).view(np.float64),
        texts if pairs else {},
    )


def same(one, other) -> bool:
    return (
        np.array_equal(one.time_us, other.time_us)
        and np.array_equal(one.value.view(np.uint64), other.value.view(np.uint64))
        and one.texts == other.texts
    )


@given(many())
def test_a_block_keeps_every_bit(samples) -> None:
    assert same(decode_block(encode_block(samples)), samples)


@given(many(), st.data())
def test_a_journal_row_keeps_every_bit(samples, data) -> None:
    channel = np.arange(samples.time_us.size, dtype=np.uint16)
    columns = Columns(channel, *samples)
    assert same(read_row(write_row(columns)), samples)
    first = data.draw(st.integers(0, channel.size - 1))
    past = data.draw(st.integers(first + 1, channel.size))
    part = read_row(write_row(part_of(columns, first, past)))
    assert same(part, samples.slice_positions(first, past))
    assert part.channel.tolist() == channel[first:past].tolist()


@given(many(least=2))
def test_cutting_loses_nothing_and_keeps_the_order(samples) -> None:
    samples = in_order(samples)
    assert same(concatenate_samples(list(split_blocks(samples, BLOCK))), samples)


def test_one_time_stamp_keeps_the_order_of_arrival() -> None:
    samples = in_order(
        BlockSamples(np.array([5, 3, 5, 3]), np.array([1.0, 2.0, 3.0, 4.0]), {2: "x"})
    )
    assert samples.value.tolist() == [2.0, 4.0, 1.0, 3.0]
    assert samples.texts == {3: "x"}


def test_a_wrong_clock_gets_a_block_of_its_own() -> None:
    time_us = np.concatenate(([0], 1_700_000_000_000_000 + np.arange(100) * 10_000))
    parts = list(split_blocks(BlockSamples(time_us, np.zeros(101), {}), BLOCK))
    assert [part.time_us.size for part in parts] == [1, 100]


def test_a_slow_channel_is_not_cut_at_each_sample() -> None:
    day = 86_400_000_000
    assert (
        len(list(split_blocks(BlockSamples(np.arange(500) * day, np.zeros(500), {}), BLOCK))) == 1
    )


def test_a_long_tail_becomes_blocks_of_the_usual_size() -> None:
    sizes = [
        part.time_us.size
        for part in split_blocks(BlockSamples(np.arange(70_000), np.zeros(70_000), {}), BLOCK)
    ]
    assert all(BLOCK // 2 < size < 2 * BLOCK for size in sizes)


@given(st.binary(max_size=200))
def test_damaged_bytes_are_a_history_error(data) -> None:
    for read in (decode_block, read_row):
        try:
            read(data)
        except HistoryError:
            continue


@pytest.mark.parametrize("read", [decode_block, read_row])
def test_bytes_of_a_newer_program_say_so(read) -> None:
    body = encode_block(BlockSamples(np.array([1]), np.array([1.0]), {}))
    with pytest.raises(HistoryError, match="version 9"):
        read(b"\x09" + body[1:] + bytes(32))


def test_blocks_that_follow_each_other_are_read_into_one_piece_or_not_at_all() -> None:
    value = np.array([0.5, -0.0, float("inf"), 5e-324, 1 / 3, 7.0])
    whole = BlockSamples(np.arange(6) * 1_000, value, {})
    parts = [whole.slice_positions(0, 4), whole.slice_positions(4, 6)]
    bodies = [encode_block(part) for part in parts]
    last = LastTimes()
    read = decode_run(bodies, [4, 2], last)
    assert read is not None
    assert read.time_us.tolist() == whole.time_us.tolist()
    assert read.value.tobytes() == value.tobytes()
    # Texts, damage, and sizes that are not so: whoever reads them one by one tells.
    words = encode_block(parts[1]._replace(texts={0: "on"}))
    for wrong in (words, bodies[1][:-3], b"", bodies[0]):
        assert decode_run([bodies[0], wrong], [4, 2], last) is None
    assert decode_run(bodies, [4, 3], last) is None


def test_signals_with_the_same_times_share_them_and_others_do_not() -> None:
    time_us, last = np.arange(6) * 1_000, LastTimes()
    one, two, other = (
        [encode_block(BlockSamples(times, value, {}))]
        for times, value in (
            (time_us, np.arange(6.0)), (time_us, np.ones(6)), (time_us + 1, np.ones(6))
        )
    )  # fmt: skip
    read = [decode_run(bodies, [6], last) for bodies in (one, two, other, one)]
    assert read[1].time_us is read[0].time_us
    assert [part.time_us.tolist() for part in read] == [
        (time_us + late).tolist() for late in (0, 0, 1, 0)
    ]
    assert [part.value[1] for part in read] == [1.0, 1.0, 1.0, 1.0]
    assert [part.value[5] for part in read] == [5.0, 1.0, 1.0, 5.0]
