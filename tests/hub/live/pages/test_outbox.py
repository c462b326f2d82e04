"""Outbox: what a slow browser still gets, and how much may wait for it."""

from math import isnan, nan

import numpy as np
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.hub.live.pages.conflate import conflate, newest, weight
from talaia.hub.live.pages.outbox import Outbox, values_of
from talaia.wire.browser import TO_BROWSER, Values
from talaia.wire.columns import Columns, join_columns, unpack_columns

CHANNELS = 5


def columns(*rows: tuple[int, float], texts: dict[int, str] | None = None) -> Columns:
    return Columns(
        np.array([channel for channel, _ in rows], np.uint16),
        np.arange(len(rows), dtype=np.int64),
        np.array([value for _, value in rows], np.float64),
        texts or {},
    )


def drained(outbox: Outbox) -> dict[int, list[tuple[int, float]]]:
    """Take everything; give the samples of each subscription."""
    got: dict[int, list[tuple[int, float]]] = {}
    while outbox:
        for frame in outbox.next_frames():
            message = TO_BROWSER.decode(frame)
            assert isinstance(message, Values)
            piece = unpack_columns(message)
            got.setdefault(message.sub, []).extend(
                zip(piece.channel.tolist(), piece.value.tolist(), strict=True)
            )
    return got


rows = st.lists(
    st.tuples(st.integers(0, CHANNELS - 1), st.floats(-9, 9) | st.just(nan)),
    min_size=1,
    max_size=60,
)
puts = st.lists(st.tuples(st.integers(0, 3), rows), min_size=1, max_size=40)


def same(first: float, second: float) -> bool:
    return first == second or (isnan(first) and isnan(second))


@given(rows)
def test_conflation_keeps_first_least_greatest_and_last_of_each_channel(batch) -> None:
    kept = conflate(columns(*batch))
    for channel in {each for each, _ in batch}:
        before = [value for each, value in batch if each == channel]
        after = kept.value[kept.channel == channel].tolist()
        assert same(after[0], before[0])
        assert same(after[-1], before[-1])
        numbers = [value for value in before if not isnan(value)]
        if numbers:
            assert min(numbers) in after
            assert max(numbers) in after
        assert len(after) <= max(4, min(len(before), 4))
    assert (np.diff(kept.time_us) > 0).all()


@given(rows)
def test_newest_keeps_exactly_the_last_of_each_channel(batch) -> None:
    kept = newest(columns(*batch))
    last = dict(batch)
    assert sorted(kept.channel.tolist()) == sorted(last)
    for channel, value in zip(kept.channel.tolist(), kept.value.tolist(), strict=True):
        assert same(value, last[channel])


def test_texts_stay_with_their_samples() -> None:
    batch = columns(*[(0, nan)] * 3, *[(1, 1.0)] * 9, (0, nan), texts={0: "a", 2: "c", 12: "z"})
    kept = conflate(join_columns([batch, columns((2, nan), texts={0: "new"})]))
    said = {int(kept.channel[at]): text for at, text in kept.texts.items()}
    assert said == {0: "z", 2: "new"}
    assert set(kept.texts.values()) >= {"a", "z", "new"}


@settings(max_examples=examples(15, many=600))
@given(puts)
def test_newest_of_every_channel_is_delivered_however_small_the_budget(batches) -> None:
    outbox = Outbox(TO_BROWSER.encode, budget=40_000)
    last: dict[tuple[int, int], float] = {}
    for sub, batch in batches:
        outbox.values(sub, columns(*batch))
        last.update({(sub, channel): value for channel, value in batch})
    delivered = {
        (sub, channel): value for sub, got in drained(outbox).items() for channel, value in got
    }
    assert delivered.keys() == last.keys()
    assert all(same(delivered[key], value) for key, value in last.items())


@settings(max_examples=examples(15, many=600))
@given(puts)
def test_extremes_are_delivered_to_a_browser_that_is_behind(batches) -> None:
    outbox = Outbox(TO_BROWSER.encode)
    for sub, batch in batches:
        outbox.values(sub, columns(*batch))
    got = drained(outbox)
    for sub in got:
        every = [value for each, batch in batches if each == sub for _, value in batch]
        numbers = [value for value in every if not isnan(value)]
        values = [value for _, value in got[sub]]
        if numbers:
            assert min(numbers) in values
            assert max(numbers) in values


