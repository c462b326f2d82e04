"""When a schedule is due, also when the clocks change."""

from __future__ import annotations

from datetime import UTC, datetime
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, strategies as st

from talaia.model.missions.mission import DAYS, MissionSchedule
from talaia.model.missions.mission_schedule import next_due_us

MADRID = "Europe/Madrid"
US = 1_000_000


def us(text: str) -> int:
    return round(datetime.fromisoformat(text).timestamp() * US)


def due(schedule: MissionSchedule, after: str, zone: str = MADRID) -> str | None:
    found = next_due_us(schedule, zone, us(after))
    return None if found is None else f"{datetime.fromtimestamp(found / US, UTC):%Y-%m-%dT%H:%M}"


@pytest.mark.parametrize(
    ("after", "expected"),
    [
        ("2026-07-01T05:59:59+02:00", "2026-07-01T04:00"),
        # The very moment counts as past: it was due then, once.
        ("2026-07-01T06:00:00+02:00", "2026-07-02T04:00"),
        ("2026-01-01T00:00:00+01:00", "2026-01-01T05:00"),
    ],
)
def test_time_of_day_is_the_sites_own(after, expected) -> None:
    assert due(MissionSchedule(at="06:00"), after) == expected


def test_time_that_comes_twice_is_due_once_the_first_time() -> None:
    # On 25 October 2026 the clocks go from 03:00 back to 02:00.
    schedule = MissionSchedule(at="02:30")
    assert due(schedule, "2026-10-25T00:00:00+02:00") == "2026-10-25T00:30"
    assert due(schedule, "2026-10-25T02:30:00+02:00") == "2026-10-26T01:30"


def test_time_that_is_left_out_is_due_as_long_after_midnight_as_ever() -> None:
    # On 29 March 2026 the clocks go from 02:00 to 03:00.
    schedule = MissionSchedule(at="02:30")
    assert due(schedule, "2026-03-29T00:00:00+01:00") == "2026-03-29T01:30"
    assert due(schedule, "2026-03-29T03:31:00+02:00") == "2026-03-30T00:30"


def test_days_of_the_week_are_the_sites_own() -> None:
    # Monday 00:30 in Madrid is still Sunday in UTC.
    schedule = MissionSchedule(at="00:30", days=("mon",))
    assert due(schedule, "2026-07-05T12:00:00+02:00") == "2026-07-05T22:30"


def test_date_is_due_once() -> None:
    schedule = MissionSchedule(at="10:00", date="2026-07-05")
    assert due(schedule, "2026-07-01T00:00:00+02:00") == "2026-07-05T08:00"
    assert due(schedule, "2026-07-05T10:00:00+02:00") is None


@given(
    minute=st.integers(0, 24 * 60 - 1),
    days=st.lists(st.sampled_from(DAYS), unique=True),
    after_s=st.integers(us("2020-01-01T00:00+00:00") // US, us("2035-01-01T00:00+00:00") // US),
    zone=st.sampled_from([MADRID, "UTC", "Australia/Lord_Howe", "America/St_Johns"]),
)
def test_due_time_is_ahead_within_a_week_and_on_a_day_that_is_wanted(
    minute, days, after_s, zone
) -> None:
    schedule = MissionSchedule(at=f"{minute // 60:02}:{minute % 60:02}", days=tuple(days))
    found = next_due_us(schedule, zone, after_s * US)
    assert found is not None
    # A day with a change of the clocks is up to an hour longer.
    assert 0 < found - after_s * US <= (7 * 24 + 1) * 3600 * US
    local = datetime.fromtimestamp(found / US, UTC).astimezone(ZoneInfo(zone))
    assert not days or DAYS[local.weekday()] in days
    # The next one after it is another day.
    following = next_due_us(schedule, zone, found)
    assert following is not None
    assert following - found >= 22 * 3600 * US
