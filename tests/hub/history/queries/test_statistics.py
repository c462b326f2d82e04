"""What a window amounts to is the same from samples and from rollups."""

import math

import numpy as np
import pytest

from talaia.hub.history.queries.series import HistoryGap
from talaia.hub.history.queries.statistics import SampleReading, covered_us
from talaia.wire.columns import Columns

from ..conftest import SMALL, opened
from ..samples import ALL, batch

SECOND = 1_000_000
START = 1_700_000_000 * SECOND
MANY = SMALL._replace(block=512, recent=512)


async def feed(store, time_us, value, first=0):
    for at in range(0, time_us.size, 500):
        part = slice(at, at + 500)
        size = time_us[part].size
        columns = Columns(np.zeros(size, np.uint16), time_us[part], value[part], {})
        await store.append_samples(
            "agv", "b1", first + at, addresses=["base/speed"], columns=columns
        )


@pytest.mark.parametrize("raw", [200, 10**9])
async def test_statistics_of_a_window_are_those_of_its_samples(url, raw) -> None:
    time_us = START + np.arange(20_000) * SECOND // 100
    value = np.random.default_rng(1).normal(1000.0, 0.01, 20_000)
    value[5_000:5_010] = np.nan
    async with opened(url, MANY._replace(raw=raw)) as store:
        await feed(store, time_us, value)
        first, last = int(time_us[37]) + 1, int(time_us[19_041]) + 3
        await store.record_gap(
            "agv", "b1", 30_000, 30_010, from_us=last - 5 * SECOND, to_us=last + SECOND, reason="x"
        )
        (found,) = await store.read_statistics("agv", ["base/speed"], first, last)
    inside = (time_us >= first) & (time_us <= last)
    there, at = value[inside], time_us[inside]
    assert (found.samples, found.numbers) == (there.size, int(np.isfinite(there).sum()))
    assert found.mean == pytest.approx(np.nanmean(there), rel=1e-12)
    assert found.deviation == pytest.approx(np.nanstd(there), rel=1e-6)
    assert found.low == (at[np.nanargmin(there)], np.nanmin(there), "")
    assert found.high == (at[np.nanargmax(there)], np.nanmax(there), "")
    assert found.first == (at[0], there[0], "")
    assert found.last == (at[-1], there[-1], "")
    assert found.gap_us == 5 * SECOND


async def test_statistics_count_late_samples_and_what_is_not_in_a_block(url) -> None:
    time_us = START + np.arange(5_000) * SECOND // 100
    async with opened(url, MANY) as store:
        await feed(store, time_us, np.ones(5_000))
        await feed(store, time_us[1000:1700] + 1, np.full(700, 5.0), first=10_000)
        await feed(store, time_us[:3] - 10, np.full(3, -3.0), first=20_000)
        (found,) = await store.read_statistics("agv", ["base/speed"], *ALL)
    assert found.samples == 5_703
    assert found.mean == pytest.approx((5_000 + 700 * 5 - 9) / 5_703)
    assert found.first == (START - 10, -3.0, "")
    assert found.low == (START - 10, -3.0, "")


async def test_texts_have_a_first_and_a_last_and_no_mean(url) -> None:
    async with opened(url) as store:
        rows = [(0, START + i, f"line {i}") for i in range(5)]
        await store.append_samples("agv", "b1", 0, addresses=["a/mode"], columns=batch(rows))
        said, nothing = await store.read_statistics("agv", ["a/mode", "no/such"], *ALL)
    assert (said.samples, said.numbers, said.low, said.high) == (5, 0, None, None)
    assert math.isnan(said.mean)
    assert [said.first.text, said.last.text] == ["line 0", "line 4"]
    assert (nothing.samples, nothing.first) == (0, None)


async def test_the_last_value_before_a_time_is_the_newest_up_to_it(url) -> None:
    time_us = START + np.arange(3_000) * SECOND
    async with opened(url) as store:
        await feed(store, time_us, np.arange(3_000.0))
        late = [(0, START + 500 * SECOND + 1, 77.0)] * 40
        await store.append_samples(
            "agv", "b1", 9_000, addresses=["base/speed"], columns=batch(late)
        )
        for at in (0, 31, 32, 33, 1_234, 2_999):
            found = await store.last_readings("agv", ["base/speed"], START + at * SECOND)
            assert found["base/speed"] == SampleReading(START + at * SECOND, float(at), "")
        found = await store.last_readings("agv", ["base/speed"], START + 500 * SECOND + 5)
        assert found["base/speed"][1] == 77.0
        assert await store.last_readings("agv", ["base/speed"], START - 1) == {}


def test_gaps_that_overlap_count_once() -> None:
    gaps = [HistoryGap(0, 50, "a"), HistoryGap(40, 60, "b"), HistoryGap(90, 200, "c")]
    assert covered_us(gaps, 10, 100) == 50 + 10
    assert covered_us([], 0, 10) == 0
