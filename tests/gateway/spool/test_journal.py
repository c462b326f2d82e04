"""Spool: order, acks, crashes, damage, and nothing lost without a gap."""

from __future__ import annotations

import errno
import itertools
import os
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.gateway import persistence
from talaia.gateway.driving import persistent_state
from talaia.gateway.driving.stop_latch import LatchedStop
from talaia.gateway.samples.batching import records_of
from talaia.gateway.spool import journal
from talaia.gateway.spool.gaps import DroppedSamples
from talaia.gateway.spool.journal import SegmentHead, Spool, SpoolPosition
from talaia.gateway.spool.packing import FRAME_SAMPLES, pack_records, unpack_record
from talaia.gateway.spool.segment import SampleRecord, pack_record, read_records
from talaia.gateway.spool.sizes import SpoolSizes
from talaia.wire.columns import Columns, unpack_columns
from talaia.wire.errors import PeerError
from talaia.wire.frames import LINK_FROM_GATEWAY, SampleBatch

HEAD = SegmentHead("boot-a", "cat", ["base/v"])
LARGE = 1 << 30


def record(first: int, samples: int = 10, size: int = 100) -> SampleRecord:
    return SampleRecord(first, samples, first, first + samples, bytes([first % 251]) * size)


def kept(spool: Spool) -> list[tuple[str, int]]:
    found, place = [], SpoolPosition()
    while True:
        more, place = spool.read_records(place, 500)
        if not more:
            return found
        found += [(stored.head.boot, stored.record.first) for stored in more]


def fill(spool: Spool, count: int, size: int = 100, first: int = 0) -> None:
    for number in range(count):
        spool.append_record(record((first + number) * 10, size=size))


