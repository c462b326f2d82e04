"""Records that come close together are written together, and nothing that is asked misses one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from hypothesis import given, strategies as st

from talaia.gateway.samples.batching import records_of
from talaia.gateway.spool.journal import SegmentHead, Spool, SpoolPosition
from talaia.gateway.spool.sizes import USUAL, SpoolSizes
from talaia.gateway.spool.spool_thread import SpoolThread
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

    from talaia.gateway.spool.segment import SampleRecord

HEAD = SegmentHead("b", "c", ["base/v"])


def spool_in(folder: Path, sizes: SpoolSizes = USUAL, bound: int = 1 << 30) -> Spool:
    return Spool(folder=folder, head=HEAD, bound=bound, sizes=sizes)


def record_at(first: int, count: int = 1) -> SampleRecord:
    columns = Columns(
        np.zeros(count, np.uint16), first + np.arange(count), np.arange(count) * 1.0, {}
    )
    (record,) = records_of(columns, "b", "c", first)
    return record


async def test_what_is_read_has_what_was_appended_a_moment_before(tmp_path: Path) -> None:
    keeper = SpoolThread(spool_in(tmp_path), gather_s=3600.0)
    for first in range(3):
        keeper.append_record(record_at(first))
    found, _ = await keeper.read_records(SpoolPosition(), 1 << 20)
    assert [stored.record.first for stored in found] == [0, 1, 2]
    keeper.append_record(record_at(3))
    await keeper.sync_to_disk()
    found, _ = await keeper.read_records(await keeper.seek_sample("b", 3), 1 << 20)
    assert found[-1].record.first == 3
    await keeper.close()


async def test_what_was_appended_last_is_on_disk_after_the_end(tmp_path: Path) -> None:
    keeper = SpoolThread(spool_in(tmp_path), gather_s=3600.0)
    for first in range(5):
        keeper.append_record(record_at(first))
    await keeper.close()
    again = SpoolThread(spool_in(tmp_path))
    found, _ = await again.read_records(SpoolPosition(), 1 << 20)
    assert [stored.record.first for stored in found] == [0, 1, 2, 3, 4]
    await again.close()


Groups = st.lists(st.lists(st.integers(1, 30), min_size=1, max_size=6), max_size=12)


@given(groups=Groups, small=st.booleans(), tight=st.booleans())
def test_records_together_are_kept_as_those_one_by_one(
    tmp_path_factory: pytest.TempPathFactory,
    groups: list[list[int]],
    small: bool,  # noqa: FBT001 - hypothesis calls by name
    tight: bool,  # noqa: FBT001
) -> None:
    sizes = SpoolSizes(segment=700) if small else USUAL
    bound = 4000 if tight else 1 << 30
    kept = []
    for together in (True, False):
        spool = spool_in(tmp_path_factory.mktemp("spool"), sizes, bound)
        first = 0
        for group in groups:
            records = []
            for count in group:
                records.append(record_at(first, count))
                first += count
            if together:
                spool.append_records(records)
            else:
                for record in records:
                    spool.append_record(record)
        place, seen = SpoolPosition(), []
        while True:
            found, place = spool.read_records(place, 1 << 20)
            if not found:
                break
            seen += [(stored.record.first, stored.record.samples) for stored in found]
        lost = [number for gap in spool.list_gaps() for number in range(gap.first, gap.last + 1)]
        have = [number for begin, count in seen for number in range(begin, begin + count)]
        # Nothing is gone without a word, and nothing comes twice.
        assert sorted(have + lost) == list(range(first))
        kept.append(have)
        spool.close()
    if not tight:
        assert kept[0] == kept[1]
