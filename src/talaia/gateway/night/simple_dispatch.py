"""The simplest planner: what may be observed now and is worth most a minute. Pure.

The night falls back on it when the planner's process is dead, late or answers what may not be
observed; and by its vetoes each answer is looked at. It knows no Moon: a request that minds the
Moon is left to the planner.
"""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.night.target_place import altitude_of, hour_angle_of, place_of_date
from talaia.model.observing.requests import GroupOperator, ImageType, Urgency
from talaia.model.observing.states import RequestState

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from talaia.gateway.night.night_values import NightView
    from talaia.gateway.night.target_place import EquatorialPlace
    from talaia.model.interlocks.enclosure import Place
    from talaia.model.observing.plan import Instrument
    from talaia.model.observing.requests import Constraints, Request, RequestGroup

__all__ = [
    "AskedRequest",
    "NightLimits",
    "best_request",
    "block_seconds",
    "frames_left",
    "hours_veto",
    "pending_requests",
    "standing_veto",
    "urgency_rank",
    "veto_reason",
]

# So many of the best are looked at each time.
MOST_LOOKED_AT = 300
_NO_PLACE = "places of bodies need the extra `observatory` at the gateway (pyerfa)"
_RANK = {Urgency.NORMAL: 0, Urgency.TIME_CRITICAL: 1, Urgency.RAPID_RESPONSE: 2}


class AskedRequest(NamedTuple):
    """A request with what its group says of it."""

    request: Request
    priority: float
    urgency: Urgency
    # Requests of its sequence that come before it.
    after: tuple[str, ...] = ()
    # Who pays.
    proposal: str = ""


class NightLimits(NamedTuple):
    """What a night may do at all; see `talaia.model.night_section.NightSection`.

    Attributes:
        place: of the telescope.
        instrument: how long it takes.
        observing_sun: targets are observed at or below this altitude of the Sun (°).
        filters: that there are.
        left: block time that each proposal has left (s); one that is not named has none. None:
            nobody has said.

    """

    place: Place
    instrument: Instrument
    observing_sun: float
    filters: frozenset[str]
    left: Mapping[str, float] | None = None


def pending_requests(groups: Iterable[RequestGroup]) -> Iterator[AskedRequest]:
    """List what may be planned."""
    for group in groups:
        before: list[str] = []
        for request in group.requests:
            if request.state is RequestState.PENDING:
                after = tuple(before) if group.operator is GroupOperator.SEQUENCE else ()
                yield AskedRequest(request, group.priority, group.urgency, after, group.proposal)
            if request.state is not RequestState.COMPLETED:
                before.append(request.id)


def frames_left(request: Request, done: tuple[int, ...]) -> list[int]:
    """Give how many frames of each configuration are still to be taken."""
    # Nothing was done yet, or the request has got a configuration since.
    counts = [*done, *([0] * len(request.configurations))]
    return [max(0, c.count - counts[i]) for i, c in enumerate(request.configurations)]


def block_seconds(request: Request, done: tuple[int, ...], instrument: Instrument) -> float:
    """Give how long the rest of a request takes, without the slew (s)."""
    left = frames_left(request, done)
    configurations = list(zip(request.configurations, left, strict=True))
    frames = sum(n * (c.exposure + instrument.readout) for c, n in configurations)
    return frames + instrument.filter_change * sum(1 for _, n in configurations if n)


def hours_veto(
    asked: AskedRequest,
    done: tuple[int, ...],
    instrument: Instrument,
    left: Mapping[str, float] | None,
) -> str:
    """Say that a proposal cannot pay the frames that are left; empty: it can, or nobody has said.

    Of filters, which are known when they turn, it asks no more than a planner does.
    """
    request = asked.request
    parts = zip(request.configurations, frames_left(request, done), strict=True)
    seconds = sum(count * (part.exposure + instrument.readout) for part, count in parts)
    if left is None or seconds <= left.get(asked.proposal, 0.0) + 1.0:
        return ""
    minutes = max(0.0, left.get(asked.proposal, 0.0)) / 60.0
    return f"proposal {asked.proposal} has {minutes:.0f} min left, it needs {seconds / 60.0:.0f}"


def urgency_rank(asked: AskedRequest) -> int:
    """Give how urgent a request is beside others; more is more."""
    return _RANK[asked.urgency]


def standing_veto(
    asked: AskedRequest,
    time: float,
    seconds: float,
    *,
    done: tuple[int, ...] = (),
    ended: frozenset[str] = frozenset(),
    held_until: float = 0.0,
    slack: float = 0.0,
) -> str:
    """Say why a request of so many seconds may not begin at a time, whatever the sky is like.

    The other arguments are those of `veto_reason`.
    """
    request = asked.request
    if request.id in ended or not any(frames_left(request, done)):
        return "nothing of it is left"
    if waits := [name for name in asked.after if name not in ended]:
        return f"{waits[0]} of its sequence comes before it"
    if time < held_until:
        return "it has just failed or been interrupted"
    early, late = time + 60 * slack, time + seconds - 60 * slack
    if not any(window.start <= early and late <= window.end for window in request.windows):
        return "it is not in its window, or does not fit into what is left of it"
    return ""


