"""Where on Earth it is night, or evening, now: what observes by night is shown by day. Pure.

Its place is moved along its parallel, in steps of the time zones, so that its clock is right, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

if TYPE_CHECKING:
    from talaia.model.site import Site

__all__ = ["at_dusk", "at_night", "longitude_of_night"]

_HOUR_S = 3600.0
# Dusk comes about so long before midnight (h).
_DUSK_H = 7.0


def longitude_of_night(unix_s: float) -> float:
    """Give the longitude (°, east, a multiple of 15) where it is midnight, within half an hour."""
    return 15.0 * _hours_east(unix_s)


def _hours_east(unix_s: float) -> int:
    # Midnight is where UTC's hour and the hours east make 24; past 12 it is nearer to the west.
    east = round(24.0 - unix_s / _HOUR_S % 24.0)
    return east if east <= 12 else east - 24


def at_dusk(site: Site, unix_s: float) -> Site:
    """Give a site where the evening begins; one without a place stays where it is."""
    return at_night(site, unix_s + _DUSK_H * _HOUR_S)


def at_night(site: Site, unix_s: float) -> Site:
    """Give a site where it is night; one without a place stays where it is."""
    if site.place is None:
        return site
    east = _hours_east(unix_s)
    # POSIX counts zones to the west: Etc/GMT-3 is three hours ahead.
    zone = f"Etc/GMT{-east:+d}" if east else "UTC"
    place = replace(site.place, longitude=longitude_of_night(unix_s))
    return replace(site, place=place, zone=zone)
