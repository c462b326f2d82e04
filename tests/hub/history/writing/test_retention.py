"""What is dropped and what never is, how much room is taken, and what damage costs."""

import numpy as np
import pytest
import sqlalchemy as sa

from talaia.clock import HandClock
from talaia.hub.history.store import HistoryStore
from talaia.model.connection import RosSource
from talaia.model.site import Device, Signal, Site
from talaia.wire.columns import Columns

from ..conftest import SMALL, opened
from ..samples import ALL, batch

SECOND = 1_000_000
HOUR = 3_600 * SECOND
DAY = 24 * HOUR
START = 1_700_000_000 * SECOND
LIMITS = SMALL._replace(block=512, recent=512, tidy_s=0.0)
ADDRESSES = ["base/brief", "base/long"]


async def feed(store, count, first=0, channel=0, start=START, step=SECOND):
    for at in range(first, first + count, 500):
        index = np.arange(at, min(at + 500, first + count))
        columns = Columns(
            np.full(index.size, channel, np.uint16), start + index * step, np.sin(index), {}
        )
        await store.append_samples("agv", f"b{channel}", at, addresses=ADDRESSES, columns=columns)


def site_of(**keep):
    source = RosSource(topic="/a", type="b/msg/C")
    signals = {name: Signal(name=name, source=source, keep=days) for name, days in keep.items()}
    devices = {"base": Device(name="Base", signals=signals)}
    return Site(talaia=1, site="agv", name="AGV", devices=devices)


async def test_a_signal_is_kept_as_long_as_its_description_says(url) -> None:
    clock = HandClock()
    now_us = clock.wall_ns() // 1000
    store = HistoryStore(url, clock, LIMITS)
    await store.create_tables()
    await store.open()
    await store.describe_site(site_of(brief=1.0, long=0.0))
    start = now_us - 2 * DAY
    for channel in (0, 1):
        await feed(store, 4_000, channel=channel, start=start, step=43 * SECOND)
    before = await store.read_series("agv", ADDRESSES, *ALL, width=10_000)
    assert [each.time_us.size for each in before] == [4_000, 4_000]
    assert await store.apply_retention() > 0
    brief, long = await store.read_series("agv", ADDRESSES, *ALL, width=10_000)
    assert long.time_us.size == 4_000
    # Whole blocks go: what is left begins at most a block before a day ago.
    assert now_us - DAY - 1_100 * 43 * SECOND < brief.time_us[0] <= now_us - DAY
    assert brief.time_us[-1] == long.time_us[-1]
    (shown,) = await store.read_series("agv", ["base/brief"], start, now_us, width=10)
    assert shown.time_us[0] >= brief.time_us[0]
    assert await store.apply_retention() == 0
    await store.close()
    # It does not come back, and what is sent again is still known to be stored.
    async with opened(url, LIMITS) as again:
        await feed(again, 4_000, channel=0, start=start, step=43 * SECOND)
        (series,) = await again.read_series("agv", ["base/brief"], *ALL, width=10_000)
        assert series.time_us.tolist() == brief.time_us.tolist()


async def test_scores_of_a_detector_go_with_their_signal(url) -> None:
    clock = HandClock()
    store = HistoryStore(url, clock, LIMITS)
    await store.create_tables()
    await store.open()
    await store.describe_site(site_of(brief=1.0, long=0.0))
    start = clock.wall_ns() // 1000 - 2 * DAY
    addresses = ["base/brief~together", "base/long~together"]
    for at in range(0, 4_000, 500):
        for channel in (0, 1):
            times = start + np.arange(at, at + 500) * 43 * SECOND
            scores = Columns(np.full(500, channel, np.uint16), times, np.zeros(500), {})
            await store.append_samples(
                "agv", f"scores-{channel}", at, addresses=addresses, columns=scores
            )
    assert await store.apply_retention() > 0
    brief, long = await store.read_series("agv", addresses, *ALL, width=10_000)
    assert long.time_us.size == 4_000
    assert start < brief.time_us[0] <= start + DAY
    assert [store.kept_us("agv", each) for each in addresses] == [DAY, 0]
    await store.close()


async def test_the_oldest_go_when_all_is_too_much(url) -> None:
    async with opened(url, LIMITS._replace(bytes=30_000)) as store:
        for channel in (0, 1):
            await feed(store, 3_000, channel=channel, start=START + channel * 3_000 * SECOND)
        before = (await store.measure_storage()).blocks_bytes
        assert before > 30_000
        await store.apply_retention()
        found = await store.measure_storage()
        assert 20_000 < found.blocks_bytes <= 30_000
        first, second = await store.read_series("agv", ADDRESSES, *ALL, width=10_000)
        assert second.time_us.size == 3_000
        assert 0 < first.time_us.size < 3_000
        assert first.time_us[-1] == START + 2_999 * SECOND