def veto_reason(
    asked: AskedRequest,
    view: NightView,
    limits: NightLimits,
    *,
    done: tuple[int, ...] = (),
    ended: frozenset[str] = frozenset(),
    held_until: float = 0.0,
    slack: float = 0.0,
) -> str:
    """Say why a request may not be observed now; empty when it may.

    Args:
        asked: the request.
        view: how things stand.
        limits: of the observatory.
        done: frames of each configuration that there are.
        ended: requests that have ended at this gateway.
        held_until: it is not tried again before (s since the epoch, UTC).
        slack: of another's reckoning: so many degrees, and minutes, are let pass.

    """
    request = asked.request
    seconds = block_seconds(request, done, limits.instrument)
    # What costs no look at the sky comes first.
    if why := standing_veto(
        asked,
        view.time,
        seconds,
        done=done,
        ended=ended,
        held_until=held_until,
        slack=slack,
    ):
        return why
    if why := hours_veto(asked, done, limits.instrument, limits.left):
        return why
    ends = view.time + seconds
    for configuration in request.configurations:
        if configuration.type is not ImageType.LIGHT:
            return f"{configuration.type} frames are not taken of a target under the night's sky"
        if configuration.filter and configuration.filter not in limits.filters:
            return f"there is no filter {configuration.filter!r}"
    return _sky_veto(request, view, limits, ends=ends, slack=slack)


def conditions_veto(rule: Constraints, view: NightView) -> str:
    """Say what is measured, or should be, and keeps a request waiting; empty: nothing."""
    if rule.max_clouds is not None:
        if view.clouds is None and "clouds" in view.unread:
            return f"nobody knows how cloudy it is; it allows {rule.max_clouds:.0f} %"
        if view.clouds is not None and not view.clouds <= rule.max_clouds:
            return f"clouds cover {view.clouds:.0f} %, it allows {rule.max_clouds:.0f} %"
    if rule.max_seeing is not None:
        if view.seeing is None and "seeing" in view.unread:
            return f"nobody knows the seeing; it allows {rule.max_seeing:.1f}″"
        if view.seeing is not None and not view.seeing <= rule.max_seeing:
            return f"the seeing is {view.seeing:.1f}″, it allows {rule.max_seeing:.1f}″"
    return ""


def _sky_veto(
    request: Request, view: NightView, limits: NightLimits, *, ends: float, slack: float
) -> str:
    rule = request.constraints
    if view.sun > min(rule.max_sun_altitude, limits.observing_sun) + slack:
        return f"the Sun stands at {view.sun:.1f}°"
    if why := conditions_veto(rule, view):
        return why
    if rule.phase is not None:
        phase = (view.time - rule.phase.epoch) / rule.phase.period % 1.0
        inside = rule.phase.start <= phase <= rule.phase.end
        if rule.phase.end < rule.phase.start:
            inside = phase >= rule.phase.start or phase <= rule.phase.end
        if not inside:
            return f"its phase is {phase:.2f}"
    for time in (view.time, ends):
        # Between two moments a target is lowest at one of them, except around its lower
        # culmination, where hardly anything is allowed.
        where = place_of_date(request.target, time, limits.place)
        if where is None:
            return _NO_PLACE if request.target is not None else "it has no target"
        if why := _place_veto(rule, where, limits, time=time, slack=slack):
            return why
    return ""


def _place_veto(
    rule: Constraints, where: EquatorialPlace, limits: NightLimits, *, time: float, slack: float
) -> str:
    # NaN, of a place that cannot be reckoned, is a veto: the comparison is written so.
    altitude = altitude_of(where, limits.place, time)
    lowest = max(rule.min_altitude, limits.instrument.horizon)
    if not altitude >= lowest - slack:
        return f"it stands at {altitude:.0f}°, below {lowest:.0f}°"
    if 1.0 / math.sin(math.radians(max(altitude + slack, 0.1))) > rule.max_airmass:
        return "its airmass is too great"
    hours = hour_angle_of(where, limits.place, time)
    if rule.max_hour_angle is not None and abs(hours) > rule.max_hour_angle + slack / 15.0:
        return "it is too far from the meridian"
    return ""


def _minds_moon(rule: Constraints) -> bool:
    return rule.min_moon_distance > 0 or rule.max_moon_illumination < 1


def best_request(
    asked: Iterable[AskedRequest],
    view: NightView,
    limits: NightLimits,
    *,
    done: Mapping[str, tuple[int, ...]],
    ended: frozenset[str],
    held: Mapping[str, float],
) -> AskedRequest | None:
    """Give what is worth most now: the most urgent, then the highest priority, the shortest."""
    open_now = [
        one
        for one in asked
        if not _minds_moon(one.request.constraints)
        and any(window.start <= view.time < window.end for window in one.request.windows)
    ]

    def rank(one: AskedRequest) -> tuple[float, ...]:
        seconds = block_seconds(one.request, done.get(one.request.id, ()), limits.instrument)
        # The shortest first: more of them are done before something closes the roof.
        return -_RANK[one.urgency], -one.priority, seconds

    # Bounded: this runs where robots are driven and roofs are guarded.
    for one in heapq.nsmallest(MOST_LOOKED_AT, open_now, key=rank):
        name = one.request.id
        until = held.get(name, 0.0)
        if not veto_reason(
            one, view, limits, done=done.get(name, ()), ended=ended, held_until=until
        ):
            return one
    return None
