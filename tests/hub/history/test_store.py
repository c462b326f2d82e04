"""The history store: what comes out is what went in."""

import asyncio
import itertools
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
import sqlalchemy as sa
from hypothesis import HealthCheck, given, settings, strategies as st
from many_examples import examples

from talaia.hub.history.errors import HistoryError
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.queries.series import HistoryGap
from talaia.wire.columns import Columns

from .conftest import SMALL, opened
from .samples import ALL, batch, rows_of, wanted

SECOND = 1_000_000
START = 1_700_000_000 * SECOND
ADDRESSES = ["base/speed", "base/pose.x", "base/mode"]

number = st.one_of(
    st.floats(-10, 10),
    st.sampled_from([float("nan"), float("inf"), float("-inf"), -0.0, 1.7976931348623157e308]),
)
# Times that repeat, go back, stand decades apart; all before the year 2100 or thereabouts.
moment = st.one_of(
    st.integers(START, START + 50), st.integers(START, START + 10**10), st.integers(0, 2**52)
)
row = st.one_of(
    st.tuples(st.integers(0, 1), moment, number),
    st.tuples(st.just(2), moment, st.text(max_size=5)),
)
# A stretch of the boot's samples by position and length: any order, repeats and overlaps.
stretches = st.lists(st.tuples(st.integers(0, 299), st.integers(1, 120)), min_size=1, max_size=12)


async def check(store, rows, stored):
    known = [r for i, r in enumerate(rows) if i in stored]
    for channel, series in enumerate(await store.read_series("agv", ADDRESSES, *ALL, width=1000)):
        assert series.exact
        assert rows_of(series) == wanted(known, channel)
        assert (np.diff(series.time_us) >= 0).all()
    below = next(i for i in range(len(rows) + 1) if i not in stored)
    assert await store.stored_below("agv", "b1") == below


def copy_files(folder: Path, old: int, new: int) -> None:
    for end in ("", "-wal"):
        file = folder / f"{old}.db{end}"
        if file.exists():
            shutil.copy(file, folder / f"{new}.db{end}")