@settings(max_examples=examples(15, many=600))
@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("values"), st.integers(0, 3), rows),
            st.tuples(st.just("note"), st.integers(1, 3000)),
            st.tuples(st.just("state"), st.integers(0, 9), st.integers(1, 3000)),
        ),
        max_size=80,
    )
)
def test_what_waits_never_weighs_more_than_the_budget(steps) -> None:
    budget = 40_000
    outbox = Outbox(TO_BROWSER.encode, budget)
    for step in steps:
        if step[0] == "values":
            outbox.values(step[1], columns(*step[2]))
        elif step[0] == "note":
            outbox.enqueue_frame(b"n" * step[1])
        else:
            outbox.state(step[1], b"s" * step[2])
        assert outbox.weight <= budget
    while outbox:
        outbox.next_frames()
    assert outbox.weight == 0


def test_week_of_data_for_a_browser_that_never_reads_stays_within_eight_mebibytes() -> None:
    outbox = Outbox(TO_BROWSER.encode)
    channels = np.arange(60_000, dtype=np.uint16)
    for at in range(60):
        outbox.values(
            1,
            Columns(channels, np.full(60_000, at, np.int64), np.full(60_000, float(at)), {}),
        )
        assert outbox.weight <= 8 * 1024 * 1024
    got = drained(outbox)[1]
    assert {value for _, value in got} >= {59.0}
    assert len({channel for channel, _ in got}) == 60_000


def test_browser_that_keeps_up_gets_the_bytes_that_all_get() -> None:
    outbox = Outbox(TO_BROWSER.encode)
    outbox.values(1, columns((0, 1.0)), b"shared")
    assert outbox.next_frames() == [b"shared"]
    outbox.values(1, columns((0, 1.0)), b"shared")
    outbox.values(1, columns((0, 2.0)), b"also shared")
    assert drained(outbox)[1] == [(0, 1.0), (0, 2.0)]


def test_newest_state_takes_the_place_of_the_older_one_and_goes_before_values() -> None:
    outbox = Outbox(TO_BROWSER.encode)
    outbox.values(1, columns((0, 1.0)), b"values")
    outbox.state("lease", b"old")
    outbox.enqueue_frame(b"note")
    outbox.state("lease", b"new")
    assert outbox.next_frames() == [b"note", b"new"]
    assert outbox.next_frames() == [b"values"]
    assert outbox.next_frames() == []


def test_samples_further_apart_than_a_batch_holds_are_cut_in_two() -> None:
    outbox = Outbox(TO_BROWSER.encode)
    hour_us = 3_600_000_000
    outbox.values(
        1,
        Columns(np.zeros(2, np.uint16), np.array([0, hour_us]), np.array([1.0, 2.0]), {}),
    )
    assert drained(outbox)[1] == [(0, 1.0), (0, 2.0)]


def test_weight_counts_texts() -> None:
    assert weight(columns((0, nan), texts={0: "x" * 1000})) > 1000


def test_spike_survives_when_thinning_by_extremes_is_enough() -> None:
    outbox = Outbox(TO_BROWSER.encode, budget=40_000)
    for at in range(200):
        outbox.values(1, columns(*[(0, 1.0)] * 20, (0, 99.0 if at == 50 else 1.0), (0, 2.0)))
    values = [value for _, value in drained(outbox)[1]]
    assert max(values) == 99.0
    assert values[-1] == 2.0


@settings(max_examples=examples(12, many=400))
@given(puts)
def test_outbox_that_must_drop_owes_the_newest_value_of_each_channel(batches) -> None:
    """So small a budget that even one sample of each channel is too much."""
    latest: dict[tuple[int, int], float] = {}

    def known(sub: int, places: list[int]) -> list[Values]:
        here = [(place, latest[sub, place]) for place in places]
        return values_of(sub, columns(*here))

    outbox = Outbox(TO_BROWSER.encode, 40, known)
    for sub, batch in batches:
        outbox.values(sub, columns(*batch))
        latest.update({(sub, channel): value for channel, value in batch})
    delivered = {
        (sub, channel): value for sub, got in drained(outbox).items() for channel, value in got
    }
    assert delivered.keys() == latest.keys()
    assert all(same(delivered[key], value) for key, value in latest.items())


def test_newest_value_is_told_behind_what_waits_and_at_the_beginning_before_it() -> None:
    outbox = Outbox(TO_BROWSER.encode, known=lambda sub, _: values_of(sub, columns((0, 11.0))))
    outbox.values(1, columns((0, 3.0)))
    outbox.owe(1, [0])
    assert drained(outbox) == {1: [(0, 3.0), (0, 11.0)]}
    outbox.values(1, columns((0, 12.0)))
    outbox.owe(1, [0], first=True)
    assert drained(outbox) == {1: [(0, 11.0), (0, 12.0)]}
    outbox.owe(1, [0])
    outbox.forget(1)
    assert not outbox
