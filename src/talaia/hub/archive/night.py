"""Which night a time belongs to. Pure."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

__all__ = ["night_of"]


def night_of(time_us: int, zone: str) -> str:
    """Give the local date at which the night began: it lasts from noon to noon.

    Args:
        time_us: since the epoch, UTC.
        zone: the site's time zone, by its IANA name.

    """
    # One date for a whole night: what is made after midnight stands with what was made before it.
    local = datetime.fromtimestamp(time_us / 1e6, UTC).astimezone(ZoneInfo(zone))
    # By the clock on the wall: also on the two days a year that have not 24 hours.
    return (local.replace(tzinfo=None) - timedelta(hours=12)).date().isoformat()
