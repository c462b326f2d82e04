"""Where a telescope may not be pointed, whatever asks for it. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.model.units import astronomy

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.ports import Field
    from talaia.model.interlocks.enclosure import Place, Pointing, PointingArguments

__all__ = ["pointed_place", "pointing_problem"]

# Civil twilight: a Sun that is below this is no danger.
SUN_DOWN = -6.0


def pointing_problem(
    *,
    rule: Pointing,
    names: PointingArguments,
    args: Mapping[str, Field],
    place: Place,
    wall_ns: int,
) -> str:
    """Say why a telescope may not be pointed there; empty when it may.

    Args:
        rule: its limits.
        names: which arguments say where.
        args: the arguments by name.
        place: where it stands.
        wall_ns: now, UTC.

    """
    to = pointed_place(names, args, place, wall_ns)
    if isinstance(to, str):
        return to
    jd = astronomy.julian_day(wall_ns / SECOND)
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    if to.alt < rule.horizon:
        return f"the target stands at {to.alt:.1f} °; the horizon limit is {rule.horizon:g} °"
    # As seen from here, at this moment; a slew of minutes moves the Sun by a degree at most.
    sun = astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd)
    away = astronomy.angular_separation(to, sun)
    if sun.alt > SUN_DOWN and away < rule.sun:
        return f"the target is {away:.0f} ° from the Sun; the limit is {rule.sun:g} °"
    return ""


def pointed_place(
    names: PointingArguments, args: Mapping[str, Field], place: Place, wall_ns: int
) -> astronomy.Horizontal | str:
    """Give where a command points, seen from ``place`` at ``wall_ns``, or what is wrong with it."""
    jd = astronomy.julian_day(wall_ns / SECOND)
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    numbers: list[float] = []
    for name in (names.ra, names.dec) if names.ra else (names.alt, names.az):
        value = args.get(name)
        if (
            # bool is an int to Python, but no angle.
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not math.isfinite(value)
        ):
            return f"the argument {name!r} does not say where to point"
        numbers.append(float(value))
    if names.ra:
        ra, dec = numbers
        if not 0.0 <= ra < 24.0:
            return f"RA {ra:g} h: expected 0 to 24 h"
        if not -90.0 <= dec <= 90.0:
            return f"Dec {dec:g} °: expected -90 to 90 °"
        to = astronomy.equatorial_to_horizontal(ra, dec, here, jd)
    else:
        to = astronomy.Horizontal(*numbers)
        if not -90.0 <= to.alt <= 90.0 or not 0.0 <= to.az <= 360.0:
            return f"Alt {to.alt:g} °, Az {to.az:g} °: expected -90 to 90 ° and 0 to 360 °"
    return to
