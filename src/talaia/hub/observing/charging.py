"""How much time of its proposal a request is charged, before anybody has observed it. Pure.

What is charged in the end is the block time that the gateway measured. An estimate counts the same
things: what leads to the first exposure, the frames with their readouts, changes of the filter.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from talaia.model.observing.requests import ImageType

if TYPE_CHECKING:
    from talaia.model.observing.plan import Instrument
    from talaia.model.observing.requests import Configuration, Request, RequestGroup

__all__ = ["TYPICAL_SLEW", "group_charge", "request_charge"]

# Where the telescope points before is not known: the mean way between two places that are both
# higher than 30° is about so far (°).
TYPICAL_SLEW = 45.0
_NEEDS_SKY = frozenset({ImageType.LIGHT, ImageType.SKY_FLAT})


def request_charge(request: Request, instrument: Instrument) -> float:
    """Estimate the block time of a request (s)."""
    return _lead_time(request, instrument) + sum(
        configuration.count * (configuration.exposure + instrument.readout)
        # A dithered mount settles before each frame but the first.
        + (configuration.count - 1) * (instrument.settle if configuration.dither else 0.0)
        for configuration in request.configurations
    )


def group_charge(group: RequestGroup, instrument: Instrument) -> float:
    """Estimate the block time of all requests of a group (s)."""
    return sum(request_charge(request, instrument) for request in group.requests)


def _lead_time(request: Request, instrument: Instrument) -> float:
    """Estimate what is spent on anything but frames (s)."""
    filters = [configuration.filter for configuration in request.configurations]
    # The first counts: another request has most probably left another filter in.
    changes = sum(bool(name) for name in filters[:1]) + sum(
        bool(after) and before != after for before, after in pairwise(filters)
    )
    spent = changes * instrument.filter_change
    if request.target is None or not any(map(_sees_sky, request.configurations)):
        return spent
    return spent + TYPICAL_SLEW / instrument.slew_rate + instrument.settle + instrument.acquire


def _sees_sky(configuration: Configuration) -> bool:
    return configuration.type in _NEEDS_SKY
