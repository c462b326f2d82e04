"""Whether a position is where it should not be, and why in words. Pure.

Interlocks and alarms go by the same: what is unknown here is unsafe there, and is shown as not
judged here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.maps.geofence import FARTHEST_M, Geofence, place_of_position

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.alarms.alarm import Alarm
    from talaia.model.interlocks.interlock import Condition
    from talaia.model.maps.site_map import SiteMap
    from talaia.model.site import Signal

__all__ = ["ZoneWatch"]


class ZoneWatch:
    """One position and one zone."""

    def __init__(self, watch: Condition | Alarm, signal: Signal, shown: SiteMap) -> None:
        """Lay the zone flat.

        Args:
            watch: has ``inside`` or ``outside``, and ``margin``.
            signal: the position.
            shown: the map in which the zone is.

        """
        zone = shown.zones[watch.inside or watch.outside]
        self._fence, self._name = Geofence(zone), zone.name
        self._outside, self._margin = bool(watch.outside), watch.margin
        self._signal, self._map = signal, shown

    def judge(self, numbers: Sequence[float]) -> tuple[bool | None, str]:
        """Tell whether a position is on the wrong side or too near to the edge; None: unknown.

        ``numbers`` are those of one message, as `parts_of` names them.
        """
        name = self._signal.name
        place = place_of_position(self._signal, numbers, self._map)
        if place is None:
            return None, f"{name}: it is no place on Earth"
        depth = self._fence.depth_of(place)
        if depth is None:
            far = f"{name}: farther than {FARTHEST_M / 1000:g} km from {self._name}"
            return None, f"{far}, so it is not believed"
        # Metres on the permitted side; the edge itself is on no side.
        clear = depth if self._outside else -depth
        right, wrong = ("inside", "outside") if self._outside else ("outside", "inside")
        if clear > self._margin:
            return False, f"{name} is {right} {self._name}"
        if clear <= 0:
            return True, f"{name} is {wrong} {self._name}"
        return True, f"{name} is less than {self._margin:g} m from the edge of {self._name}"
