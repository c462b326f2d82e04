"""Checks of what goes by a zone of the map: conditions of interlocks, and alarms."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, check_above, finding_of, number_text
from talaia.model.errors import UnknownWord
from talaia.model.maps.geofence import Geofence
from talaia.model.maps.map_checks import geometry_findings
from talaia.model.maps.site_map import GeometryType, SiteMap
from talaia.model.site import PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.alarms.alarm import Alarm
    from talaia.model.interlocks.interlock import Condition
    from talaia.model.site import Signal, Site

__all__ = ["watched_zone_findings", "zone_condition_findings"]

# Judged at each driving frame: each place costs about a microsecond.
_MOST_PLACES = 500
# Across (m). Wider than this the plane is no longer the ground, to a centimetre.
_WIDEST = 20_000.0
# A zone of less is a slip of the pen (m²).
_SMALLEST = 0.01
# Nearer to the edge than this (m) is most of any yard.
_WIDEST_MARGIN = 1000.0


def zone_condition_findings(site: Site, where: str, condition: Condition) -> Iterator[Finding]:
    """List what does not fit in a condition with ``inside``, ``outside`` or ``margin``."""
    others = [
        key
        for key in ("minus", "humidity", "above", "below", "until_below", "until_above")
        if getattr(condition, key) not in ("", None)
    ]
    others += ["is"] if condition.is_one_of else []
    others += ["is_not"] if condition.is_not else []
    for key in others:
        yield Finding(f"{where}.{key}", "a position beside a zone has none", "make two conditions")
    positions = {
        f"{device_id}/{signal_id}": signal
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
        if signal.type is SignalType.POSITION
    }
    if condition.signal not in positions:
        known = list(positions)
        yield finding_of(UnknownWord(f"{where}.signal", "position", condition.signal, known))
        return
    signal = positions[condition.signal]
    if condition.max_age is not None:
        yield from check_above(f"{where}.max_age", condition.max_age, 0)
    elif signal.max_age == 0:
        problem = f"{condition.signal} never goes stale, so nothing would tell that it fell silent"
        yield Finding(f"{where}.max_age", problem, "say here how old it may be (s)")
    yield from watched_zone_findings(site.map, where, condition, signal)


def watched_zone_findings(
    shown: SiteMap | None, where: str, watch: Condition | Alarm, signal: Signal
) -> Iterator[Finding]:
    """List what does not fit in the zone of a condition or of an alarm.

    Args:
        shown: the site's map.
        where: the place of what watches it.
        watch: has ``inside``, ``outside`` and ``margin``.
        signal: the position.

    """
    key = "inside" if watch.inside else "outside"
    name = watch.inside or watch.outside
    if not name:
        yield Finding(where, "it names no zone", "write inside: or outside:, and a zone")
        return
    if watch.inside and watch.outside:
        yield Finding(where, "both inside and outside are given", "make two of it")
        return
    if not 0 <= watch.margin <= _WIDEST_MARGIN:
        problem = f"expected 0 to {_WIDEST_MARGIN:g} m, found {number_text(watch.margin)}"
        yield Finding(f"{where}.margin", problem)
    zones = {} if shown is None else shown.zones
    if name not in zones:
        yield finding_of(UnknownWord(f"{where}.{key}", "zone", name, list(zones)))
        return
    if signal.frame is not PositionFrame.WGS84 and (shown is None or shown.origin is None):
        problem = "the position is in metres, and nothing says where its zero lies"
        yield Finding(f"{where}.{key}", problem, "write map: {origin: {latitude: …, longitude: …}}")
    yield from _ground_findings(shown, where, key, name)


def _ground_findings(shown: SiteMap | None, where: str, key: str, name: str) -> Iterator[Finding]:
    if shown is None:
        return
    geometry, at = shown.zones[name].geometry, f"{where}.{key}"
    if geometry.type is not GeometryType.POLYGON:
        yield Finding(at, f"{name} is a {geometry.type}: nothing is inside of it", "draw a Polygon")
        return
    if next(geometry_findings(at, geometry), None) is not None:
        return  # What is wrong there is said there.
    places = sum(len(line) for line in geometry.lines())
    if places > _MOST_PLACES:
        problem = f"{name} has {places} places, more than {_MOST_PLACES}"
        yield Finding(at, problem, "draw it with fewer; it is judged at each driving frame")
        return
    fence = Geofence(shown.zones[name])
    if not fence.span() <= _WIDEST:
        yield Finding(at, f"{name} is wider than {_WIDEST / 1000:g} km", "draw a smaller one")
    elif not fence.area() >= _SMALLEST or not math.isfinite(fence.area()):
        yield Finding(at, f"{name} encloses no ground", "draw it around some")
    elif next(fence.crossings(), None) is not None:
        problem = f"lines of {name} cross, so it is not clear what is inside"
        yield Finding(at, problem, "draw it without crossing")
