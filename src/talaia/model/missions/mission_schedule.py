"""When a schedule is due, in a time zone that changes its clocks. Pure."""

from __future__ import annotations

from datetime import UTC, date, datetime, time, timedelta
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

from talaia.model.missions.mission import DAYS

if TYPE_CHECKING:
    from talaia.model.missions.mission import MissionSchedule

__all__ = ["next_due_us", "read_date", "read_time"]

# A week has each of its days, and one more for what is past today.
_MOST_DAYS = 8
_US = 1_000_000


def next_due_us(schedule: MissionSchedule, zone: str, after_us: int) -> int | None:
    """Give the first moment after ``after_us`` at which it is due (µs, UTC); None: never again.

    A time of day that comes twice as the clocks go back is due once, the first time. One that is
    left out as they go forward is due as long after midnight as on other days: 02:30 is then what
    the clock shows as 03:30.
    """
    place = ZoneInfo(zone)
    at = read_time(schedule.at)
    if at is None:
        return None
    if schedule.date:
        day = read_date(schedule.date)
        due = None if day is None else _moment_us(day, at, place)
        return due if due is not None and due > after_us else None
    wanted = {DAYS.index(day) for day in schedule.days if day in DAYS} or set(range(7))
    # The day before as well: in the zone it may still be yesterday, and rounding costs nothing.
    today = datetime.fromtimestamp(after_us / _US, UTC).astimezone(place).date()
    for ahead in range(-1, _MOST_DAYS + 1):
        day = today + timedelta(days=ahead)
        if day.weekday() in wanted and (due := _moment_us(day, at, place)) > after_us:
            return due
    return None


def _moment_us(day: date, at: time, place: ZoneInfo) -> int:
    # fold=0: the first of two, and for a time that is left out the offset of before.
    local = datetime.combine(day, at, tzinfo=place)
    return round(local.timestamp() * _US)


def read_time(text: str) -> time | None:
    """Read ``HH:MM``; None where it is none."""
    hours, colon, minutes = text.partition(":")
    if not colon or len(text) != 5 or not (hours + minutes).isascii():
        return None
    try:
        return time(int(hours), int(minutes))
    except ValueError:
        return None


def read_date(text: str) -> date | None:
    """Read ``YYYY-MM-DD``; None where it is none."""
    try:
        return date.fromisoformat(text) if len(text) == len("2026-01-31") else None
    except ValueError:
        return None
