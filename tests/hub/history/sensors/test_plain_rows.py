"""Readings written as plain rows: the first of each channel at once, later ones in turn."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from talaia.hub.history.sensors.plain_rows import Recent
from talaia.hub.history.writing.chunks import Chunk

pytestmark = pytest.mark.pure


def readings(time_us, values):
    """Make a batch: of each channel of ``values`` a number or a text at that time."""
    numbers = [0.0 if isinstance(value, str) else value for value in values.values()]
    texts = {at: text for at, text in enumerate(values.values()) if isinstance(text, str)}
    ids = np.array(list(values), np.int64)
    return Chunk(1, ids, np.full(ids.size, time_us, np.int64), np.array(numbers, float), texts)


def shown(recent):
    """Choose rows; give by channel what they show."""
    return {
        row["channel_id"]: row["value"] if row["text"] is None else row["text"]
        for row in recent.newest_rows()
    }


def test_the_newest_reading_of_a_turn_is_written_and_only_once() -> None:
    recent = Recent()
    recent.add_chunks([readings(1, {7: 1.5, 3: 2.5}), readings(2, {7: 1.75})])
    assert shown(recent) == {7: 1.75, 3: 2.5}
    assert shown(recent) == {}
    recent.add_chunks([readings(3, {3: 2.5})])
    assert shown(recent) == {3: 2.5}


def test_a_text_is_written_when_it_changed_and_a_number_after_it_is_a_number() -> None:
    recent = Recent()
    recent.add_chunks([readings(1, {4: "open"})])
    assert shown(recent) == {4: "open"}
    recent.add_chunks([readings(2, {4: "open"})])
    assert shown(recent) == {}
    recent.add_chunks([readings(3, {4: "shut"}), readings(4, {4: "open"})])
    assert shown(recent) == {}
    recent.add_chunks([readings(5, {4: "shut"})])
    assert shown(recent) == {4: "shut"}
    recent.add_chunks([readings(6, {4: 1.0})])
    assert shown(recent) == {4: 1.0}
    recent.add_chunks([readings(7, {4: "shut"})])
    assert shown(recent) == {4: "shut"}


def test_of_ten_thousand_channels_all_are_written_first_and_then_a_thousand_each_turn() -> None:
    recent = Recent()
    everything = dict.fromkeys(range(1, 10_001), 1.0)
    recent.add_chunks([readings(1, everything)])
    assert len(shown(recent)) == 10_000
    seen: set[int] = set()
    for turn in range(10):
        recent.add_chunks([readings(2 + turn, everything)])
        rows = shown(recent)
        assert len(rows) == 1_000
        assert not seen & set(rows)  # the one that waited longest comes first
        seen |= set(rows)
    recent.add_chunks([readings(20, {10_001: 5.0, 5: "new"})])
    rows = shown(recent)
    assert rows[10_001] == 5.0
    assert rows[5] == "new"


@given(
    st.lists(
        st.dictionaries(st.integers(1, 6), st.one_of(st.integers(0, 3), st.sampled_from("ab"))),
        max_size=30,
    )
)
def test_in_the_end_each_channel_shows_what_it_said_last(batches) -> None:
    recent = Recent()
    last: dict[int, object] = {}
    told: dict[int, object] = {}
    for at, values in enumerate(batches, 1):
        recent.add_chunks([readings(at, values)])
        last |= values
        if at % 3 == 0:
            told |= shown(recent)
    told |= shown(recent)
    assert told == last
