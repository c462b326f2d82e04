"""Numbers of a proposed description whose unit nobody says. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.connection import RosSource
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Site

__all__ = ["numbers_without_unit", "unit_lines"]

# What is called so is an angle; whether in degrees, radians or hours no standard type says.
_ANGLES = (
    *("azimuth", "altitude", "elevation", "heading", "bearing", "yaw", "pitch", "roll", "angle"),
)
_SKY = {"ra", "dec", "axis_ra", "axis_dec", "rotation", "right_ascension", "declination"}
# A line of the file's head.
_WIDTH = 92


def numbers_without_unit(site: Site) -> Iterator[str]:
    """Give the addresses of numbers with a fraction that have no unit; parameters have none."""
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            source = signal.source
            is_parameter = isinstance(source, RosSource) and bool(source.parameter)
            # Of whole numbers most are counts and states.
            is_whole = signal.decimals == 0
            if signal.type is SignalType.NUMBER and not (signal.unit or is_parameter or is_whole):
                yield f"{device_id}/{signal_id}"


def unit_lines(addresses: list[str]) -> list[str]:
    """Say which they are, in lines of a file's head; none where there are none."""
    if not addresses:
        return []
    angles = [one for one in addresses if _is_angle(one)]
    others = [one for one in addresses if one not in angles]
    lines = ["Without a unit, for the robot says none: write unit: … where you know it."]
    if angles:
        said = "  angles, by their names (° or rad? only who made the robot knows):"
        lines += [said, *_filled(angles)]
    if others:
        lines += ["  others:" if angles else "  these:", *_filled(others)]
    return lines


def _is_angle(address: str) -> bool:
    word = address.rpartition("/")[2]
    return word in _SKY or any(part in word for part in _ANGLES)


def _filled(words: list[str]) -> Iterator[str]:
    line = "   "
    for word in words:
        if len(line) + len(word) > _WIDTH:
            yield line
            line = "   "
        line += f" {word}"
    yield line
