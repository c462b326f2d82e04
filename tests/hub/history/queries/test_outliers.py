"""Outliers of a window are counted by the quartiles of every sample that is stored in it."""

import numpy as np
import pytest
from sqlalchemy import delete, func, select

from talaia.hub.history.queries import outliers
from talaia.hub.history.queries.outliers import scatter_parts
from talaia.hub.store import history_tables as tables

from ..conftest import opened
from ..samples import ALL
from .test_statistics import MANY, SECOND, START, feed

TIMES = START + np.arange(20_000) * SECOND // 100


async def found_in(store, first, last, k=1.5, address="base/speed"):
    steps = [each async for each in store.count_outliers("agv", address, first, last, k=k)]
    assert all(each is None for each in steps[:-1])
    return steps[-1]


def check(found, values, k):
    first, third = np.quantile(values, [0.25, 0.75])
    low, high = first - k * (third - first), third + k * (third - first)
    assert (found.samples, found.stored, found.exact) == (values.size, values.size, True)
    assert (found.first, found.third) == pytest.approx((first, third), rel=1e-12)
    assert found.outliers == int(np.count_nonzero((values < low) | (values > high)))
    assert found.outliers > 0


@pytest.mark.parametrize("k", [0.5, 1.5])
async def test_outliers_are_those_of_all_samples_in_and_beside_blocks(url, k) -> None:
    values = np.random.default_rng(1).normal(5.0, 0.3, TIMES.size)
    values[5_000:5_020] = np.nan
    async with opened(url, MANY) as store:
        await feed(store, TIMES, values)
        first, last = int(TIMES[37]) + 1, int(TIMES[19_041]) + 3
        found = await found_in(store, first, last, k)
        whole = await found_in(store, *ALL, k)
    inside = values[(first <= TIMES) & (last >= TIMES)]
    check(found, inside[np.isfinite(inside)], k)
    check(whole, values[np.isfinite(values)], k)


async def test_outliers_of_a_signal_that_drifts_are_found_when_less_is_held_than_there_is(
    url, monkeypatch
) -> None:
    monkeypatch.setattr(outliers, "KEPT", 1_000)
    random = np.random.default_rng(2)
    values = np.linspace(0.0, 50.0, TIMES.size) + random.normal(0.0, 1.0, TIMES.size)
    values[::500] = 300.0
    async with opened(url, MANY) as store:
        await feed(store, TIMES, values)
        check(await found_in(store, *ALL), values, 1.5)


async def test_of_too_few_samples_and_of_none_nothing_is_claimed(url) -> None:
    async with opened(url) as store:
        await feed(store, TIMES[:7], np.arange(7.0))
        few = await found_in(store, *ALL)
        none = await found_in(store, *ALL, address="base/never")
    assert (few.samples, few.outliers, none.samples) == (7, 0, 0)
    assert np.isnan([few.low, few.high, none.low]).all()


async def test_of_very_many_samples_an_even_part_is_looked_at_and_the_answer_says_so(url) -> None:
    values = np.random.default_rng(3).normal(0.0, 1.0, TIMES.size)
    async with opened(url, MANY._replace(counted=5_000)) as store:
        await feed(store, TIMES, values)
        found = await found_in(store, *ALL)
    assert not found.exact
    # What waits in memory is looked at besides.
    assert 3_000 < found.samples < 6_500
    assert found.stored > 15_000
    assert found.first == pytest.approx(np.quantile(values, 0.25), abs=0.1)


async def test_who_asks_may_stop_and_the_next_is_answered(url) -> None:
    values = np.random.default_rng(4).normal(0.0, 1.0, TIMES.size)
    async with opened(url, MANY) as store:
        await feed(store, TIMES, values)
        steps = store.count_outliers("agv", "base/speed", *ALL, k=1.5)
        assert await anext(steps) is None
        await steps.aclose()
        check(await found_in(store, *ALL), values, 1.5)


def test_parts_are_scattered_so_that_each_beginning_is_even() -> None:
    order = scatter_parts(list(range(1_000)), 0)
    assert sorted(order) == list(range(1_000))
    for many in (10, 100, 500):
        # Of each tenth of all about a tenth is among them.
        tenths = np.histogram(order[:many], bins=10, range=(0, 1_000))[0]
        assert tenths.min() >= many // 10 - 1
        assert tenths.max() <= many // 10 + 1
    assert order != scatter_parts(list(range(1_000)), 1)


async def test_a_block_that_is_gone_leaves_the_rest_and_the_answer_says_so(url) -> None:
    values = np.random.default_rng(5).normal(0.0, 1.0, TIMES.size)
    async with opened(url, MANY) as store:
        await feed(store, TIMES, values)
        with store._writing.begin() as connection:
            first = select(func.min(tables.body.c.block_id))
            connection.execute(
                delete(tables.body).where(tables.body.c.block_id == connection.scalar(first))
            )
        found = await found_in(store, *ALL)
    assert not found.exact
    assert 18_000 < found.samples < 20_000
