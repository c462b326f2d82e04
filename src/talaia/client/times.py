"""Moments, as scripts and people give them. Pure."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta

from talaia.client.errors import BadSettings

__all__ = ["Moment", "parse_moment"]

# A time with its zone, seconds since the epoch, or a text: see `parse_moment`.
Moment = datetime | float | str
_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86_400.0, "w": 604_800.0}
_AGO = re.compile(r"-?(\d+(?:\.\d+)?)([smhdw])")
# Of the wire: 2**53 µs is the year 2255.
_MOST_US = 2**53


def parse_moment(moment: Moment, now: datetime) -> int:
    """Give a moment as microseconds since the epoch (UTC).

    Args:
        moment: a datetime with its zone; seconds since the epoch; or a text: ``now``; so long ago
            (``90s``, ``15m``, ``2h``, ``7d``, ``1w``, also with a minus); or a date and time of ISO
            8601, which is UTC unless it says otherwise.
        now: what ``now`` and the times before it count from.

    Raises:
        BadSettings: it is no moment.

    """
    if isinstance(moment, str):
        found = _read_text(moment, now)
    elif isinstance(moment, datetime):
        if moment.tzinfo is None:
            raise BadSettings(f"{moment}: say in which zone; as datetime.now(UTC)")
        found = moment
    else:
        try:
            found = datetime.fromtimestamp(moment, UTC)
        except (ValueError, OverflowError, OSError) as error:
            raise BadSettings(f"{moment!r} is no time in seconds since the epoch") from error
    # In whole numbers: a float does not hold the microseconds of this century exactly.
    time_us = (found - datetime.fromtimestamp(0, UTC)) // timedelta(microseconds=1)
    if not 0 <= time_us <= _MOST_US:
        raise BadSettings(f"{moment}: expected a time after 1970")
    return time_us


def _read_text(text: str, now: datetime) -> datetime:
    if text == "now":
        return now
    try:
        if ago := _AGO.fullmatch(text):
            return now - timedelta(seconds=float(ago[1]) * _UNITS[ago[2]])
        found = datetime.fromisoformat(text)
    except (ValueError, OverflowError) as error:
        raise BadSettings(
            f"{text!r}: expected now, a time before it such as 2h (s, m, h, d, w), or a date and"
            " time such as 2026-05-01T20:00Z"
        ) from error
    return found if found.tzinfo is not None else found.replace(tzinfo=UTC)
