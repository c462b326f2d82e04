"""What says that a roof opens, where a description does not say it itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.interlocks.enclosure import Sighting

if TYPE_CHECKING:
    from talaia.model.interlocks.enclosure import Enclosure
    from talaia.model.site import Site

__all__ = ["opening_of"]

# Compared without regard to capitals.
_OPENING = "opening"


def opening_of(site: Site, enclosure: Enclosure) -> tuple[Sighting, ...]:
    """Give the sightings by which an enclosure is seen to open; none where nothing can say so."""
    if enclosure.opening:
        return enclosure.opening
    found: dict[str, Sighting] = {}
    for address in (sensor.signal for sensor in (*enclosure.moving, *enclosure.closed)):
        device, _, signal = address.partition("/")
        # Of a number there are none, so it says nothing of opening.
        words = [
            word
            for word in site.devices[device].signals[signal].states
            if word.casefold() == _OPENING
        ]
        if words:
            found[address] = Sighting(signal=address, is_one_of=tuple(words))
    return tuple(found.values())