async def test_after_rollups_were_dropped_new_ones_are_right(url) -> None:
    async with opened(url, LIMITS._replace(bytes=1)) as store:
        await feed(store, 3_000, step=SECOND // 100)
        await store.apply_retention()
        await feed(store, 3_000, first=3_000, step=SECOND // 100)
        (series,) = await store.read_series(
            "agv", ["base/brief"], START, START + 70 * SECOND, width=10
        )
        (exact,) = await store.read_series(
            "agv", ["base/brief"], START, START + 70 * SECOND, width=9_000
        )
        assert series.value.max() == exact.value.max()
        (found,) = await store.read_statistics("agv", ["base/brief"], *ALL)
        assert found.samples == exact.time_us.size


async def test_storage_counts_what_there_is_and_what_came_in_the_last_week(url) -> None:
    clock = HandClock()
    now_us = clock.wall_ns() // 1000
    store = HistoryStore(url, clock, LIMITS)
    await store.create_tables()
    await store.open()
    await feed(store, 3_000, channel=0, start=now_us - 3_000 * SECOND)
    await feed(store, 3_000, channel=1, start=now_us - 9 * DAY)
    found = await store.measure_storage()
    await store.close()
    new, old = found.channels
    assert (new.address, old.address) == ("base/brief", "base/long")
    assert new.week_bytes == new.bytes > 0
    assert old.week_bytes == 0
    assert found.blocks_bytes == new.bytes + old.bytes
    assert found.database_bytes > found.blocks_bytes
    ours = url.startswith("sqlite")
    assert (found.free_bytes is not None) == (found.disk_bytes > 0) == ours
    assert found.kind.split()[0] in {"SQLite", "PostgreSQL", "MariaDB", "MySQL"}
    assert found.kind.split()[1][0].isdigit()
    assert sa.make_url(url).database in found.place


async def test_a_damaged_block_is_a_gap_and_harms_nothing_else(url) -> None:
    async with opened(url, LIMITS) as store:
        await feed(store, 3_000)
        engine = sa.create_engine(url)
        with engine.begin() as connection:
            connection.execute(
                sa.text("UPDATE history_body SET body = :junk WHERE block_id = 2"),
                {"junk": b"\x01\xff\xff\xff\xff junk"},
            )
        engine.dispose()
        (series,) = await store.read_series("agv", ["base/brief"], *ALL, width=10_000)
        (gap,) = series.gaps
        assert "damaged" in gap.reason
        assert 1_000 < series.time_us.size < 3_000
        assert not series.exact
        inside = (series.time_us >= gap.from_us) & (series.time_us <= gap.to_us)
        assert not inside.any()
        assert await store.last_readings("agv", ["base/brief"])


async def test_a_damaged_journal_row_does_not_keep_the_hub_from_starting(url) -> None:
    async with opened(url) as store:
        for at in range(3):
            await store.append_samples(
                "agv", "b1", at, addresses=["a/x"], columns=batch([(0, START + at, float(at))])
            )
    engine = sa.create_engine(url)
    with engine.begin() as connection:
        connection.execute(sa.text("UPDATE history_hot SET body = :b WHERE id = 2"), {"b": b"\x09"})
    engine.dispose()
    async with opened(url) as store:
        (series,) = await store.read_series("agv", ["a/x"], *ALL, width=100)
        assert series.value.tolist() == [0.0, 2.0]
        await store.append_samples(
            "agv", "b1", 3, addresses=["a/x"], columns=batch([(0, START + 3, 3.0)])
        )
        assert await store.stored_below("agv", "b1") == 4


@pytest.mark.parametrize("kept", [0.0, 5.0])
async def test_a_removed_signal_is_kept_for_good(url, kept) -> None:
    clock = HandClock()
    store = HistoryStore(url, clock, LIMITS)
    await store.create_tables()
    await store.open()
    await store.describe_site(site_of(brief=kept))
    assert store.kept_us("agv", "base/brief") == round(kept * DAY)
    await store.describe_site(site_of())
    assert store.kept_us("agv", "base/brief") == 0
    await feed(store, 2_000, start=clock.wall_ns() // 1000 - 90 * DAY)
    assert await store.apply_retention() == 0
    await store.close()
