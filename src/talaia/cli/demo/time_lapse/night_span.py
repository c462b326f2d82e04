"""From when to when a night is lived through. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.night.target_place import sun_altitude

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Place

__all__ = ["NightSpan", "next_night"]

# The Sun's altitude (°): nothing opens before, and all is closed behind.
DUSK, DAWN = -7.0, -6.0
_STEP_S = 60.0
_DAY_S = 86_400.0


class NightSpan(NamedTuple):
    """Of a night: when it begins and ends (s since the epoch, UTC)."""

    begins: float
    ends: float


def next_night(place: Place, after: float, hours: float = 0.0) -> NightSpan:
    """Give the next night that begins after a time; of a long one its last hours, if given.

    Raises:
        ValueError: there is none for a year: it is beyond a polar circle.

    """
    begins = _crossing(place, after, DUSK, sinking=True)
    ends = _crossing(place, begins, DAWN, sinking=False)
    return NightSpan(max(begins, ends - hours * 3600.0) if hours > 0.0 else begins, ends)


def _crossing(place: Place, after: float, altitude: float, *, sinking: bool) -> float:
    before = sun_altitude(place, after)
    time = after
    while time < after + 366 * _DAY_S:
        time += _STEP_S
        now = sun_altitude(place, time)
        if (before > altitude >= now) if sinking else (before < altitude <= now):
            return time
        before = now
    raise ValueError("there is no night here for a year")