def test_records_come_back_in_order(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    fill(spool, 50)
    assert kept(spool) == [("boot-a", number * 10) for number in range(50)]
    spool.close()


def test_acknowledged_records_are_not_given_again(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    fill(spool, 10)
    spool.acknowledge_samples("boot-a", 70)
    assert kept(spool) == [("boot-a", 70), ("boot-a", 80), ("boot-a", 90)]
    spool.acknowledge_samples("boot-a", 40)
    assert len(kept(spool)) == 3
    spool.close()


def test_hub_that_keeps_up_leaves_one_small_file(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(trim=2000))
    for number in range(500):
        spool.append_record(record(number * 10))
        spool.acknowledge_samples("boot-a", number * 10 + 10)
    assert spool.kept < 4000
    assert len(list(tmp_path.glob("*.seg"))) == 1
    spool.append_record(record(9000))
    assert kept(spool) == [("boot-a", 9000)]
    spool.close()


@given(st.lists(st.booleans(), min_size=5, max_size=60), st.integers(0, 30))
def test_what_the_hub_has_lost_is_given_again_or_is_a_gap(steps: list[bool], below: int) -> None:
    with TemporaryDirectory() as folder:
        spool = Spool(folder=Path(folder), head=HEAD, bound=8000, sizes=SpoolSizes(trim=700))
        for number, acked in enumerate(steps):
            spool.append_record(record(number * 10))
            if acked:
                spool.acknowledge_samples("boot-a", number * 10 + 10)
        spool.sync_to_disk()
        stored = 10 * max((at + 1 for at, acked in enumerate(steps) if acked), default=0)
        below = min(below * 10, stored)
        # A link to a hub that has everything takes nothing back.
        spool.rewind_acknowledged(stored)
        spool.rewind_acknowledged(below)
        spool.acknowledge_samples("boot-a", below)
        given_again = {first for _, first in kept(spool)}
        lost = {at for gap in spool.list_gaps() for at in range(gap.first, gap.last + 1)}
        assert given_again | lost >= set(range(below, len(steps) * 10, 10))
        assert min(given_again | lost, default=below) >= below
        spool.close()


@pytest.mark.parametrize(("count", "below"), [(200, 0), (200, 300), (100, 0)])
def test_gap_of_what_the_hub_never_had_keeps_its_reason_and_is_told_once(
    tmp_path: Path, count: int, below: int
) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=10_000, sizes=SpoolSizes(segment=2000))
    fill(spool, count)
    (full,) = spool.list_gaps()
    spool.acknowledge_samples("boot-a", 400)
    spool.sync_to_disk()
    # More is dropped for want of room, and was never acknowledged.
    fill(spool, 50, first=count)
    before = spool.list_gaps()
    assert full.reason == journal.FULL
    spool.rewind_acknowledged(below)
    told = [at for gap in spool.list_gaps() for at in range(gap.first, gap.last + 1)]
    assert len(told) == len(set(told))
    assert {(gap.first, gap.last, gap.reason) for gap in before} <= {
        (gap.first, gap.last, gap.reason) for gap in spool.list_gaps()
    }
    spool.close()


def test_what_is_remembered_of_stored_samples_is_bounded_and_covers_them_all() -> None:
    gone = DroppedSamples()
    for number in range(20_000):
        gone.add_range(number * 10, number * 10 + 10, number, number + 1)
    spans = gone.dropped_since(0)
    assert len(spans) <= DroppedSamples.MOST
    assert (spans[0][0], spans[-1][1]) == (0, 200_000)
    assert all(a[1] == b[0] for a, b in itertools.pairwise(spans))
    assert gone.dropped_since(199_995) == [(199_995, 200_000, *spans[-1][2:])]


def test_reader_survives_the_file_being_emptied_under_it(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(trim=500))
    fill(spool, 20)
    _, place = spool.read_records(SpoolPosition(), 1000)
    spool.acknowledge_samples("boot-a", 200)
    fill(spool, 3, first=20)
    found, _ = spool.read_records(place, 10_000)
    assert [stored.record.first for stored in found] == [200, 210, 220]
    spool.close()


def test_later_run_gives_the_records_of_the_earlier_one_first(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    fill(spool, 3)
    spool.close()
    later = Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat2", []), bound=LARGE)
    fill(later, 2)
    assert kept(later) == [("boot-a", 0), ("boot-a", 10), ("boot-a", 20), ("boot-b", 0),
                           ("boot-b", 10)]  # fmt: skip
    later.acknowledge_samples("boot-a", 30)
    assert kept(later) == [("boot-b", 0), ("boot-b", 10)]
    assert len(list(tmp_path.glob("*.seg"))) == 1
    later.close()


def test_full_spool_lets_the_oldest_go_and_says_which(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=10_000, sizes=SpoolSizes(segment=2000))
    fill(spool, 200)
    assert spool.kept <= 10_000
    there = kept(spool)
    (gap,) = spool.list_gaps()
    assert gap.first == 0
    assert there == [("boot-a", first) for first in range(gap.last + 1, 2000, 10)]
    spool.close()
    later = Spool(
        folder=tmp_path,
        head=SegmentHead("boot-b", "cat", []),
        bound=10_000,
        sizes=SpoolSizes(segment=2000),
    )
    assert later.list_gaps() == [gap]
    later.acknowledge_samples("boot-a", gap.last + 1)
    later.sync_to_disk()
    assert later.list_gaps() == []
    later.close()


@settings(deadline=None, max_examples=examples(15, many=600))
@given(st.integers(0, 3000), st.data())
def test_cut_at_any_byte_keeps_all_whole_records_before_it(cut: int, data: st.DataObject) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder)
        spool = Spool(folder=path, head=HEAD, bound=LARGE)
        sizes = data.draw(st.lists(st.integers(0, 400), min_size=1, max_size=10))
        for number, size in enumerate(sizes):
            spool.append_record(record(number * 10, size=size))
        (file,) = path.glob("*.seg")
        spool.close()
        os.truncate(file, min(cut, file.stat().st_size))
        whole = [r.first for _, r in read_records(file.read_bytes()) if r.kind == 1]
        later = Spool(folder=path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
        later.append_record(record(0))
        assert kept(later) == [*(("boot-a", first) for first in whole), ("boot-b", 0)]
        assert whole == [number * 10 for number in range(len(whole))]
        later.close()


@settings(deadline=None, max_examples=examples(15, many=600))
@given(st.integers(0, 2000), st.integers(1, 255))
def test_damaged_byte_costs_only_what_it_touches_and_is_told(at: int, change: int) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder)
        spool = Spool(folder=path, head=HEAD, bound=LARGE)
        fill(spool, 10)
        (file,) = path.glob("*.seg")
        spool.close()
        data = bytearray(file.read_bytes())
        head_end = next(end for end, _ in read_records(bytes(data)))
        at = head_end + at % (len(data) - head_end)
        data[at] ^= change
        file.write_bytes(data)
        later = Spool(folder=path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
        there = [first for boot, first in kept(later) if boot == "boot-a"]
        missing = sorted(set(range(0, 100, 10)) - set(there))
        assert len(missing) == 1
        # The last one cannot be told from a torn tail.
        if missing[0] not in (0, 90):
            (gap,) = later.list_gaps()
            assert (gap.first, gap.last) == (missing[0], missing[0] + 9)
        later.close()


def test_full_disk_keeps_in_memory_and_goes_on_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    fill(spool, 3)
    room = [False]
    write = os.write

    def full(file: int, data: bytes) -> int:
        if not room[0]:
            # Half a record gets through, as on a real disk.
            write(file, bytes(data[: len(data) // 2]))
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(file, data)

    monkeypatch.setattr(os, "write", full)
    fill(spool, 2, first=3)
    room[0] = True
    fill(spool, 2, first=5)
    assert sorted(kept(spool)) == [("boot-a", number * 10) for number in range(7)]
    spool.acknowledge_samples("boot-a", 70)
    assert kept(spool) == []
    spool.close()


def test_memory_for_a_full_disk_is_bounded_and_ends_in_a_gap(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(memory=1000))

    def full(file: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        fill(spool, 30)
    (gap,) = spool.list_gaps()
    assert kept(spool) == [("boot-a", first) for first in range(gap.last + 1, 300, 10)]
    spool.close()


actions = st.lists(
    st.one_of(
        st.tuples(st.just("append"), st.integers(1, 40)),
        st.tuples(st.just("ack"), st.integers(0, 400)),
        st.tuples(st.just("restart"), st.just(0)),
        st.tuples(st.just("sync"), st.just(0)),
    ),
    max_size=40,
)


@settings(deadline=None, max_examples=examples(15, many=600))
@given(actions)
def test_whatever_happens_each_sample_is_kept_acknowledged_or_in_a_gap(
    history: list[tuple[str, int]],
) -> None:
    with TemporaryDirectory() as folder:
        boot, next_first = 0, 0
        spool = Spool(folder=Path(folder), head=SegmentHead("b0", "c", []), bound=6000)
        written: set[tuple[str, int]] = set()
        acked: dict[str, int] = {}
        for what, number in history:
            if what == "append":
                spool.append_record(record(next_first, number, size=number * 20))
                written |= {(f"b{boot}", next_first + each) for each in range(number)}
                next_first += number
            elif what == "ack":
                below = min(number, next_first)
                acked[f"b{boot}"] = max(below, acked.get(f"b{boot}", 0))
                spool.acknowledge_samples(f"b{boot}", below)
            elif what == "sync":
                spool.sync_to_disk()
            else:
                spool.close()
                boot, next_first = boot + 1, 0
                spool = Spool(
                    folder=Path(folder), head=SegmentHead(f"b{boot}", "c", []), bound=6000
                )
        there: list[tuple[str, int]] = []
        place = SpoolPosition()
        while True:
            found, place = spool.read_records(place, 300)
            if not found:
                break
            for stored in found:
                first, end = stored.record.first, stored.record.end
                there += [(stored.head.boot, each) for each in range(first, end)]
        gone = {
            (gap.boot, each) for gap in spool.list_gaps() for each in range(gap.first, gap.last + 1)
        }
        assert len(there) == len(set(there))
        assert there == sorted(there, key=lambda each: (int(each[0][1:]), each[1]))
        unaccounted = {
            each for each in written - set(there) - gone if each[1] >= acked.get(each[0], 0)
        }
        assert not unaccounted
        spool.close()


def test_body_that_holds_the_magic_is_read_whole() -> None:
    body = pack_record(record(5))
    outer = pack_record(SampleRecord(0, 1, 0, 0, body))
    assert [each.first for _, each in read_records(outer)] == [0]


def batch(first: int, samples: int = 50, boot: str = "boot-a", text: str = "") -> SampleRecord:
    rng = np.random.default_rng(first)
    columns = Columns(
        rng.integers(0, 20, samples).astype(np.uint16),
        np.cumsum(rng.integers(0, 900, samples)) + first * 1000,
        rng.normal(size=samples),
        {3: text} if text else {},
    )
    (made,) = records_of(columns, boot, "cat", first)
    return made


def samples_of(found: list[SampleRecord]) -> list[tuple]:
    rows = []
    for each in found:
        frame = LINK_FROM_GATEWAY.decode(each.body)
        assert isinstance(frame, SampleBatch)
        columns = unpack_columns(frame)
        rows += [
            (frame.first + at, *row, frame.texts.get(at, ""))
            for at, row in enumerate(zip(*(each.tolist() for each in columns[:3]), strict=True))
        ]
    return rows


def test_packed_batches_come_back_to_the_bit() -> None:
    kept = [batch(number * 50, text="on" if number % 7 == 0 else "") for number in range(100)]
    # A hole in the numbers begins a new group, and a batch nobody can read is passed on.
    kept = [*kept[:40], record(2000), *kept[41:]]
    small = [*pack_records(kept)]
    assert len(small) == 3
    back = [one for each in small for one in unpack_record(each)]
    whole = [each for each in back if each.first != 2000]
    assert samples_of(whole) == samples_of([each for each in kept if each.first != 2000])
    assert max(each.samples for each in whole) == FRAME_SAMPLES
    assert sum(len(each.body) for each in small) < 0.7 * sum(len(each.body) for each in kept)


def test_packed_record_that_is_damaged_is_a_peer_error() -> None:
    (small,) = pack_records([batch(0), batch(50)])
    for body in (b"", small.body[:-5], b"\0" * 50):
        with pytest.raises(PeerError):
            unpack_record(small._replace(body=body))


def test_closed_segment_is_packed_and_read_as_before(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(segment=20_000))
    kept = [batch(number * 50) for number in range(100)]
    for each in kept:
        spool.append_record(each)
    on_disk = sum(each.stat().st_size for each in tmp_path.glob("*.seg"))
    assert on_disk < 0.8 * sum(len(pack_record(each)) for each in kept)
    assert samples_of(all_of(spool)) == samples_of(kept)
    spool.close()
    later = Spool(
        folder=tmp_path,
        head=SegmentHead("boot-b", "cat", []),
        bound=LARGE,
        sizes=SpoolSizes(segment=20_000),
    )
    assert samples_of(all_of(later)) == samples_of(kept)
    assert later.list_gaps() == []
    later.acknowledge_samples("boot-a", 5000)
    assert all_of(later) == []
    later.close()


def all_of(spool: Spool) -> list[SampleRecord]:
    found, place = [], SpoolPosition()
    while True:
        more, place = spool.read_records(place, 2000)
        if not more:
            return found
        found += [stored.record for stored in more]


def test_what_waits_too_long_gives_way_and_only_running_time_counts(tmp_path: Path) -> None:
    time_s = [1000.0]
    spool = Spool(
        folder=tmp_path,
        head=HEAD,
        bound=LARGE,
        sizes=SpoolSizes(segment=400),
        age_s=3600,
        now=lambda: time_s[0],
    )
    fill(spool, 4)
    time_s[0] += 3000
    fill(spool, 4, first=4)
    spool.close()
    # Another run, on a machine whose monotonic clock began anew.
    time_s[0] = 5.0
    later = Spool(
        folder=tmp_path,
        head=SegmentHead("boot-b", "c", []),
        bound=LARGE,
        sizes=SpoolSizes(segment=400),
        age_s=3600,
        now=lambda: time_s[0],
    )
    later.sync_to_disk()
    assert later.list_gaps() == []
    time_s[0] += 700
    later.append_record(record(0))
    (gap,) = later.list_gaps()
    assert (gap.first, gap.last) == (0, 39)
    assert gap.reason == journal.OLD
    assert [first for boot, first in kept(later) if boot == "boot-a"] == [40, 50, 60, 70]
    later.close()


def test_segment_without_a_head_is_set_aside_and_what_it_held_is_a_gap(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    for number in range(4):
        spool.append_record(batch(number * 50))
    (file,) = tmp_path.glob("*.seg")
    spool.close()
    data = bytearray(file.read_bytes())
    data[10] ^= 1
    file.write_bytes(data)
    later = Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
    assert [(gap.boot, gap.first, gap.last) for gap in later.list_gaps()] == [("boot-a", 0, 199)]
    assert [each.read_bytes() for each in tmp_path.glob("*.bad")] == [bytes(data)]
    later.close()


def test_damage_that_comes_while_it_runs_is_a_gap_and_the_rest_is_read(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
    fill(spool, 10)
    (file,) = tmp_path.glob("*.seg")
    data = bytearray(file.read_bytes())
    data[data.index(bytes([50 % 251]) * 100)] ^= 1
    with file.open("r+b") as there:
        there.write(data)
    assert [first for _, first in kept(spool)] == [0, 10, 20, 30, 40, 60, 70, 80, 90]
    (gap,) = spool.list_gaps()
    assert (gap.first, gap.last) == (50, 59)
    assert len(kept(spool)) == 9
    assert len(spool.list_gaps()) == 1
    spool.close()


def test_segment_that_can_no_longer_be_read_is_a_gap_and_breaks_nothing(tmp_path: Path) -> None:
    spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(segment=500))
    fill(spool, 9)
    sorted(tmp_path.glob("*.seg"))[1].unlink()
    there = [first for _, first in kept(spool)]
    (gap,) = spool.list_gaps()
    assert sorted([*there, *range(gap.first, gap.last + 1, 10)]) == [*range(0, 90, 10)]
    spool.close()


def test_disk_is_left_some_room_for_what_matters_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = [100_000]

    class Disk:
        f_blocks, f_frsize = 1 << 30, 1

        @property
        def f_bavail(self) -> int:
            return free[0]

    monkeypatch.setattr(os, "statvfs", lambda _: Disk())
    spool = Spool(
        folder=tmp_path, head=HEAD, bound=LARGE, sizes=SpoolSizes(segment=500), spare=50_000
    )
    fill(spool, 9)
    assert spool.list_gaps() == []
    free[0] = 50_000
    fill(spool, 1, first=9)
    # The older segments gave way, and the newest waits in memory.
    assert len([*tmp_path.glob("*.seg")]) == 1
    assert spool.list_gaps()[0].reason == journal.FULL
    assert kept(spool)[-1] == ("boot-a", 90)
    free[0] = 100_000
    fill(spool, 1, first=10)
    spool.close()
    later = Spool(
        folder=tmp_path,
        head=SegmentHead("boot-b", "cat", []),
        bound=LARGE,
        sizes=SpoolSizes(segment=500),
    )
    assert kept(later)[-2:] == [("boot-a", 90), ("boot-a", 100)]
    later.close()


def test_spool_opens_on_a_full_disk_and_goes_on_in_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(file: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        spool = Spool(folder=tmp_path, head=HEAD, bound=LARGE)
        fill(spool, 3)
        assert len(kept(spool)) == 3
    fill(spool, 1, first=3)
    spool.close()
    later = Spool(folder=tmp_path, head=SegmentHead("boot-b", "cat", []), bound=LARGE)
    assert kept(later) == [("boot-a", 0), ("boot-a", 10), ("boot-a", 20), ("boot-a", 30)]
    later.close()


def test_stops_and_epochs_are_written_on_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    epochs, stops = (
        persistent_state.LeaseEpochs(tmp_path / "epochs.json"),
        persistent_state.PersistentStops(tmp_path / "stops.json"),
    )

    def full(path: Path, data: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(persistence, "write_whole", full)
    latched = LatchedStop("id", "somebody", 5)
    stops.write_stop("base", latched)
    given = [epochs.next_epoch() for _ in range(2500)]
    assert given == sorted(set(given))
    assert persistent_state.PersistentStops(tmp_path / "stops.json").find_stop("base") == latched
    assert persistent_state.LeaseEpochs(tmp_path / "epochs.json").next_epoch() > given[-1]
