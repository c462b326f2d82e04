"""A journal row gives back what was packed, channel by channel, to the last bit."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.blocks.journal import (
    merge_bodies,
    part_of,
    read_row,
    read_rows,
    write_row,
)
from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import Columns, join_columns

from ..samples import batch

pytestmark = pytest.mark.pure

value = st.one_of(
    st.floats(), st.text(st.characters(exclude_categories=["Cs"]), max_size=3), st.just(-0.0)
)
row = st.tuples(st.integers(0, 65_535), st.integers(-(2**62), 2**62), value)


def of_channels(columns):
    """Give each channel's samples, in order, with the values' bits."""
    bits = columns.value.view(np.uint64).tolist()
    found = {}
    for at, channel in enumerate(columns.channel.tolist()):
        text = columns.texts.get(at)
        said = text if text is not None else bits[at]
        found.setdefault(channel, []).append((int(columns.time_us[at]), said))
    return found


@given(st.lists(row, min_size=1, max_size=12), st.sampled_from([1, 20, 60]), st.booleans())
def test_what_is_packed_comes_back_channel_by_channel(rows, times, apart) -> None:
    # Apart, each of the repeated samples has a channel of its own, as with many short series.
    rows = [
        ((channel + at * apart) % 65_536, time_us, value)
        for at, (channel, time_us, value) in enumerate(rows * times)
    ]
    columns = batch(rows)
    assert of_channels(read_row(write_row(columns))) == of_channels(columns)


@given(
    st.sets(st.integers(0, 65_535), min_size=1, max_size=400),
    st.dictionaries(st.integers(0, 399), st.text(st.characters(exclude_categories=["Cs"]))),
)
def test_a_sample_of_each_of_many_channels_comes_back(channels, texts) -> None:
    columns = batch(
        [
            (channel, 10**15 + 7 * at, texts.get(at, channel / 3))
            for at, channel in enumerate(sorted(channels))
        ]
    )
    read = read_row(write_row(columns))
    assert of_channels(read) == of_channels(columns)
    assert read.channel.tolist() == sorted(channels)


# As a row of the journal was packed that was made of three batches of forty samples before they
# were put together as they are (version 4).
MERGED_BEFORE = bytes.fromhex(
    "04007800000000000000000000002100000070636f210300061e0401077700001051020090fd077c0020"
    "000000bd77091212003700000070636f210300061e040104770000710000000000000010010180000000"
    "0000000040000400000000000000000000008065ce7fa64912003700000070636f210300061e04010677"
    "000002000000000000fd1b01018000000000000000400004000000000000000000010000000000000080"
    "008203a26f6e77a36f6666"
)


def test_a_row_that_was_merged_before_is_still_read() -> None:
    read = read_row(MERGED_BEFORE)
    index = np.arange(120)
    assert read.channel.tolist() == (index % 40).tolist()
    assert read.time_us.tolist() == (10**15 + 7 * index).tolist()
    assert read.value.tolist() == (index / 4).tolist()
    assert read.texts == {3: "on", 119: "off"}


def many_channels(first, count=150):
    """Make a batch of as many channels, with a text and a NaN."""
    rows = [(at, first * 10 + at, at / 4) for at in range(count)]
    rows[first] = (first, first, f"line {first}")
    rows[-1] = (count - 1, 5, float("nan"))
    return batch(rows)


def test_batches_that_are_made_one_come_back_in_the_order_in_which_they_came() -> None:
    parts = [many_channels(first) for first in range(5)]
    body = merge_bodies([write_row(part) for part in parts], 750)
    assert len(body) > 750
    whole = batch([])
    for part in parts:
        whole = join_columns([whole, part])
    assert of_channels(read_row(body)) == of_channels(whole)
    read = read_rows([write_row(parts[0]), body])
    assert read.sizes.tolist() == [150, 750]


def test_damage_of_batches_that_were_made_one_is_told() -> None:
    parts = [write_row(many_channels(first)) for first in range(3)]
    body = merge_bodies(parts, 450)
    inside = merge_bodies([body], 450)
    short = merge_bodies(parts, 451)
    for junk in (
        body[:9], body[:30], body[: len(body) // 2], body[:-3], body[:2] + body[3:], body + b"x",
        inside, short, MERGED_BEFORE[:-9], MERGED_BEFORE[:40],
    ):  # fmt: skip
        with pytest.raises(HistoryError):
            read_row(junk)


rows_of_a_batch = st.lists(row, min_size=1, max_size=5)


@given(st.lists(st.tuples(rows_of_a_batch, st.sampled_from([1, 1, 1, 60]), st.booleans())))
def test_many_rows_that_are_read_at_once_are_those_that_are_read_one_by_one(batches) -> None:
    bodies = [write_row(batch(rows * times)) for rows, times, _ in batches]
    # Some of them damaged.
    bodies = [
        b"\x07" + body[1:] if is_damaged else body
        for body, (_, _, is_damaged) in zip(bodies, batches, strict=True)
    ]
    read = read_rows(bodies)

    whole = [read_row(body) for at, body in enumerate(bodies) if at not in read.damaged]
    assert {at for at, (_, _, is_damaged) in enumerate(batches) if is_damaged} == {*read.damaged}
    ends = np.cumsum(read.sizes)
    found = [
        part_of(read.columns, int(end - size), int(end))
        for at, (end, size) in enumerate(zip(ends, read.sizes, strict=True))
        if at not in read.damaged
    ]
    assert [of_channels(columns) for columns in found] == [
        of_channels(columns) for columns in whole
    ]
    assert all(read.sizes[at] == 0 for at in read.damaged)


def test_a_large_batch_takes_a_fraction_of_its_bytes() -> None:
    index = np.arange(1_000)
    value = np.round(np.sin(index / 50), 3)
    columns = Columns((index % 20).astype(np.uint16), 10**15 + index * 500, value, {})
    assert len(write_row(columns)) < 5_000


def test_a_batch_of_as_many_channels_as_samples_takes_little_more() -> None:
    index = np.arange(1_000)
    value = np.round(np.sin(index / 50), 3)
    columns = Columns(index.astype(np.uint16), 10**15 + index * 500, value, {})
    assert len(write_row(columns)) < 4_000


@pytest.mark.parametrize(("count", "channels"), [(5, 3), (500, 3), (500, 500)])
def test_damage_is_told_and_never_taken_for_samples(count, channels) -> None:
    body = write_row(batch([(at % channels, at, float(at)) for at in range(count)]))
    for junk in (b"", body[:9], body[: len(body) // 2], b"\x07" + body[1:], body[:-3]):
        with pytest.raises(HistoryError):
            read_row(junk)
