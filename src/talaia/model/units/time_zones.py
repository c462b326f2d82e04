"""The names of the world's time zones."""

from functools import cache
from zoneinfo import available_timezones

__all__ = ["known_zones"]


@cache
def known_zones() -> frozenset[str]:
    """Give the names of all time zones, like ``Europe/Berlin``.

    They are files: to list them takes 10 ms, and a hub checks a description whenever one arrives.
    """
    return frozenset(available_timezones())
