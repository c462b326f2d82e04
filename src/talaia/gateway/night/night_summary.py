"""What became of one night, in a few lines for people in the morning. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import NightEvent, ObservationChange
from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.model.observing.targets import target_name
from talaia.wire.frames import NightPhase

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.gateway.night.night_values import NightAction, NightView
    from talaia.model.night_section import NightSection
    from talaia.model.observing.requests import Request

__all__ = ["NightReport", "NightSummary"]

# More names, or events, than anybody reads.
_MOST_NAMED = 12
_OPEN = frozenset({NightPhase.OPENING, NightPhase.OBSERVING})
_AT_REST = frozenset({NightPhase.DISARMED, NightPhase.FAULT, NightPhase.WAITING})


@dataclass
class _Tried:
    """What became of a request in this night."""

    name: str
    # Frames that there were when it was begun, and that there are.
    first: int = 0
    frames: int = 0
    state: ObservationState = ObservationState.IN_PROGRESS
    why: str = ""


class NightSummary:
    """Counts from the evening to the morning."""

    def __init__(self, began: float) -> None:
        """Begin at ``began`` (s since the epoch, UTC)."""
        self._last, self._open_s = began, 0.0
        # In the order in which they were begun.
        self._tried: dict[str, _Tried] = {}
        self._closed_for: list[str] = []
        # What somebody should look at, each once.
        self._bad: dict[str, None] = {}

    def pass_time(self, now: float, phase: NightPhase) -> None:
        """Take in in which phase the time until ``now`` (s since the epoch, UTC) was spent."""
        if phase in _OPEN:
            self._open_s += max(0.0, now - self._last)
        self._last = now

    def add_actions(self, actions: Iterable[NightAction], request: Request | None) -> None:
        """Take in what the night does; ``request`` is being observed."""
        for action in actions:
            if isinstance(action, ObservationChange):
                self._add_change(action, request)
            elif isinstance(action, NightEvent) and not action.good:
                self._bad[action.message] = None

    def _add_change(self, change: ObservationChange, request: Request | None) -> None:
        known = request is not None and request.id == change.request and request.target is not None
        frames = sum(change.frames_done)
        name = target_name(request.target) if known else change.request  # type: ignore[union-attr,arg-type]
        tried = self._tried.setdefault(change.request, _Tried(name, first=frames))
        if known:
            tried.name = name
        tried.frames, tried.state, tried.why = frames, change.state, change.why
        if change.cause is SuspensionCause.WEATHER and change.why:
            self._closed_for.append(change.why)

    def summary_text(self) -> str:
        """Give it in one paragraph."""
        done = [one for one in self._tried.values() if one.state is ObservationState.COMPLETED]
        rest = [one for one in self._tried.values() if one not in done]
        frames = sum(max(0, one.frames - one.first) for one in self._tried.values())
        parts = [f"{_count(len(done), 'request')} observed, {_count(frames, 'frame')}"]
        if done:
            parts[0] += ": " + _named([one.name for one in done])
        parts.append(
            f"open for {_hours(self._open_s)}" if self._open_s >= 1.0 else "it was never open"
        )
        if self._closed_for:
            reasons = list(dict.fromkeys(self._closed_for))
            parts.append(f"broken off {_count(len(self._closed_for), 'time')}: {_named(reasons)}")
        if rest:
            parts.append(
                "not finished: "
                + _named([f"{one.name} ({one.why})" if one.why else one.name for one in rest])
            )
        if self._bad:
            parts.append("to look at: " + _named(list(self._bad)))
        return "; ".join(parts)

    @property
    def is_good(self) -> bool:
        """Tell whether there is nothing that somebody should look at."""
        return not self._bad


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"


def _named(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    shown = ", ".join(names[:_MOST_NAMED])
    return f"{shown} and {more} more" if more > 0 else shown


def _hours(seconds: float) -> str:
    minutes = round(seconds / 60.0)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes} min"


class NightReport:
    """Sums up each night that it is armed in, and tells of it when the night is over."""

    def __init__(self, night: NightSection) -> None:
        """Sum up nights between the Sun's altitudes of the description."""
        self._sun = night.sun
        # From the dark evening on in which it is armed, until the morning is told of it.
        self._summary: NightSummary | None = None

    def pass_time(
        self,
        view: NightView,
        actions: Iterable[NightAction],
        *,
        request: Request | None,
        is_armed: bool,
        phases: tuple[NightPhase, NightPhase],
    ) -> list[NightEvent]:
        """Count what the night does; give the summary when it is over.

        Args:
            view: how things stand.
            actions: what the night does now.
            request: what is being observed.
            is_armed: whether it runs by itself.
            phases: in which phase the time until now was spent, and that from now on.

        """
        if self._summary is None:
            if not is_armed or view.sun > self._sun.opening:
                return []
            self._summary = NightSummary(view.time)
        before, phase = phases
        self._summary.pass_time(view.time, before)
        self._summary.add_actions(actions, request)
        if phase not in _AT_REST or (is_armed and view.sun <= self._sun.closing):
            return []
        text, good = self._summary.summary_text(), self._summary.is_good
        self._summary = None
        return [NightEvent("night_ended", text, good=good)]
