"""Samples that wait in memory: a reader sees each of them once, whatever was done with them."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.writing.chunks import Chunk
from talaia.hub.history.writing.open_blocks import Tails

pytestmark = pytest.mark.pure

CHANNELS = 5
sample = st.tuples(st.integers(0, CHANNELS - 1), st.integers(-5, 5), st.sampled_from(["", "on"]))
batches = st.lists(st.lists(sample, max_size=6), max_size=200)


def chunk_of(row, samples):
    """Make a journal row's samples of channel, value and text."""
    return Chunk(
        row,
        np.array([channel for channel, _, _ in samples], np.int64),
        np.arange(len(samples), dtype=np.int64) + 1_000 * row,
        np.array([value for _, value, _ in samples], np.float64),
        {at: text for at, (_, _, text) in enumerate(samples) if text},
    )


def flat(samples):
    """List time, value and text of samples."""
    return [
        (int(time_us), float(value), samples.texts.get(at, ""))
        for at, (time_us, value) in enumerate(zip(samples.time_us, samples.value, strict=True))
    ]


def tails_of(rows, *, recent=8, deal=True):
    """Give tails that took these rows one by one, and dealt them out when it was due."""
    tails = Tails(1, 0, recent)
    for row, samples in enumerate(rows, 1):
        tails.add_chunks([chunk_of(row, samples)])
        if deal and tails.is_due():
            tails.deal_chunks()
    return tails


def test_of_rows_that_are_joined_the_last_one_counts_as_dealt_and_the_first_is_kept() -> None:
    tails = Tails(1, 0, 8)
    tails.add_chunks([chunk_of(5, [(0, 1, ""), (1, 2, "")])], 9)
    tails.deal_chunks()
    # A block that is made now has all of them: what stands after it in the journal is new.
    assert tails.dealt_row == 9
    assert tails.needed_row() == 5
    tails.forget_sealed([0, 1], 2)
    assert tails.needed_row() == 10


@given(batches, st.booleans())
def test_a_snapshot_has_each_sample_of_a_channel_once_and_in_order(rows, deal) -> None:
    tails = tails_of(rows, deal=deal)
    for channel in range(CHANNELS):
        sent = [
            (1_000 * row + at, float(value), text)
            for row, samples in enumerate(rows, 1)
            for at, (which, value, text) in enumerate(samples)
            if which == channel
        ]
        assert flat(tails.channel_snapshot(channel).samples) == sent


@given(batches, st.booleans())
def test_snapshots_of_many_channels_are_those_of_each(rows, deal) -> None:
    tails = tails_of(rows, deal=deal)
    # One that nobody has heard of, too.
    asked = range(CHANNELS + 1)
    together = tails.channel_snapshots(asked)
    assert [flat(together[channel].samples) for channel in asked] == [
        flat(tails.channel_snapshot(channel).samples) for channel in asked
    ]
    assert {snapshot.block for snapshot in together.values()} == {1}


@given(batches, st.integers(0, 40_000), st.integers(0, 40_000))
def test_a_snapshot_of_a_window_lacks_nothing_of_it_also_after_more_has_come(
    rows, from_us, to_us
) -> None:
    tails = Tails(1, 0, 4)
    for row, samples in enumerate(rows, 1):
        tails.add_chunks([chunk_of(row, samples)])
        tails.deal_chunks()
        for channel in range(CHANNELS):
            every = flat(tails.channel_snapshot(channel).samples)
            some = flat(tails.channel_snapshot(channel, from_us, to_us).samples)
            wanted = [one for one in every if from_us <= one[0] <= to_us]
            assert [one for one in some if from_us <= one[0] <= to_us] == wanted


@given(batches)
def test_no_journal_row_is_given_up_that_holds_a_sample_found_nowhere_else(rows) -> None:
    tails = tails_of(rows, deal=False)
    assert tails.needed_row() == 1  # nothing was dealt out
    tails.deal_chunks()
    first = next((row for row, samples in enumerate(rows, 1) if samples), len(rows) + 1)
    assert tails.needed_row() <= first
    assert tails.dealt_row == len(rows)
    tails.mark_saved(list(tails.all_tails()))
    assert tails.needed_row() == len(rows) + 1


