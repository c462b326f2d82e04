"""What a request looks at."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

__all__ = [
    "Degrees",
    "FixedTarget",
    "IcrsTarget",
    "SolarSystemBody",
    "SolarSystemTarget",
    "Target",
    "TargetName",
    "target_name",
]

TargetName = Annotated[str, Meta(max_length=100)]
Degrees = Annotated[float, Meta(ge=0, lt=360)]
_Declination = Annotated[float, Meta(ge=-90, le=90)]
# Barnard's star moves by 10.4″ a year.
_ProperMotion = Annotated[float, Meta(ge=-20_000, le=20_000)]


class SolarSystemBody(StrEnum):
    """Bodies whose place is worked out without the network."""

    MOON = "moon"
    MERCURY = "mercury"
    VENUS = "venus"
    MARS = "mars"
    JUPITER = "jupiter"
    SATURN = "saturn"
    URANUS = "uranus"
    NEPTUNE = "neptune"


class IcrsTarget(
    msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="ICRS", omit_defaults=True
):
    """A place among the stars.

    Attributes:
        name: as its requester calls it.
        ra: right ascension, ICRS (°, 0 to 360).
        dec: declination, ICRS (°).
        proper_motion_ra: with the cosine of the declination, as Gaia gives it (mas/year).
        proper_motion_dec: (mas/year).
        epoch: at which it stood there (Julian year).
        position_angle: where a picture's top shall point, from north through east (°, 0 to 360);
            none: as the camera stands.

    """

    name: TargetName = ""
    ra: Degrees
    dec: _Declination
    proper_motion_ra: _ProperMotion = 0.0
    proper_motion_dec: _ProperMotion = 0.0
    epoch: Annotated[float, Meta(ge=1800, le=2200)] = 2000.0
    position_angle: Degrees | None = None


class SolarSystemTarget(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    tag_field="type",
    tag="SOLAR_SYSTEM",
    omit_defaults=True,
):
    """A body that moves among the stars."""

    name: TargetName = ""
    body: SolarSystemBody


class FixedTarget(
    msgspec.Struct, frozen=True, kw_only=True, tag_field="type", tag="FIXED", omit_defaults=True
):
    """A place above the horizon, where nothing is tracked (°; azimuth from north through east)."""

    name: TargetName = ""
    altitude: Annotated[float, Meta(ge=0, le=90)]
    azimuth: Degrees


Target = IcrsTarget | SolarSystemTarget | FixedTarget


def target_name(target: Target) -> str:
    """Give what a target is called; its coordinates where nobody named it."""
    if target.name:
        return target.name
    match target:
        case IcrsTarget():
            return f"{target.ra / 15.0:.4f} h {target.dec:+.3f}°"
        case SolarSystemTarget():
            return target.body.value.capitalize()
        case FixedTarget():
            return f"alt {target.altitude:.1f}° az {target.azimuth:.1f}°"
