"""When a request can be observed, and if never, why: said before anybody hands it in. Pure.

Sky and constraints are the planner's own, so that what is promised here is what is planned later.
Weather is not in it. Times are seconds since the epoch (UTC), angles degrees.
"""

from __future__ import annotations

import datetime as dt
import math
from collections import OrderedDict
from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from talaia.model.observing.requests import Request, RequestGroup, Window
from talaia.model.observing.states import RequestState
from talaia.planner.feasibility import Feasibility, constraint_masks
from talaia.planner.from_requests import visits_of
from talaia.planner.night_problem import NightProblem
from talaia.planner.sky import MARK_S, compute_sky, find_night

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from zoneinfo import ZoneInfo

    from talaia.model.observing.plan import Instrument
    from talaia.planner.feasibility import Bools
    from talaia.planner.night_problem import Visit
    from talaia.planner.sky import Floats, NightSky, TelescopePlace

__all__ = ["NightSkies", "RequestOutlook", "SkyCurve", "request_outlook"]

_DAY = 86_400.0
# Nights of the windows that are looked at; of more, every so many-th.
_MOST_NIGHTS = 30
# A better time is looked for in the year to come, every so many nights.
_YEAR_STEP = 10
_CURVE_S = 600
_PAYS = "p"


class SkyCurve(NamedTuple):
    """A night for a chart, every ten minutes: altitudes (°), and whether all constraints hold."""

    times: list[float]
    altitude: list[float]
    sun_altitude: list[float]
    moon_altitude: list[float]
    allowed: list[bool]


class RequestOutlook(NamedTuple):
    """When a request can be observed.

    Attributes:
        nights: of its windows that were looked at.
        possible: of these it can be observed in.
        best: a good time to begin; none: never in its windows.
        sentence: the same in words.
        curve: of the best night, else of the first; none: there is no night.

    """

    nights: int
    possible: int
    best: float | None
    sentence: str
    curve: SkyCurve | None


class NightSkies:
    """Nights of one place; those that were asked for last are kept, as people type on."""

    def __init__(self, place: TelescopePlace, most: int = 80) -> None:
        """Keep up to ``most`` nights, of some 100 kB each."""
        self._place = place
        self._most = most
        # By the day in which somebody asked.
        self._kept: OrderedDict[int, tuple[float, int, NightSky]] = OrderedDict()

    def find_sky(self, time: float) -> tuple[float, int, NightSky]:
        """Give start, length (s) and sky of the night at ``time`` or the next."""
        day = math.floor(time / 3600.0)
        if day in self._kept:
            self._kept.move_to_end(day)
            return self._kept[day]
        start, length = find_night(self._place, time)
        found = start, length, compute_sky(self._place, start, max(length, MARK_S))
        self._kept[day] = found
        if len(self._kept) > self._most:
            self._kept.popitem(last=False)
        return found


class _Night(NamedTuple):
    """What one night is for a request."""

    start: float
    sky: NightSky
    altitude: Floats
    # At which marks its block may begin.
    starts: Bools
    masks: list[tuple[str, Bools]]
    inside: Bools

    @property
    def score(self) -> tuple[int, float]:
        """The more time there is, the better; then the higher."""
        high = float(self.altitude[self.starts].max()) if self.starts.any() else -90.0
        return int(self.starts.sum()), high


def request_outlook(
    skies: NightSkies, request: Request, instrument: Instrument, *, now: float, zone: ZoneInfo
) -> RequestOutlook:
    """Work out when a request can be observed from now on.

    Args:
        skies: of the telescope's place.
        request: what is asked; its state does not matter.
        instrument: what takes how long.
        now: nothing is observed before (s since the epoch, UTC).
        zone: in which dates and times are said.

    """
    begin = max(now, min(window.start for window in request.windows))
    end = max(window.end for window in request.windows)
    nights = list(_nights(skies, request, instrument, (begin, end), now=now))
    # A night in which no window is open is none of its nights.
    nights = [night for night in nights if night.inside.any()]
    good = [night for night in nights if night.starts.any()]
    if not good:
        sentence = _never(nights, request, instrument)
        better = _best_of_year(skies, request, instrument, now)
        if better is None:
            sentence += "; nor is it in the year to come"
        else:
            sentence += f"; best on {_date(better.start, zone, now)}"
        curve = _curve(better or nights[0]) if better or nights else None
        return RequestOutlook(len(nights), 0, None, sentence, curve)
    best = max(good, key=lambda night: night.score)
    mark = int(np.argmax(np.where(best.starts, best.altitude, -90.0)))
    time = float(best.sky.unix[mark])
    said = "" if len(nights) == 1 else f" in {len(good)} of {len(nights)} nights looked at"
    high = f", at {best.altitude[mark]:.0f}°" if request.target is not None else ""
    sentence = (
        # Of the time itself: a night has the date of its evening, and 01:13 is another day.
        f"can be observed{said}; best on {_date(time, zone, now)}"
        f" about {dt.datetime.fromtimestamp(time, zone):%H:%M}{high}"
    )
    return RequestOutlook(len(nights), len(good), time, sentence, _curve(best))


def _nights(
    skies: NightSkies,
    request: Request,
    instrument: Instrument,
    span: tuple[float, float],
    *,
    now: float,
) -> Iterator[_Night]:
    """Look at the nights between two times, at up to `_MOST_NIGHTS` of them."""
    begin, end = span
    step = max(1, math.ceil((end - begin) / _DAY / _MOST_NIGHTS)) * _DAY
    time, last = begin, -1.0
    while time < end:
        night = _night(skies, request, instrument, time, now=now)
        # Asked for twice where the first time was in it already.
        if night is not None and night.start > last:
            last = night.start
            yield night
        time += step