def test_with_many_channels_batches_wait_for_more_than_one_sample_of_each() -> None:
    tails = tails_of([[(channel, 0, "")] for channel in range(CHANNELS)], recent=1, deal=False)
    assert tails.is_due()  # no channel is known yet
    tails.deal_chunks()
    tails.add_chunks([chunk_of(9, [(0, 1, "")] * 79)])
    assert not tails.is_due()
    tails.add_chunks([chunk_of(10, [(0, 1, "")])])
    assert tails.is_due()


def test_many_channels_that_are_all_new_wait_for_more_than_one_sample_of_each() -> None:
    everybody = [(channel, 0, "") for channel in range(1_000)]
    tails = tails_of([everybody] * 31, recent=1, deal=False)
    assert not tails.is_due()
    tails.add_chunks([chunk_of(32, everybody)])
    assert tails.is_due()
    tails.deal_chunks()
    # Those that come after them are counted anew.
    tails.add_chunks([chunk_of(33, [(channel + 5_000, 0, "") for channel in range(3)])])
    assert not tails.is_due()
    tails.forget_sealed(range(1_000), 2)
    assert tails.is_due()


timed = st.tuples(
    st.integers(0, CHANNELS - 1),
    st.integers(-9, 9),
    st.integers(-5, 5),
    st.sampled_from(["", "on"]),
)


@given(
    st.lists(st.lists(timed, max_size=6), max_size=200),
    st.integers(-10, 10),
    st.sampled_from([8, 100, 10_000]),
    st.integers(1, CHANNELS + 1),
)
def test_the_newest_of_many_channels_is_what_each_ones_samples_say(
    rows, to_us, recent, asked
) -> None:
    tails = Tails(7, 0, recent)
    for row, samples in enumerate(rows, 1):
        chunk = chunk_of(row, [(channel, value, text) for channel, _, value, text in samples])
        # Clocks go back: times do not rise.
        time_us = np.array([time_us for _, time_us, _, _ in samples], np.int64)
        tails.add_chunks([chunk._replace(time_us=time_us)])
        if tails.is_due():
            tails.deal_chunks()
        if row % 50 == 0:
            tails.newest_readings(range(CHANNELS), to_us)
    wanted = {}
    for channel in range(asked):
        early = [one for one in flat(tails.channel_snapshot(channel).samples) if one[0] <= to_us]
        if early:
            # Of equal times the one that came last.
            wanted[channel] = max(enumerate(early), key=lambda one: (one[1][0], one[0]))[1]
    found = tails.newest_readings(range(asked), to_us)
    assert (found.readings, found.block) == (wanted, 7)


def test_few_channels_are_found_in_large_batches_that_wait_as_in_small_ones() -> None:
    chance = np.random.default_rng(3)
    chunks = [
        chunk_of(
            row, [(int(one), row, "on" * (row % 9 == 0)) for one in chance.integers(0, 900, 40)]
        )
        for row in range(1, 200)
    ]
    tails = Tails(1, 0, 100_000)
    tails.add_chunks(chunks)
    assert not tails.is_due()
    # A channel with a high number, such that digits do not sort it.
    tails.add_chunks([chunk_of(200, [(70_000, 1, "")] * 100)])
    for asked in ([5], [3, 899, 70_000, 80_000], list(range(900))):
        together = tails.channel_snapshots(asked)
        for channel in asked:
            sent = [one for chunk in chunks for one in flat_of(chunk, channel)]
            sent += [(1_000 * 200 + at, 1.0, "") for at in range(100)] * (channel == 70_000)
            assert flat(together[channel].samples) == sent


def flat_of(chunk, channel):
    """List time, value and text of one channel's samples in a chunk."""
    return [
        (int(chunk.time_us[at]), float(chunk.value[at]), chunk.texts.get(at, ""))
        for at in np.flatnonzero(chunk.channel == channel).tolist()
    ]
