"""The list of the journal's rows is what a plain list would be, and small."""

import tracemalloc

from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.hub.history.blocks.journal_rows import JournalRows

MANY = 100_000


@settings(max_examples=examples(25, many=1000), deadline=None)
@given(st.lists(st.tuples(st.integers(1, 3), st.integers(1, 9), st.integers(0, 12)), max_size=60))
def test_it_counts_as_a_list_of_pairs_does(steps: list[tuple[int, int, int]]) -> None:
    # Each step adds a row some numbers further on, and forgets those so far behind it.
    rows, plain, last = JournalRows(), list[tuple[int, int]](), 0
    for further, samples, behind in steps:
        last += further
        rows.append_row(last, samples)
        plain.append((last, samples))
        rows.forget_rows(last - behind)
        plain = [each for each in plain if each[0] > last - behind]
        assert len(rows) == len(plain)
        assert rows.samples == sum(size for _, size in plain)
        assert rows.count_below(last) == sum(row < last for row, _ in plain)
        for count in range(1, len(plain) + 1):
            assert rows.last_of_oldest(count) == plain[count - 1][0]


def test_rows_that_are_made_one_count_as_one_and_hold_what_they_held() -> None:
    rows = JournalRows()
    for number in range(1, 11):
        rows.append_row(number, 10 * number)
    rows.forget_rows(2)
    rows.merge_rows(4, 7)
    assert len(rows) == 5
    assert rows.samples == sum(10 * number for number in range(3, 11))
    assert [rows.last_of_oldest(count) for count in range(1, 6)] == [3, 7, 8, 9, 10]
    # What of them is gone already is no part of it.
    rows.forget_rows(8)
    rows.merge_rows(8, 9)
    assert (len(rows), rows.samples) == (2, 190)


def test_a_hundred_thousand_rows_take_less_than_two_megabytes() -> None:
    tracemalloc.start()
    rows = JournalRows()
    for row in range(MANY):
        rows.append_row(10**9 + row, 300 + row % 7)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # As pairs they took 12 MB.
    assert held < 2e6


def test_rows_that_come_and_go_for_good_take_no_more_than_those_that_are_there() -> None:
    rows = JournalRows()
    for row in range(1, MANY):
        rows.append_row(row, 6)
        rows.forget_rows(row - 3_000)
    assert len(rows) == 3_000
    assert rows.samples == 18_000
    assert rows.bytes <= 2 * 12 * 3_001
