"""A night in minutes for a simulated observatory: what is asked of it by a button. Pure.

In real time, short frames of what is high now; of one that lives faster than people do, a whole
night.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.observing.requests import (
    Configuration,
    Constraints,
    GroupOperator,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.states import RequestState
from talaia.model.observing.targets import IcrsTarget

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "PROPOSAL",
    "SHORT_NIGHT_S",
    "high_targets",
    "night_targets",
    "short_night_group",
    "whole_night_group",
]

# It is armed for so long; three targets take about a third of it (s).
SHORT_NIGHT_S = 30 * 60.0
PROPOSAL = "SHORT-NIGHT"
_TARGETS, _FRAMES, _EXPOSURE_S = 3, 2, 5.0
_LOWEST = 25.0
# Of a whole night: its longest, what its targets rise above (°), and how they are observed.
_NIGHT_S, _HIGH = 14 * 3600.0, 40.0
_NIGHT_TARGETS, _NIGHT_FRAMES, _NIGHT_EXPOSURE_S = 12, 6, 120.0
# Several nights may be lived through one after the other, all of them ahead of the time here.
_AHEAD_S = 30 * 86_400.0
_J2000_S = 946_728_000.0


class _Bright(NamedTuple):
    name: str
    ra: float
    dec: float


# Open clusters and the like all around the sky (J2000, SIMBAD), so that three always stand high
# from middle latitudes of either hemisphere.
_SKY = (
    _Bright("M 103", 23.34, 60.66),
    _Bright("M 34", 40.53, 42.72),
    _Bright("M 45", 56.60, 24.11),
    _Bright("M 38", 82.17, 35.82),
    _Bright("M 35", 92.27, 24.34),
    _Bright("M 47", 114.15, -14.48),
    _Bright("M 44", 130.05, 19.62),
    _Bright("M 67", 132.85, 11.81),
    _Bright("Leo Triplet", 169.73, 13.09),
    _Bright("NGC 3532", 166.42, -58.71),
    _Bright("M 3", 205.55, 28.38),
    _Bright("M 5", 229.64, 2.08),
    _Bright("M 13", 250.42, 36.46),
    _Bright("M 7", 268.45, -34.79),
    _Bright("M 11", 282.77, -6.27),
    _Bright("M 29", 305.98, 38.51),
    _Bright("M 15", 322.49, 12.17),
    _Bright("M 39", 322.95, 48.43),
    _Bright("M 2", 323.36, -0.82),
    _Bright("M 52", 351.20, 61.59),
    _Bright("NGC 288", 13.19, -26.58),
    _Bright("M 30", 325.09, -23.18),
    _Bright("NGC 253", 11.89, -25.29),
    _Bright("M 77", 40.67, -0.01),
    _Bright("M 79", 81.04, -24.52),
    _Bright("M 68", 189.87, -26.74),
)


def high_targets(latitude: float, longitude: float, time: float) -> list[IcrsTarget]:
    """Give the targets that stand highest during a short night, the first to set first.

    Args:
        latitude: (°).
        longitude: (°, east).
        time: (s since the epoch, UTC).

    """
    heights = {
        one: min(
            _altitude(one, latitude, longitude, time),
            _altitude(one, latitude, longitude, time + SHORT_NIGHT_S),
        )
        for one in _SKY
    }
    best = sorted(heights, key=lambda one: -heights[one])[:_TARGETS]
    kept = [one for one in best if heights[one] > _LOWEST]
    kept.sort(key=lambda one: -_hour_angle(one, longitude, time))
    return [IcrsTarget(name=one.name, ra=one.ra, dec=one.dec) for one in kept]


def night_targets(latitude: float, longitude: float, time: float) -> list[IcrsTarget]:
    """Give the targets that rise highest in the night that begins about now, by right ascension.

    Args:
        latitude: (°).
        longitude: (°, east).
        time: (s since the epoch, UTC).

    """
    hours = range(0, round(_NIGHT_S), 3600)
    heights = {
        one: max(_altitude(one, latitude, longitude, time + hour) for hour in hours) for one in _SKY
    }
    best = sorted(heights, key=lambda one: -heights[one])[:_NIGHT_TARGETS]
    kept = sorted((one for one in best if heights[one] > _HIGH), key=lambda one: one.ra)
    return [IcrsTarget(name=one.name, ra=one.ra, dec=one.dec) for one in kept]


def whole_night_group(
    targets: Sequence[IcrsTarget], filters: Sequence[str], requester: str, time: float
) -> RequestGroup:
    """Ask for some frames of each target, in a filter of its own, in any of the next nights."""
    return RequestGroup(
        id="new",
        proposal=PROPOSAL,
        name="A night at high speed",
        requester=requester,
        operator=GroupOperator.MANY,
        requests=tuple(
            Request(
                id="new",
                target=target,
                state=RequestState.PENDING,
                configurations=(
                    Configuration(
                        # The last one lets so little through that stars are few.
                        filter=filters[at % max(1, len(filters) - 1)] if filters else "",
                        exposure=_NIGHT_EXPOSURE_S,
                        count=_NIGHT_FRAMES,
                    ),
                ),
                constraints=Constraints(min_altitude=25.0, min_moon_distance=0.0),
                windows=(Window(start=time, end=time + _AHEAD_S),),
            )
            for at, target in enumerate(targets)
        ),
    )


def short_night_group(
    targets: Sequence[IcrsTarget], filters: Sequence[str], requester: str, time: float
) -> RequestGroup:
    """Ask for a few short frames of each target, each in a filter of its own, from now on."""
    return RequestGroup(
        id="new",
        proposal=PROPOSAL,
        name="A night in minutes",
        requester=requester,
        operator=GroupOperator.MANY,
        requests=tuple(
            Request(
                id="new",
                target=target,
                state=RequestState.PENDING,
                configurations=(
                    Configuration(
                        filter=filters[at % len(filters)] if filters else "",
                        exposure=_EXPOSURE_S,
                        count=_FRAMES,
                    ),
                ),
                constraints=Constraints(
                    min_altitude=15.0, min_moon_distance=0.0, max_sun_altitude=-6.0
                ),
                windows=(Window(start=time, end=time + SHORT_NIGHT_S),),
            )
            for at, target in enumerate(targets)
        ),
    )


def _hour_angle(one: _Bright, longitude: float, time: float) -> float:
    """Give it (°, -180 to 180), to some tenths: precession is left out."""
    # Meeus, Astronomical Algorithms, 12.4; UT1 is UTC within a second.
    sidereal = 280.46061837 + 360.98564736629 * (time - _J2000_S) / 86_400.0
    return (sidereal + longitude - one.ra + 180.0) % 360.0 - 180.0


def _altitude(one: _Bright, latitude: float, longitude: float, time: float) -> float:
    hour, phi, dec = map(math.radians, (_hour_angle(one, longitude, time), latitude, one.dec))
    height = math.sin(phi) * math.sin(dec) + math.cos(phi) * math.cos(dec) * math.cos(hour)
    return math.degrees(math.asin(max(-1.0, min(1.0, height))))
