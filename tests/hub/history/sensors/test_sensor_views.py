"""Each sensor's view shows its name, its time and its values to anyone with an SQL client."""

import asyncio
import sqlite3
import threading
from contextlib import closing

import numpy as np
import pytest
import sqlalchemy as sa
from msgspec.structs import replace

from talaia.hub.history.sensors import sensor_registry, sensor_views
from talaia.hub.history.sensors.view_sql import view_name
from talaia.model.connection import RosSource
from talaia.model.site import Device, PositionFrame, Signal, SignalType, Site
from talaia.wire.columns import Columns

from ..conftest import SMALL, opened
from ..samples import batch

SECOND = 1_000_000
START = 1_700_000_000 * SECOND
HOSTILE = 'Κάθε "name" \' \\ %s %(x)s :y `;-- DROP TABLE users /* 🚢'
SOURCE = RosSource(topic="/a", type="b/msg/C")


def site_of(**signals):
    return Site(
        talaia=1, site="agv", name="AGV", devices={"base": Device(name="B", signals=signals)}
    )


def number(name="Speed", unit="m/s"):
    return Signal(name=name, unit=unit, source=SOURCE)


@pytest.fixture
def sql(url):
    engine = sa.create_engine(url)

    def run(query):
        with engine.connect() as connection:
            return [dict(row._mapping) for row in connection.execute(sa.text(query))]

    yield run
    engine.dispose()


async def feed(store, count, rate=100, first=0):
    for at in range(first, first + count, 500):
        index = np.arange(at, min(at + 500, first + count))
        columns = Columns(
            np.zeros(index.size, np.uint16), START + index * SECOND // rate, index / 8.0, {}
        )
        await store.append_samples("agv", "b1", at, addresses=["base/speed"], columns=columns)


async def test_a_new_sensor_has_its_view_at_once_and_its_values_as_they_come(url, sql) -> None:
    async with opened(url) as store:
        await store.describe_site(site_of(speed=number()))
        await store.wait_for_views()
        assert sql("SELECT * FROM sensor_agv_base_speed") == []
        for at in range(3):
            await store.append_samples(
                "agv",
                "b1",
                at,
                addresses=["base/speed"],
                columns=batch([(0, START + at * SECOND, at / 2)]),
            )
            await store.write_plain_rows()
            await store.write_plain_rows()
        rows = sql("SELECT * FROM sensor_agv_base_speed ORDER BY time")
        assert [row["value"] for row in rows] == [0.0, 0.5, 1.0]
        assert {(row["sensor"], row["unit"], row["width_s"]) for row in rows} == {
            ("Speed", "m/s", 0)
        }
        times = [str(row["time"])[:19] for row in rows]
        if not url.startswith("postgresql"):  # it shows times in the session's zone
            assert times == [f"2023-11-14 22:13:2{at}" for at in range(3)]
        assert sql("SELECT view_name, shown_name FROM history_sensor") == [
            {"view_name": "sensor_agv_base_speed", "shown_name": "Speed"}
        ]


async def test_of_very_many_sensors_the_first_have_views(url, sql, monkeypatch, caplog) -> None:
    monkeypatch.setattr(sensor_views, "MOST_VIEWS", 25)
    async with opened(url) as store:
        await store.describe_site(site_of(**{f"s{each}": number() for each in range(40)}))
        await store.wait_for_views()
    assert len(sql("SELECT view_name FROM history_sensor WHERE made_of <> ''")) == 25
    assert len(sql("SELECT view_name FROM history_sensor")) == 40
    assert "agv has many signals" in caplog.text


async def test_a_file_has_as_many_views_as_its_connections_bear_and_says_so_once(
    tmp_path, caplog
) -> None:
    url = f"sqlite:///{tmp_path / 'history.db'}"
    sites = [
        replace(site_of(**{f"s{each}": number() for each in range(100)}), site=f"agv{at}")
        for at in range(5)
    ]
    async with opened(url) as store:
        for site in sites:
            await store.describe_site(site)
        await store.wait_for_views()
        made = "SELECT site, shown_name FROM history_sensor WHERE made_of <> ''"
        with closing(sqlite3.connect(tmp_path / "history.db")) as file:
            assert len(file.execute(made).fetchall()) == sensor_views.MOST_IN_FILE
            assert caplog.text.count("there is no view for SQL") == 1
            # One that has its view has it made anew, full or not.
            signals = {**sites[0].devices["base"].signals, "s0": number(name="Wind")}
            await store.describe_site(replace(site_of(**signals), site="agv0"))
            await store.wait_for_views()
            rows = file.execute(made).fetchall()
        assert ("agv0", "Wind") in rows
        assert len(rows) == sensor_views.MOST_IN_FILE