@settings(
    max_examples=examples(12, many=400), deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
@given(st.lists(row, min_size=1, max_size=30), stretches, st.sets(st.integers(0, 11)))
def test_what_comes_out_went_in_for_any_order_overlap_and_crash(some, stretches, crashes) -> None:
    """A crash: the files as they are at that moment, opened by a new run."""
    again = (some * 300)[:300]
    rows = [(channel, at + i // len(some), value) for i, (channel, at, value) in enumerate(again)]

    async def run(folder: Path) -> None:
        stored, number = set(), 0
        paths = [folder / "0.db"]
        store = opened(f"sqlite:///{paths[0]}")
        current = await store.__aenter__()
        for at, (first, length) in enumerate(stretches):
            part = rows[first : first + length]
            await current.append_samples(
                "agv", "b1", first, addresses=ADDRESSES, columns=batch(part)
            )
            stored |= set(range(first, first + len(part)))
            if at in crashes:
                number += 1
                copy_files(folder, number - 1, number)
                await store.__aexit__(None, None, None)
                store = opened(f"sqlite:///{folder / f'{number}.db'}")
                current = await store.__aenter__()
                await check(current, rows, stored)
        await check(current, rows, stored)
        await store.__aexit__(None, None, None)

    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(run(Path(folder)))


def test_what_comes_out_went_in_on_each_database(url) -> None:
    """The same on a server, with fewer examples: each is a site of its own."""
    numbers = itertools.count()

    @settings(
        max_examples=examples(3, many=60), deadline=None, suppress_health_check=list(HealthCheck)
    )
    @given(st.lists(row, min_size=1, max_size=30), stretches)
    def one(some, stretches) -> None:
        again = (some * 300)[:300]
        rows = [
            (channel, at + i // len(some), value) for i, (channel, at, value) in enumerate(again)
        ]
        site = f"site{next(numbers)}"

        async def run() -> None:
            stored = set()
            for part in (stretches[::2], stretches[1::2]):
                async with opened(url) as store:
                    for first, length in part:
                        some = batch(rows[first : first + length])
                        await store.append_samples(
                            site, "b1", first, addresses=ADDRESSES, columns=some
                        )
                        stored |= set(range(first, min(first + length, 300)))
            async with opened(url) as store:
                known = [r for i, r in enumerate(rows) if i in stored]
                found = await store.read_series(site, ADDRESSES, *ALL, width=1000)
                for channel, series in enumerate(found):
                    assert rows_of(series) == wanted(known, channel)

        asyncio.run(run())

    one()


async def feed(store, count, rate=100, first=0, size=500, value=None):
    """Store one channel at a rate (Hz) in batches."""
    for at in range(first, first + count, size):
        index = np.arange(at, min(at + size, first + count))
        values = np.sin(index / 500) if value is None else value(index)
        time_us = START + index * SECOND // rate
        columns = Columns(np.zeros(index.size, np.uint16), time_us, values, {})
        await store.append_samples("agv", "b1", at, addresses=["base/speed"], columns=columns)


async def test_many_samples_survive_sealing_and_reopening(url) -> None:
    async with opened(url) as store:
        await feed(store, 3000)
    async with opened(url) as store:
        await feed(store, 2000, first=2500)
        (series,) = await store.read_series("agv", ["base/speed"], *ALL, width=5000)
        assert series.exact
        np.testing.assert_array_equal(series.time_us, START + np.arange(4500) * SECOND // 100)
        np.testing.assert_array_equal(series.value, np.sin(np.arange(4500) / 500))
        assert await store.stored_below("agv", "b1") == 4500


async def test_a_chart_has_at_most_two_points_a_pixel_and_every_spike(url) -> None:
    def spiky(index):
        value = np.sin(index / 5000)
        value[index == 7_777] = 99.0
        value[index == 31_313] = -99.0
        return value

    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await feed(store, 60_000, value=spiky)
        for width in (1, 2, 7, 20, 25):
            (series,) = await store.read_series(
                "agv", ["base/speed"], START, START + 600 * SECOND, width=width
            )
            assert not series.exact
            assert series.time_us.size <= 2 * width
            assert (np.diff(series.time_us) >= 0).all()
            assert series.value.max() == 99.0
            assert series.value.min() == -99.0
            assert START + 77_770_000 in series.time_us
        low, high = START + 77 * SECOND, START + 79 * SECOND
        (series,) = await store.read_series("agv", ["base/speed"], low, high, width=200)
        assert series.exact
        assert series.time_us.size == 201


@pytest.mark.parametrize("rate", [1, 100])
async def test_rollups_show_the_extremes_of_each_pixel_to_the_window_s_edge(url, rate) -> None:
    noise = np.random.default_rng(rate).normal(size=20_000)
    time_us = START + np.arange(20_000) * SECOND // rate
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await feed(store, 20_000, rate, value=lambda index: noise[index])
        # Ends that cut through buckets of every width.
        first, last = time_us[37] + 1, time_us[19_041] + 3
        (series,) = await store.read_series("agv", ["base/speed"], first, last, width=10)
        inside = (time_us >= first) & (time_us <= last)
        assert not series.exact
        assert series.time_us.size <= 20
        assert series.value.min() == noise[inside].min()
        assert series.value.max() == noise[inside].max()
        assert series.time_us.min() >= first
        assert series.time_us.max() <= last
        shown = dict(zip(time_us.tolist(), noise.tolist(), strict=True))
        assert all(shown[t] == v for t, v in zip(*series[1:3], strict=True))


async def test_late_samples_are_in_the_rollups_too(url) -> None:
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await feed(store, 10_000)
        late = np.arange(600)
        columns = Columns(
            np.zeros(600, np.uint16), START + 20 * SECOND + late, np.full(600, 50.0), {}
        )
        await store.append_samples("agv", "b1", 50_000, addresses=["base/speed"], columns=columns)
        await feed(store, 5_000, first=10_000)
        (series,) = await store.read_series(
            "agv", ["base/speed"], START, START + 200 * SECOND, width=20
        )
        assert not series.exact
        assert series.value.max() == 50.0


async def test_a_few_lone_samples_show_beside_rollups(url) -> None:
    """Too few for rollup rows of their own: they come out of their block."""
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await feed(store, 10_000)
        lone = [(0, START + (3 + 2 * i) * 3600 * SECOND, 70.0 + i) for i in range(4)]
        await store.append_samples(
            "agv", "b1", 10_000, addresses=["base/speed"], columns=batch(lone)
        )
        await feed(store, 4_000, first=2_000_000)
        (series,) = await store.read_series(
            "agv", ["base/speed"], START, START + 10 * 3600 * SECOND, width=50
        )
        assert not series.exact
        assert series.value[series.value >= 70.0].tolist() == [70.0, 71.0, 72.0, 73.0]


async def test_nan_infinities_and_texts_come_back(url) -> None:
    odd = [float("nan"), float("inf"), float("-inf"), -0.0, 5e-324, 1.7976931348623157e308]
    rows = [(0, START + i, odd[i % 6]) for i in range(300)]
    rows += [(2, START + i, "πλοίο 🚢\0" * (i % 3)) for i in range(300)]
    async with opened(url) as store:
        for at in range(0, 600, 60):
            await store.append_samples(
                "agv", "b1", at, addresses=ADDRESSES, columns=batch(rows[at : at + 60])
            )
        for channel in (0, 2):
            (series,) = await store.read_series("agv", [ADDRESSES[channel]], *ALL, width=1000)
            assert rows_of(series) == wanted(rows, channel)


async def test_infinite_spikes_show_in_a_chart_of_rollups(url) -> None:
    def odd(index):
        value = np.full(index.size, np.nan)
        value[index % 2000 == 999] = np.inf
        value[index % 2000 == 1999] = -np.inf
        return value

    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await feed(store, 20_000, value=odd)
        (series,) = await store.read_series(
            "agv", ["base/speed"], START, START + 200 * SECOND, width=15
        )
        assert np.inf in series.value
        assert -np.inf in series.value


async def test_many_texts_are_thinned_and_too_many_leave_a_gap_that_says_so(url) -> None:
    limits = SMALL._replace(texts=10_000)
    rows = [(0, START + i * SECOND, f"line {i}") for i in range(2000)]
    async with opened(url, limits) as store:
        for at in range(0, 2000, 100):
            await store.append_samples(
                "agv", "b1", at, addresses=["base/mode"], columns=batch(rows[at : at + 100])
            )
        (series,) = await store.read_series("agv", ["base/mode"], *ALL, width=10)
        assert not series.exact
        assert 2 <= len(series.texts) <= 20
        assert series.texts[len(series.texts) - 1] == "line 1999"
        assert not series.gaps


async def test_gaps_are_kept_once_and_count_as_settled(url) -> None:
    async with opened(url) as store:
        await store.append_samples(
            "agv", "b1", 0, addresses=ADDRESSES, columns=batch([(0, START, 1.0)] * 10)
        )
        for _ in range(2):
            await store.record_gap(
                "agv", "b1", 10, 19, from_us=START, to_us=START + SECOND, reason="spool full"
            )
        await store.append_samples(
            "agv", "b1", 20, addresses=ADDRESSES, columns=batch([(0, START, 1.0)] * 5)
        )
        await store.record_gap(
            "agv", "b1", 25, 24, from_us=START + 9 * SECOND, to_us=START + 10 * SECOND, reason="off"
        )
        assert await store.stored_below("agv", "b1") == 25
    async with opened(url) as store:
        assert await store.stored_below("agv", "b1") == 25
        (series,) = await store.read_series(
            "agv", ["base/speed"], START, START + 5 * SECOND, width=100
        )
        assert series.gaps == [HistoryGap(START, START + SECOND, "spool full")]
        assert series.time_us.size == 15
        (other,) = await store.read_series("dome", ["base/speed"], *ALL, width=100)
        assert other.gaps == []


async def test_last_is_the_newest_by_time_and_of_equals_the_latest(url) -> None:
    rows = [(0, START + i, float(i)) for i in range(100)]
    rows += [(0, START + 99, 123.0), (0, START, -1.0), (2, START, "on")]
    async with opened(url) as store:
        await store.append_samples("agv", "b1", 0, addresses=ADDRESSES, columns=batch(rows))
        wanted = {"base/speed": (START + 99, 123.0)}
        for _ in range(2):
            found = await store.last_readings("agv", [*ADDRESSES, "no/such"])
            assert found["base/speed"][:2] == wanted["base/speed"]
            assert found["base/mode"][2] == "on"
            assert "no/such" not in found
            # The second time round the tail is in a block.
            await store.append_samples(
                "agv", "b1", 200, addresses=ADDRESSES, columns=batch([(1, START, 0.0)] * 40)
            )


async def test_sites_boots_and_addresses_are_kept_apart(url) -> None:
    async with opened(url) as store:
        for site in ("agv", "AGV"):
            for boot in ("b1", "b2"):
                await store.append_samples(
                    site, boot, 0, addresses=["a/x", "A/x"], columns=batch([(0, START, 1.0)])
                )
        series = await store.read_series("agv", ["a/x", "A/x", "no/such"], *ALL, width=100)
        assert [each.time_us.size for each in series] == [2, 0, 0]


async def test_a_changed_description_keeps_the_history_of_what_it_renamed(url) -> None:
    async with opened(url) as store:
        await store.append_samples(
            "agv", "b1", 0, addresses=["a/old", "a/same"], columns=batch([(0, 1, 1.0), (1, 1, 2.0)])
        )
        await store.append_samples(
            "agv", "b1", 2, addresses=["a/same", "a/new"], columns=batch([(0, 2, 3.0), (1, 2, 4.0)])
        )
        series = await store.read_series("agv", ["a/old", "a/same", "a/new"], *ALL, width=100)
        assert [each.value.tolist() for each in series] == [[1.0], [2.0, 3.0], [4.0]]


async def test_rollups_give_back_every_bit_infinities_and_what_is_no_number(url) -> None:
    def odd(index):
        value = np.sin(index / 3.0) / 3e-7
        value[index < 6_000] = np.nan
        value[index == 9_000] = np.inf
        return value

    async with opened(url, SMALL._replace(block=512, largest=512, recent=512)) as store:
        await feed(store, 20_000, value=odd)
        window = (START, START + 200 * SECOND)
        (series,) = await store.read_series("agv", ["base/speed"], *window, width=20)
        assert not series.exact
        assert np.isnan(series.value[series.time_us < START + 50 * SECOND]).all()
        assert np.inf in series.value
        # Without the part that holds no number, which servers are asked for in another way.
        (later,) = await store.read_series(
            "agv", ["base/speed"], START + 80 * SECOND, window[1], width=10
        )
        known = dict(
            zip((START + np.arange(20_000) * SECOND // 100), odd(np.arange(20_000)), strict=True)
        )
        for each in (series, later):
            read = [known[time_us] for time_us in each.time_us]
            np.testing.assert_array_equal(each.value, read)


async def test_a_batch_that_cannot_be_kept_does_not_harm_the_others(url) -> None:
    good = batch([(0, START, 1.0)])
    async with opened(url) as store:
        bad = [
            store.append_samples(
                "agv", "b1", 5, addresses=["a/x"], columns=batch([(3, START, 1.0)])
            ),
            store.append_samples("agv", "b1", -1, addresses=["a/x"], columns=good),
            store.append_samples("agv", "b1", 5, addresses=["a/\0"], columns=good),
            store.append_samples(
                "agv", "b1", 5, addresses=["a/x"], columns=batch([(0, START, "\ud800")])
            ),
            store.append_samples(
                "agv", "b1", 5, addresses=["a/x"], columns=Columns(*good[:3], {7: "x"})
            ),
            store.record_gap("agv", "b1", 9, 5, from_us=0, to_us=0, reason="backwards"),
        ]
        fine = [
            store.append_samples("agv", "b1", i, addresses=["a/x"], columns=good) for i in range(5)
        ]
        answers = await asyncio.gather(*bad, *fine, return_exceptions=True)
        assert [type(each) for each in answers] == [HistoryError] * 6 + [type(None)] * 5
        (series,) = await store.read_series("agv", ["a/x"], *ALL, width=100)
        assert series.time_us.size == 5
        assert await store.stored_below("agv", "b1") == 5


async def test_slow_channels_do_not_keep_the_journal_from_shrinking(tmp_path) -> None:
    import sqlite3

    url = f"sqlite:///{tmp_path}/history.db"
    async with opened(
        url, HistoryLimits(block=64, largest=64, recent=32, journal=500, delete=4, linger_s=0.0)
    ) as store:
        slow, sequence = [], 0
        for at in range(200):
            rows = [(0, START + at * 1000 + i, float(i)) for i in range(20)]
            if at % 50 == 0:
                rows.append((1, START + at, float(at)))
                slow.append(float(at))
            await store.append_samples(
                "agv", "b1", sequence, addresses=ADDRESSES, columns=batch(rows)
            )
            sequence += len(rows)
        database = sqlite3.connect(tmp_path / "history.db")
        assert database.execute("select sum(samples) from history_hot").fetchone()[0] < 1000
        database.close()
    async with opened(url) as store:
        fast, slowly = await store.read_series("agv", ADDRESSES[:2], *ALL, width=5000)
        assert fast.time_us.size == 4000
        assert slowly.value.tolist() == slow
        assert await store.stored_below("agv", "b1") == sequence


async def test_many_gateways_that_send_little_leave_a_journal_of_few_rows(tmp_path) -> None:
    """Each batch is a row, and all rows are read before a hub that starts lets anybody in."""
    import sqlite3

    url = f"sqlite:///{tmp_path}/history.db"
    limits = HistoryLimits(recent=32, journal_rows=100, delete=4, linger_s=0.0)
    most = 0
    async with opened(url, limits) as store:
        for at in range(60):
            one = batch([(0, START + at, float(at))])
            await asyncio.gather(
                *(
                    store.append_samples(f"site{site}", "b1", at, addresses=["a/x"], columns=one)
                    for site in range(20)
                )
            )
            database = sqlite3.connect(tmp_path / "history.db")
            (rows,) = database.execute("select count(*) from history_hot").fetchone()
            database.close()
            most = max(most, rows)
    # 1 200 without the limit. Channels can be saved once their batches were dealt out to them,
    # which is after sixteen of each.
    assert 100 < most < 500
    async with opened(url, limits) as store:
        for site in range(20):
            (series,) = await store.read_series(f"site{site}", ["a/x"], *ALL, width=1000)
            assert series.value.tolist() == [float(at) for at in range(60)]


async def test_readings_for_sql_between_a_plan_and_its_commit_lose_nothing(tmp_path) -> None:
    """Some channels are planned to be sealed when a reading of each is taken of all that came."""
    limits = SMALL._replace(block=8, largest=8, recent=16)
    addresses = [f"base/s{at}" for at in range(20)]
    rows = [(at % 20, START + at, float(at)) for at in range(174)]
    async with opened(f"sqlite:///{tmp_path}/history.db", limits) as store:
        # All channels are full at once, and only a few are sealed with each commit.
        for first, past in ((0, 140), (140, 160), (160, 174)):
            await store.append_samples(
                "agv", "b1", first, addresses=addresses, columns=batch(rows[first:past])
            )
        await store.write_plain_rows()
        found = await store.read_series("agv", addresses, *ALL, width=100)
        for channel, series in enumerate(found):
            assert rows_of(series) == wanted(rows, channel)


async def test_reads_see_every_sample_while_blocks_are_sealed(url) -> None:
    """A sample moves from memory to a block: a reader must find it once, in one of them."""
    done = asyncio.Event()

    async def write(store) -> None:
        await feed(store, 4000, size=40)
        done.set()

    async with opened(url) as store:
        writing = asyncio.create_task(write(store))
        seen = 0
        while not done.is_set():
            (series,) = await store.read_series("agv", ["base/speed"], *ALL, width=4000)
            assert series.exact
            assert series.time_us.size >= seen
            assert np.unique(series.time_us).size == series.time_us.size
            assert series.time_us.size % 40 == 0
            seen = series.time_us.size
        await writing


async def test_a_database_without_tables_says_what_to_do(tmp_path) -> None:
    from talaia.clock import SystemClock
    from talaia.hub.history.store import HistoryStore

    store = HistoryStore(f"sqlite:///{tmp_path}/empty.db", SystemClock())
    with pytest.raises(HistoryError, match="tables are up to date"):
        await store.open()
    await store.close()


async def test_a_database_that_refuses_for_a_while_loses_and_doubles_nothing(url) -> None:
    engine = sa.create_engine(url)
    async with opened(url) as store:
        await feed(store, 200, size=20)
        with engine.begin() as connection:
            connection.exec_driver_sql("ALTER TABLE history_hot RENAME TO elsewhere")
        for _ in range(2):
            with pytest.raises(HistoryError, match="nothing can be stored"):
                await feed(store, 20, first=200)
        with engine.begin() as connection:
            connection.exec_driver_sql("ALTER TABLE elsewhere RENAME TO history_hot")
        await feed(store, 200, first=190, size=20)
        assert await store.stored_below("agv", "b1") == 390
        (series,) = await store.read_series("agv", ["base/speed"], *ALL, width=1000)
        np.testing.assert_array_equal(series.value, np.sin(np.arange(390) / 500))
    engine.dispose()


async def test_a_mistake_of_ours_leaves_nobody_waiting_and_is_over_with_the_next_batch(
    tmp_path, monkeypatch
) -> None:
    def mistake(*_):
        raise AttributeError("a name that is no longer there")

    async with opened(f"sqlite:///{tmp_path}/history.db") as store:
        with monkeypatch.context() as broken:
            broken.setattr(store._writer._checkpoints, "after_commit", mistake)
            await feed(store, 500)
            broken.setattr(store._writer, "_store_jobs", mistake)
            with pytest.raises(HistoryError, match="no longer there"):
                await feed(store, 500, first=500)
        await feed(store, 500, first=500)
        assert await store.stored_below("agv", "b1") == 1000


async def test_a_renamed_channel_keeps_all_it_had_and_goes_on_also_after_a_restart(url) -> None:
    async with opened(url) as store:
        await store.append_samples(
            "agv", "b1", 0, addresses=["base/speed"], columns=batch([(0, START, 1.0)])
        )
        await store.rename_channels("agv", {"base/speed": "base/velocity"})
        await store.append_samples(
            "agv", "b1", 1, addresses=["base/velocity"], columns=batch([(0, START + 1, 2.0)])
        )
        # Another one takes the old name, and has nothing of its history.
        both = ["base/velocity", "base/speed"]
        await store.append_samples(
            "agv", "b1", 2, addresses=both, columns=batch([(1, START + 2, 3.0)])
        )
    async with opened(url) as store:
        renamed, new = await store.read_series("agv", both, START, START + SECOND, width=100)
        assert renamed.value.tolist() == [1.0, 2.0]
        assert new.value.tolist() == [3.0]
        # Where there is a history already, nothing is mixed.
        await store.rename_channels("agv", {"base/speed": "base/velocity"})
        assert (await store.read_series("agv", both, START, START + SECOND, width=100))[
            1
        ].value.tolist() == [3.0]