def _night(
    skies: NightSkies, request: Request, instrument: Instrument, time: float, *, now: float
) -> _Night | None:
    start, length, sky = skies.find_sky(time)
    if length <= 0:
        return None
    # What is over does not count.
    windows = tuple(
        Window(start=max(window.start, now), end=window.end)
        for window in request.windows
        if window.end > now
    )
    if not windows:
        return None
    asked = msgspec.structs.replace(
        request, state=RequestState.PENDING, windows=windows, frames_done=(), failures=0
    )
    problem = NightProblem(start=start, length_s=length, sky=sky, instrument=instrument)
    group = RequestGroup(id="g", proposal=_PAYS, requests=(asked,))
    problem.add_visits(visits_of(problem, (group,)))
    (visit,) = problem.table.visits
    feasibility = Feasibility(problem)
    marks = np.arange(len(sky.unix))
    starts = feasibility.startable(np.array([0]), marks)[0] == marks
    inside = np.zeros(len(marks), np.bool_)
    for window in windows:
        inside |= (sky.unix >= window.start) & (sky.unix <= window.end)
    masks = [(name, mask[0]) for name, mask in constraint_masks(problem, [visit])]
    return _Night(start, sky, _altitudes(sky, visit), starts, masks, inside)


def _altitudes(sky: NightSky, visit: Visit) -> Floats:
    if visit.track is not None:
        sine = (visit.track * sky.zenith).sum(0)
    else:
        sine = (sky.star_directions(np.array([visit.ra]), np.array([visit.dec])) @ sky.zenith)[0]
    return np.asarray(np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0))))


def _never(nights: Sequence[_Night], request: Request, instrument: Instrument) -> str:
    """Say what keeps a request from being observed in all of its nights: the first that does."""
    if not nights:
        return "there is no night in its windows"
    left = [night.inside.copy() for night in nights]
    for at, (name, _) in enumerate(nights[0].masks):
        before = [mask.copy() for mask in left]
        for mask, night in zip(left, nights, strict=True):
            mask &= night.masks[at][1]
        if not any(mask.any() for mask in left):
            seen = np.concatenate(
                [night.altitude[mask] for night, mask in zip(nights, before, strict=True)]
            )
            high = float(seen.max()) if seen.size else -90.0
            return _in_words(name, request, instrument, high)
    longest = round(max(_longest_run(mask) for mask in left) * MARK_S / 60.0)
    minutes = "1 minute" if longest == 1 else f"{longest} minutes"
    return f"it does not fit: its windows leave {minutes} at a time at the most"


def _in_words(cause: str, request: Request, instrument: Instrument, high: float) -> str:
    limits = request.constraints
    floor = max(limits.min_altitude, instrument.horizon)
    match cause:
        case "sun":
            return f"the Sun is never below {limits.max_sun_altitude:g}° in its windows"
        case "altitude":
            return f"never above {floor:g}° in its windows ({high:.0f}° at the most)"
        case "airmass":
            return (
                f"its airmass is never below {limits.max_airmass:g} in its windows"
                f" ({high:.0f}° at the most)"
            )
        case "moon_illumination":
            return f"the Moon is always lit by more than {limits.max_moon_illumination:.0%}"
        case "moon_distance":
            return f"the Moon is always nearer than {limits.min_moon_distance:g}°"
        case "hour_angle":
            return f"never within {limits.max_hour_angle:g} h of the meridian while it may be seen"
        case "phase":
            return "its phase never comes in a night of its windows"
        case _:
            return "always behind the horizon's mask"


def _best_of_year(
    skies: NightSkies, request: Request, instrument: Instrument, now: float
) -> _Night | None:
    """Look for a night of the year to come in which its windows alone keep it from being seen."""
    year = (now, now + 366.0 * _DAY)
    free = msgspec.structs.replace(request, windows=(Window(start=year[0], end=year[1] + _DAY),))
    found = None
    for at in range(0, 366, _YEAR_STEP):
        night = _night(skies, free, instrument, now + at * _DAY, now=now)
        if night is not None and night.starts.any() and (not found or night.score > found.score):
            found = night
    return found


def _longest_run(mask: Bools) -> int:
    longest = run = 0
    for allowed in mask:
        run = run + 1 if allowed else 0
        longest = max(longest, run)
    return longest


def _curve(night: _Night) -> SkyCurve:
    some = slice(None, None, _CURVE_S // MARK_S)
    allowed = night.inside.copy()
    for _, mask in night.masks:
        allowed &= mask
    return SkyCurve(
        times=[float(time) for time in night.sky.unix[some]],
        altitude=[round(float(angle), 2) for angle in night.altitude[some]],
        sun_altitude=[round(float(angle), 2) for angle in night.sky.sun_altitude[some]],
        moon_altitude=[round(float(angle), 2) for angle in night.sky.moon_altitude[some]],
        allowed=[bool(holds) for holds in allowed[some]],
    )


def _date(time: float, zone: ZoneInfo, now: float) -> str:
    day = dt.datetime.fromtimestamp(time, zone)
    year = "" if day.year == dt.datetime.fromtimestamp(now, zone).year else f" {day.year}"
    return f"{day.day} {day:%B}{year}"
