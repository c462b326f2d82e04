"""Which requests of darks, biases and flats may be taken now, and which is first. Pure.

No planner chooses them: what is taken under a closed roof takes no time from the sky, and flats
fill a twilight in which no target is observed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.night.simple_dispatch import (
    block_seconds,
    hours_veto,
    standing_veto,
    urgency_rank,
)
from talaia.model.observing.requests import ImageType

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.gateway.night.night_values import NightView
    from talaia.gateway.night.simple_dispatch import AskedRequest
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Request

__all__ = ["best_calibration", "is_of_flats", "needs_no_sky"]

_INDOORS = frozenset({ImageType.DARK, ImageType.BIAS})


def needs_no_sky(request: Request) -> bool:
    """Tell whether all frames of a request may be taken under a closed roof."""
    return all(part.type in _INDOORS for part in request.configurations)


def is_of_flats(request: Request) -> bool:
    """Tell whether a request is one of twilight flats alone."""
    return all(part.type is ImageType.SKY_FLAT for part in request.configurations)


def best_calibration(
    asked: Iterable[AskedRequest],
    view: NightView,
    night: NightSection,
    *,
    flats: bool,
    done: Mapping[str, tuple[int, ...]],
    ended: frozenset[str],
    held: Mapping[str, float],
    left: Mapping[str, float] | None = None,
) -> AskedRequest | None:
    """Give the most urgent, then the most valuable that may be taken now.

    Args:
        asked: requests of any kind.
        view: how things stand.
        night: which frames can be taken.
        flats: those of the twilight sky; else those that need no sky.
        done: frames of each configuration that there are, by request.
        ended: requests that have ended at this gateway.
        held: requests that are not tried before (s since the epoch, UTC).
        left: what proposals can pay; see `NightLimits`.

    """
    wanted = is_of_flats if flats else needs_no_sky
    filters = frozenset(night.filter.filters) if night.filter is not None else None
    instrument = night.times

    def may_be_taken(one: AskedRequest) -> bool:
        name, parts = one.request.id, one.request.configurations
        if not wanted(one.request):
            return False
        if any(night.frame_for(part.type) is None for part in parts):
            return False
        if (
            flats
            and filters is not None
            and any(part.filter not in {"", *filters} for part in parts)
        ):
            return False
        seconds = block_seconds(one.request, done.get(name, ()), instrument)
        if hours_veto(one, done.get(name, ()), instrument, left):
            return False
        return not standing_veto(
            one,
            view.time,
            # Flats come as the sky gives them: how long they take nobody knows before.
            0.0 if flats else seconds,
            done=done.get(name, ()),
            ended=ended,
            held_until=held.get(name, 0.0),
        )

    found = [one for one in asked if may_be_taken(one)]
    return min(found, key=lambda one: (-urgency_rank(one), -one.priority), default=None)
