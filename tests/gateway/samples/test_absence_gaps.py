"""What no gateway heard is told: it was not running, had not met the robot, lost a tail."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import SECOND
from talaia.gateway.samples.absence_gaps import FirstHeard, absence_span
from talaia.gateway.spool.journal import SegmentHead, Spool, SpoolPosition
from talaia.gateway.spool.opening import TORN
from talaia.gateway.spool.progress_mark import ProgressMark
from talaia.gateway.spool.segment import SampleRecord
from talaia.gateway.spool.sizes import SpoolSizes
from talaia.gateway.spool.spool_thread import SpoolThread

HEAD = SegmentHead("boot-a", "cat", ["a/x"])
LARGE = 1 << 30


def record(first: int, size: int = 20) -> SampleRecord:
    return SampleRecord(first, 10, first * 1000, first * 1000 + 9000, b"x" * size)


def held(spool: Spool) -> set[int]:
    place, found = SpoolPosition(), set()
    while True:
        some, place = spool.read_records(place, 300)
        if not some:
            return found
        found |= {n for each in some for n in range(each.record.first, each.record.end)}


@settings(deadline=None, max_examples=examples(15, many=600))
@given(st.integers(1, 20), st.integers(0, 3000), st.integers(0, 20))
def test_torn_tail_is_a_gap_that_spans_what_was_in_it(batches: int, cut: int, acked: int) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder)
        spool = Spool(folder=path, head=HEAD, bound=LARGE)
        for number in range(batches):
            spool.append_record(record(number * 10))
        spool.acknowledge_samples("boot-a", min(acked, batches) * 10)
        spool.sync_to_disk(1)
        # Killed: nobody closes it. And the disk has lost the end of the file.
        (file,) = path.glob("*.seg")
        os.truncate(file, min(cut, file.stat().st_size))
        later = Spool(folder=path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
        gaps = [each for each in later.list_gaps() if each.boot == "boot-a"]
        told = {n for each in gaps for n in range(each.first, each.last + 1)}
        there = held(later)
        missing = set(range(min(acked, batches) * 10, batches * 10)) - there
        assert told == missing
        for each in gaps:
            assert each.reason == TORN
            assert each.from_us <= each.first * 1000
            assert each.to_us == (batches - 1) * 10_000 + 9000
        later.close()


def test_what_the_hub_has_is_no_gap_when_the_file_was_emptied_and_the_gateway_killed(
    tmp_path: Path,
) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(trim=100))
    for number in range(10):
        spool.append_record(record(number * 10))
    spool.acknowledge_samples("boot-a", 100)
    spool.append_record(record(100))
    later = Spool(
        folder=tmp_path,
        head=SegmentHead("boot-b", "cat", []),
        bound=LARGE,
        sizes=SpoolSizes(trim=100),
    )
    assert later.list_gaps() == []
    assert held(later) == set(range(100, 110))


def test_what_was_only_in_memory_when_the_gateway_was_killed_is_a_gap(
    tmp_path, monkeypatch
) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    spool.append_record(record(0))
    monkeypatch.setattr(Spool, "_write_records", lambda *_: False)
    spool.append_record(record(10))
    monkeypatch.undo()
    later = Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
    assert [(each.first, each.last) for each in later.list_gaps()] == [(10, 19)]


def test_loss_of_a_run_that_was_killed_is_kept_before_the_next_one_leaves_word(tmp_path) -> None:
    first = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    first.append_record(record(0))
    (file,) = tmp_path.glob("*.seg")
    os.truncate(file, file.stat().st_size - 1)
    second = Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
    second.append_record(record(0))
    # Killed before its first second is over.
    third = Spool(folder=tmp_path, head=SegmentHead("boot-c", "cat", []), bound=LARGE)
    assert [(each.boot, each.first, each.last) for each in third.list_gaps()] == [("boot-a", 0, 9)]


def test_time_without_a_gateway_is_told_from_the_last_that_was_heard() -> None:
    former = ProgressMark("a", 5, 0, 0, 10_000_000, 100.0, 0, "m")
    assert absence_span(former, 18_000_000, 108.0, "m") == (10_000_000, 18_000_000)
    # Another run of the machine: its monotonic clock says nothing.
    assert absence_span(former, 18_000_000, 3.0, "n") == (10_000_000, 18_000_000)


def test_clock_that_was_set_meanwhile_makes_the_absence_neither_longer_nor_shorter() -> None:
    former = ProgressMark("a", 5, 0, 0, 10_000_000_000, 100.0, 0, "m")
    hour = 3_600_000_000
    for now_us in (10_008_000_000 + hour, 10_008_000_000 - hour):
        assert absence_span(former, now_us, 108.0, "m") == (now_us - 8_000_000, now_us)
    # Where nobody knows how long it was, it does not end before it began.
    assert absence_span(former, 5, 1.0, "n") == (5, 5)


@given(
    st.lists(st.integers(1, 3_000), min_size=1, max_size=5),
    st.lists(st.integers(0, 5_000), min_size=5, max_size=5),
)
def test_gap_of_the_beginning_ends_with_the_first_of_the_last_channel_that_missed_a_turn(
    periods: list[int], deaf: list[int]
) -> None:
    """Channel n speaks every ``periods[n]`` ms, and nobody hears it for ``deaf[n]`` ms."""
    heard, unheard_ms = FirstHeard(0), 0
    spoken = sorted(
        (at, channel)
        for channel, period in enumerate(periods)
        for at in range(period, 12_000, period)
        if at >= deaf[channel]
    )
    for at, channel in spoken:
        heard.add_batch(np.array([channel], np.uint16), at * SECOND // 1000)
    for channel, period in enumerate(periods):
        first = next(at for at, each in spoken if each == channel)
        if first > period:
            unheard_ms = max(unheard_ms, first)
    assert round(heard.settle_watching() * 1000) == unheard_ms
    assert heard.settle_watching() == 0.0


def test_gap_that_the_hub_has_been_told_of_is_no_damage_to_the_next_run(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    spool.append_record(record(0))
    spool.record_loss(SampleRecord(10, 1, 5, 6, b""), "stood still")
    spool.append_record(record(11))
    spool.acknowledge_samples("boot-a", 15)
    spool.sync_to_disk(1)
    assert (
        Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE).list_gaps() == []
    )


async def test_spool_that_is_new_has_no_run_before_it_and_later_it_has(tmp_path: Path) -> None:
    keeper = SpoolThread(
        Spool(folder=tmp_path, head=HEAD, bound=LARGE, wall_us=lambda: 7, machine="m")
    )
    assert keeper.former is None
    keeper.append_record(record(0))
    await keeper.sync_to_disk(20_000)
    await keeper.close()
    later = SpoolThread(
        Spool(
            folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE, wall_us=lambda: 9
        )
    )
    assert later.former == ProgressMark("boot-a", 10, 0, 7, 20_000, 0.0, 0, "m")
    later.append_record(record(0))
    await later.sync_to_disk(30_000)
    await later.close()
    last = Spool(folder=tmp_path, head=SegmentHead("boot-c", "cat", []), bound=LARGE)
    assert last.former is not None
    assert last.former.deaf_us == 9
    last.all_heard()
    last.append_record(record(0))
    assert Spool(
        folder=tmp_path, head=SegmentHead("boot-d", "cat", []), bound=LARGE
    ).former == ProgressMark("boot-c", 10, 0, 0, 9000, 0.0, 0, "")
    await asyncio.sleep(0)


def test_first_run_watches_nobody_for_nobody_missed_anything_before_it() -> None:
    heard = FirstHeard(0)
    heard.end_watching()
    for at in (SECOND, 2 * SECOND):
        heard.add_batch(np.array([3], np.uint16), at)
    assert heard.settle_watching() == 0.0
