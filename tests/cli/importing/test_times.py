"""Times in tables are read to the microsecond, however they are written."""

from __future__ import annotations

# ruff: noqa: DTZ001 - what a table says, and what hypothesis wants, has no zone
import datetime as dt
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, settings, strategies as st

from talaia.cli.importing.times import CellError, TimeReader, TimeUnit

EPOCH = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)
US = dt.timedelta(microseconds=1)
ZONES = ("UTC", "Europe/Madrid", "America/St_Johns", "Australia/Lord_Howe", "Asia/Kathmandu")
moments = st.datetimes(
    min_value=dt.datetime(1900, 1, 1), max_value=dt.datetime(2900, 1, 1), timezones=st.just(dt.UTC)
)


@settings(deadline=None)
@given(moments, st.sampled_from(ZONES), st.sampled_from(["T", " "]))
def test_a_time_with_its_zone_comes_back_exactly(moment, zone, between) -> None:
    local = moment.astimezone(ZoneInfo(zone))
    # An offset says which of two equal clock times is meant.
    text = local.isoformat(between)
    assert TimeReader().read_time(f" {text} ") == (moment - EPOCH) // US


@settings(deadline=None)
@given(st.integers(-(2**53), 2**53), st.sampled_from(["s", "ms", "us", "ns"]))
def test_a_number_comes_back_exactly_in_each_unit(time_us, unit) -> None:
    digits = {"s": 6, "ms": 3, "us": 0, "ns": 0}[unit]
    whole = abs(time_us) * (1000 if unit == "ns" else 1)
    text = f"{whole // 10**digits}" + (f".{whole % 10**digits:0{digits}}" if digits else "")
    text = ("-" if time_us < 0 else "") + text
    assert TimeReader(unit=TimeUnit(unit)).read_time(text) == time_us


@settings(deadline=None)
@given(st.integers(1_000_000_000_000_000, 9_999_999_999_999_999))
def test_the_unit_is_found_by_the_size_of_the_number(time_us) -> None:
    for text in (f"{time_us // 10**6}.{time_us % 10**6:06}", f"{time_us}", f"{time_us}999"):
        assert TimeReader().read_time(text) == time_us
    assert TimeReader().read_time(f"{time_us // 1000}") == time_us // 1000 * 1000


@settings(deadline=None)
@given(
    st.datetimes(min_value=dt.datetime(2000, 1, 1), max_value=dt.datetime(2037, 1, 1)),
    st.sampled_from(ZONES),
)
def test_a_day_by_the_clock_on_the_wall_keeps_its_order_through_a_change(begin, zone) -> None:
    """A sample every ten minutes: the hour that comes twice is told apart by the order."""
    info = ZoneInfo(zone)
    first = begin.replace(tzinfo=dt.UTC)
    day = [first + dt.timedelta(minutes=10 * at) for at in range(200)]
    # Where the table begins in the second of two equal hours, nobody can know.
    if day[0].astimezone(info).fold:
        day = day[30:]
    reader = TimeReader(info)
    read = [
        reader.read_time(each.astimezone(info).replace(tzinfo=None).isoformat()) for each in day
    ]
    assert read == [(each - EPOCH) // US for each in day]


@settings(deadline=None)
@given(st.text(max_size=30))
def test_any_cell_is_a_time_or_an_error(text) -> None:
    for unit in TimeUnit:
        try:
            assert isinstance(TimeReader(ZoneInfo("Europe/Madrid"), unit).read_time(text), int)
        except CellError:
            continue


@pytest.mark.parametrize(
    "text",
    ["", "1e999", "nan", "-inf", "1_000", "20240131T120000Z", "2024-02-30", "12:00", "٣"],
)
def test_what_is_no_time_is_refused(text) -> None:
    with pytest.raises(CellError):
        TimeReader(ZoneInfo("UTC")).read_time(text)


def test_a_time_that_never_was_and_one_without_zone_are_refused() -> None:
    with pytest.raises(CellError, match="never showed"):
        TimeReader(ZoneInfo("Europe/Madrid")).read_time("2024-03-31T02:30:00")
    with pytest.raises(CellError, match="--zone"):
        TimeReader().read_time("2024-03-31T02:30:00")


def test_nanoseconds_are_cut_and_not_rounded() -> None:
    reader = TimeReader()
    assert reader.read_time("2024-01-31T12:00:00.123456999Z") % 1_000_000 == 123_456
    assert TimeReader().read_time("1700000000123456999") == 1_700_000_000_123_456
