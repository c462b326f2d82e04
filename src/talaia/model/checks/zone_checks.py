"""Cross-checks of zones and lines on a camera's picture, and of the signals that count there."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, finding_of, id_fits, name_fits
from talaia.model.detection import Measured
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from talaia.model.detection import (
        Detect,
        DetectionSource,
        FloorPoints,
        PictureLine,
        PicturePoint,
        PictureZone,
    )

__all__ = ["floor_fits", "measure_fits", "picture_zones_fit", "zones_fit"]

_MOST_EACH, _MOST_POINTS = 32, 64
_LONGEST_OVER_S = 86_400.0
_CROSSINGS = (Measured.LEFT, Measured.RIGHT)
# What a detector's boxes tell; the others are of `picture_models`.
_OF_THINGS = (Measured.COUNT, Measured.DWELL, *_CROSSINGS, Measured.SPEED)
# Three points whose triangle is smaller than this (parts of the picture, or m²) lie on one line.
_FLAT = 1e-4


def zones_fit(where: str, detect: Detect) -> Iterator[Finding]:
    """List what is wrong with a camera's zones and lines, and with the points of its floor."""
    yield from picture_zones_fit(where, detect.zones)
    yield from _marks_fit(f"{where}.lines", detect.lines, 2)
    if detect.floor is not None:
        yield from floor_fits(f"{where}.floor", detect.floor)


def picture_zones_fit(where: str, zones: Mapping[str, PictureZone]) -> Iterator[Finding]:
    """List what is wrong with zones of a picture."""
    yield from _marks_fit(f"{where}.zones", zones, 3)


def _marks_fit(
    where: str, marks: Mapping[str, PictureZone | PictureLine], least: int
) -> Iterator[Finding]:
    if len(marks) > _MOST_EACH:
        yield Finding(where, f"expected at most {_MOST_EACH}, found {len(marks)}")
    for name, mark in marks.items():
        at = f"{where}.{name}"
        yield from id_fits(at, name)
        yield from name_fits(f"{at}.name", mark.name)
        if not least <= len(mark.points) <= _MOST_POINTS:
            problem = f"expected {least} to {_MOST_POINTS} points, found {len(mark.points)}"
            yield Finding(f"{at}.points", problem, "as [[0.2, 0.5], [0.8, 0.5], [0.8, 1]]")
        yield from _points_fit(f"{at}.points", mark.points)


def floor_fits(where: str, floor: FloorPoints) -> Iterator[Finding]:
    """List what is wrong with the points of a floor."""
    yield from _points_fit(f"{where}.picture", floor.picture)
    for index, point in enumerate(floor.metres):
        if not all(math.isfinite(metres) for metres in point):
            yield Finding(f"{where}.metres[{index}]", "expected finite numbers")
            return
    for key, points in (("picture", floor.picture), ("metres", floor.metres)):
        if any(_area(three) < _FLAT for three in itertools.combinations(points, 3)):
            remedy = "take the corners of a rectangle that is marked on the floor"
            yield Finding(f"{where}.{key}", "three of the points lie on one line", remedy)


def _points_fit(where: str, points: Sequence[PicturePoint]) -> Iterator[Finding]:
    for index, point in enumerate(points):
        # Written so that NaN is found as well.
        if not all(0 <= part <= 1 for part in point):
            problem = "expected two parts of the picture, 0 to 1"
            yield Finding(f"{where}[{index}]", problem, "as [0.3, 0.5]")


def _area(three: Sequence[PicturePoint]) -> float:
    (x, y), (to_x, to_y), (third_x, third_y) = three
    return abs((to_x - x) * (third_y - y) - (to_y - y) * (third_x - x)) / 2


def measure_fits(where: str, source: DetectionSource, detect: Detect) -> Iterator[Finding]:
    """List what is wrong with what a signal tells of a camera's zone or line."""
    if source.measure not in _OF_THINGS:
        problem = f"a detector tells no {source.measure}"
        yield Finding(f"{where}.measure", problem, f"one of: {', '.join(_OF_THINGS)}")
        return
    crosses = source.measure in _CROSSINGS
    if source.zone and source.zone not in detect.zones:
        yield _unknown(f"{where}.zone", "zone", source.zone, tuple(detect.zones))
    if source.line and source.line not in detect.lines:
        yield _unknown(f"{where}.line", "line", source.line, tuple(detect.lines))
    if crosses and not source.line:
        yield Finding(f"{where}.line", "which line is to be crossed?", "write: line: door")
    if source.line and not crosses:
        remedy = "write: measure: left, or measure: right"
        yield Finding(f"{where}.measure", "to which side is the line crossed?", remedy)
    if source.measure is Measured.DWELL and not source.zone:
        yield Finding(f"{where}.zone", "in which zone do they dwell?", "write: zone: door")
    if source.measure is Measured.SPEED and detect.floor is None:
        problem = "the camera does not know its floor, so speed is not known"
        yield Finding(f"{where}.measure", problem, "write at the stream's detect: floor")
    if source.zone and source.within is not None:
        problem = "a zone and a part of the picture exclude each other"
        yield Finding(f"{where}.within", problem, "leave one of them out")
    if not 0 <= source.over <= _LONGEST_OVER_S:
        problem = f"expected 0 to {_LONGEST_OVER_S:g} s, found {source.over}"
        yield Finding(f"{where}.over", problem)
    elif source.over and not crosses:
        problem = "only crossings are counted over a time"
        yield Finding(f"{where}.over", problem, "leave it out")


def _unknown(where: str, kind: str, found: str, known: tuple[str, ...]) -> Finding:
    if not known:
        return Finding(where, f"the camera has no {kind}s", f"write at its detect: {kind}s")
    return finding_of(UnknownWord(where, kind, found, known))
