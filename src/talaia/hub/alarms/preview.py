"""How often an alarm would have been raised over a window of history. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SECOND
from talaia.hub.alarms.condition_watch import ConditionTurn, ConditionWatch
from talaia.hub.alarms.conditions import AlarmCondition, ConditionReading, Truth

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from numpy.typing import NDArray

__all__ = ["Preview", "Span", "Track", "preview_alarm"]

# Beyond these they are counted, not listed.
_MOST_SPANS = 200
_US = 1_000_000


class Track(NamedTuple):
    """A channel's samples in order of time; the arrays have the shape (n,).

    Attributes:
        texts: position in the arrays to text.
        step_us: between two points that stand for all samples there lie at most so many µs.

    """

    time_us: NDArray[np.int64]
    value: NDArray[np.float64]
    texts: Mapping[int, str]
    step_us: int


@dataclass(frozen=True, slots=True)
class Span:
    """The alarm would have been active from then to then (µs, UTC)."""

    from_us: int
    to_us: int
    why: str


class Preview(NamedTuple):
    """What would have been.

    Attributes:
        spans: when it would have been active; the first ones, if there are very many.
        times: how often.
        unknown_us: for so long it could not have been judged.

    """

    spans: tuple[Span, ...]
    times: int
    unknown_us: int


def preview_alarm(
    condition: AlarmCondition, tracks: Mapping[str, Track], from_us: int, to_us: int
) -> Preview:
    """Let the samples of a window pass before a condition, with its delays."""
    # As if it had been off before: what was so then is not known.
    watch = ConditionWatch(condition.alarm, on=False)
    spans: list[Span] = []
    begun, why, count, unknown, last = 0, "", 0, 0, from_us
    for now_us, readings in _turning_moments(condition, tracks, from_us, to_us):
        # It could not be judged at the moment before this one, so not until now.
        if not watch.known:
            unknown += now_us - last
        last = now_us
        # Links and detectors are not in a preview: it counts as linked, and nothing is detected.
        verdict = condition.judge_condition(readings, (), held=watch.on, online=True)
        # Times of the history in place of a monotonic clock: only differences count.
        edge = watch.update_verdict(verdict, now_us * 1000)
        if edge is None:
            watch.known = verdict.truth is not Truth.UNKNOWN
        elif edge.turn is ConditionTurn.RAISE:
            begun, why, count = now_us, edge.why, count + 1
        elif len(spans) < _MOST_SPANS:
            spans.append(Span(begun, now_us, why))
    # It stands at the end of the window.
    if watch.on and len(spans) < _MOST_SPANS:
        spans.append(Span(begun, to_us, why))
    return Preview(tuple(spans), count, unknown)


def _turning_moments(
    condition: AlarmCondition, tracks: Mapping[str, Track], from_us: int, to_us: int
) -> Iterator[tuple[int, dict[str, ConditionReading]]]:
    """Go through the moments at which something may turn, with what was known at each."""
    alarm = condition.alarm
    # At a sample itself, and when a delay that begins there is over.
    pauses = {0, round(alarm.delay * _US), round(alarm.clear_delay * _US)}
    moments = {from_us, to_us}
    for address, track in tracks.items():
        # Between two points of a thinned track there may be samples that are not listed.
        longest = round(condition.longest_s(address) * _US) + track.step_us
        times = track.time_us
        # 1 µs after the value of a long gap becomes too old.
        ends = times[np.flatnonzero(np.diff(times, append=to_us) > longest)] + longest + 1
        for pause in pauses:
            moments.update((times + pause).tolist())
            moments.update((ends + pause).tolist())
    places = dict.fromkeys(tracks, 0)
    for now_us in sorted(moment for moment in moments if from_us <= moment <= to_us):
        readings = {}
        # The moments are in order, so each track is gone through once.
        for address, track in tracks.items():
            place = places[address]
            while place < len(track.time_us) and track.time_us[place] <= now_us:
                place += 1
            places[address] = place
            if place:
                # Up to one step of it may have passed with samples that are not listed.
                age = max(0, now_us - int(track.time_us[place - 1]) - track.step_us)
                readings[address] = ConditionReading(
                    float(track.value[place - 1]),
                    track.texts.get(place - 1, ""),
                    age * 1000 / SECOND,
                )
        yield now_us, readings