async def test_samples_do_not_wait_for_views(url, monkeypatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(*_: object) -> None:
        begun.set()
        go_on.wait(10)

    monkeypatch.setattr(sensor_registry, "show_sensors", slow)
    async with opened(url) as store:
        await store.describe_site(site_of(speed=number()))
        assert await asyncio.to_thread(begun.wait, 10)
        await feed(store, 10)
        assert not go_on.is_set()
        go_on.set()


async def test_a_view_shows_rollups_and_after_them_single_readings(url, sql) -> None:
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await store.describe_site(site_of(speed=number()))
        await store.wait_for_views()
        for at in range(0, 4_000, 500):
            await feed(store, 500, first=at)
            await store.write_plain_rows()
        await feed(store, 20, first=4_000)
        await store.write_plain_rows()
        rows = sql("SELECT * FROM sensor_agv_base_speed ORDER BY time")
        wide = [row for row in rows if row["width_s"]]
        single = [row for row in rows if not row["width_s"]]
        assert {float(row["width_s"]) for row in wide} == {5.0}
        assert single
        assert max(row["time"] for row in wide) < min(row["time"] for row in single)
        assert wide[1]["samples"] == 500
        assert wide[1]["minimum"] < wide[1]["value"] < wide[1]["maximum"]
        # A stretch of time is shown once.
        assert len({row["time"] for row in rows}) == len(rows)


async def test_states_texts_and_positions_have_columns_of_their_own(url, sql) -> None:
    gear = Signal(name="Gear", type=SignalType.STATE, states=("park", "it's"), source=SOURCE)
    mode = Signal(name="Mode", type=SignalType.TEXT, source=SOURCE)
    pose = Signal(name="Pose", type=SignalType.POSITION, source=SOURCE)
    fix = Signal(name="Fix", type=SignalType.POSITION, frame=PositionFrame.WGS84, source=SOURCE)
    names = ["base/gear", "base/mode", "base/pose.x", "base/pose.y", "base/pose.yaw"]
    async with opened(url) as store:
        await store.describe_site(site_of(gear=gear, mode=mode, pose=pose, fix=fix))
        await store.wait_for_views()
        for at in range(3):
            time = START + at
            rows = [(0, time, float(at)), (1, time, f"line {at // 2}")]
            rows += [(2, time, 1.0 + at), (3, time, 2.0), (4, time, float("nan"))]
            await store.append_samples("agv", "b1", 5 * at, addresses=names, columns=batch(rows))
            await store.write_plain_rows()
        found = sql("SELECT * FROM sensor_agv_base_gear ORDER BY value")
        assert [row["state"] for row in found] == ["park", "it's", None]
        found = sql("SELECT * FROM sensor_agv_base_mode ORDER BY time")
        assert [row["value"] for row in found] == ["line 0", "line 1"]
        found = sql("SELECT * FROM sensor_agv_base_pose ORDER BY x")
        assert [(row["x"], row["y"], row["yaw"]) for row in found] == [
            (1.0, 2.0, None), (2.0, 2.0, None), (3.0, 2.0, None),
        ]  # fmt: skip
        assert sql("SELECT lat, lon, alt FROM sensor_agv_base_fix") == []


async def test_hostile_names_are_only_names(url, sql) -> None:
    async with opened(url) as store:
        await store.describe_site(site_of(speed=number(HOSTILE, HOSTILE[:50])))
        await store.wait_for_views()
        await store.append_samples(
            "agv", "b1", 0, addresses=["base/speed"], columns=batch([(0, START, 1.0)])
        )
        await store.write_plain_rows()
        (row,) = sql("SELECT * FROM sensor_agv_base_speed")
    assert (row["sensor"], row["unit"]) == (HOSTILE, HOSTILE[:50])


async def test_views_that_are_made_together_are_each_of_its_own_sensor(url, sql) -> None:
    """More than one turn of them; what one is made of is not another's."""
    signals = {f"s{at}": number(f"{HOSTILE}; END; {at}", unit="%s;") for at in range(60)}
    async with opened(url) as store:
        await store.describe_site(site_of(**signals))
        await store.wait_for_views()
        made = sql("SELECT address, made_of FROM history_sensor")
        assert len({row["made_of"] for row in made} - {""}) == 60
        for at in range(60):
            address, sample = [f"base/s{at}"], batch([(0, START, at / 2)])
            await store.append_samples("agv", "b1", at, addresses=address, columns=sample)
        await store.write_plain_rows()
        for at in range(60):
            (row,) = sql(f"SELECT * FROM sensor_agv_base_s{at}")  # noqa: S608
            assert (row["sensor"], row["value"]) == (f"{HOSTILE}; END; {at}", at / 2)
        # One that is called otherwise has its view made anew, and no other has.
        signals["s7"] = number("Seven")
        await store.describe_site(site_of(**signals))
        await store.wait_for_views()
        anew = sql("SELECT address, made_of FROM history_sensor")
        before = {row["address"]: row["made_of"] for row in made}
        changed = [row["address"] for row in anew if row["made_of"] != before[row["address"]]]
        assert changed == ["base/s7"]
        assert sql("SELECT sensor FROM sensor_agv_base_s7") == [{"sensor": "Seven"}]


async def test_a_renamed_or_removed_sensor_keeps_its_view_and_its_history(url, sql) -> None:
    async with opened(url) as store:
        await store.describe_site(site_of(speed=number("Old name"), gone=number()))
        await store.wait_for_views()
        await feed(store, 3, rate=1)
        await store.write_plain_rows()
        await store.describe_site(site_of(speed=number("New name")))
        await store.wait_for_views()
        (row,) = sql("SELECT * FROM sensor_agv_base_speed")
        assert row["sensor"] == "New name"
        assert sql("SELECT * FROM sensor_agv_base_gone") == []
    async with opened(url) as store:
        await store.describe_site(site_of(velocity=number("New name")))
        await store.wait_for_views()
        assert len(sql("SELECT * FROM sensor_agv_base_speed")) == 1
        assert sql("SELECT * FROM sensor_agv_base_velocity") == []


async def test_rows_that_rollups_stand_for_are_deleted(url, sql) -> None:
    async with opened(url, SMALL._replace(block=512, recent=512)) as store:
        await store.describe_site(site_of(speed=number()))
        await store.wait_for_views()
        for at in range(160):
            await feed(store, 20, first=20 * at)
            await store.write_plain_rows()
        left = sql("SELECT count(*) AS n FROM history_recent")[0]["n"]
        assert 0 < left < 80


def test_view_names_differ_even_where_addresses_look_alike() -> None:
    taken = frozenset({"sensor_a_b_c"})
    assert view_name("a", "b/c", 7, frozenset()) == "sensor_a_b_c"
    assert view_name("a", "b/c", 7, taken) == "sensor_a_b_c_7"
    assert view_name("a", "β/γ", 8, frozenset({"sensor_a"})) == "sensor_a_8"
    long = view_name("a" * 60, "b" * 60, 9, frozenset())
    assert len(long) <= 63
    assert long.endswith("_9")


async def test_what_a_sensor_was_is_known_after_it_is_gone_and_after_a_restart(url) -> None:
    state = Signal(name=HOSTILE, type=SignalType.STATE, states=("off", "on"), source=SOURCE)
    async with opened(url) as store:
        await store.describe_site(site_of(mode=state, speed=number()))
        await store.wait_for_views()
        await store.describe_site(site_of(speed=number(name="Ground speed")))
        await store.wait_for_views()
        assert store.kind_of("agv", "base/speed").name == "Ground speed"
    async with opened(url) as store:
        assert store.kind_of("agv", "base/mode") == (HOSTILE, "", "state", ("off", "on"), -1)
        assert store.kind_of("agv", "base/speed").unit == "m/s"
        assert store.kind_of("agv", "base/other") is None
