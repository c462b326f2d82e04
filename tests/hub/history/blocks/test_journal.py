"""A journal row gives back what was packed, channel by channel, to the last bit."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.blocks.journal import (
    merge_columns,
    part_of,
    read_row,
    read_rows,
    write_row,
)
from talaia.hub.history.errors import HistoryError
from talaia.wire.columns import Columns

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


@given(st.lists(st.lists(row, min_size=1, max_size=6), min_size=1, max_size=5))
def test_batches_that_are_made_one_come_back_in_the_order_in_which_they_came(parts) -> None:
    read = read_row(merge_columns([batch(rows) for rows in parts]))
    whole = batch([sample for rows in parts for sample in rows])
    assert read.channel.tolist() == whole.channel.tolist()
    assert read.time_us.tolist() == whole.time_us.tolist()
    assert read.value.tobytes() == whole.value.tobytes()
    assert read.texts == whole.texts


def test_damage_of_batches_that_were_made_one_is_told() -> None:
    body = merge_columns([batch([(at % 90, at, float(at)) for at in range(500)])] * 3)
    for junk in (body[:9], body[:30], body[: len(body) // 2], body[:-3], body[:2] + body[3:]):
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
