"""A focus run as a state machine: where to go next, when it is done, when to give up. Pure.

Positions are approached from the outside (from higher to lower numbers), so that the play of the
screw is always used up in the same way; before the first one, and before the last move to the best
position, it goes farther out and comes back.
"""

from __future__ import annotations

from typing import NamedTuple

from talaia.imaging.focus_fit import FocusFit, FocusPoint, fit_focus

__all__ = ["FocusRun", "FocusSettings", "FocusStep"]


class FocusSettings(NamedTuple):
    """How a run goes.

    Attributes:
        step: between two positions (steps).
        points: positions of the first round.
        play: it goes so much farther out before it comes in (steps); more than the screw's play.
        most: positions in all, before it gives up.
        lowest: of the focuser (steps).
        highest: of the focuser (steps).

    """

    step: float = 60.0
    points: int = 7
    play: float = 100.0
    most: int = 18
    lowest: float = 0.0
    highest: float = 50_000.0


class FocusStep(NamedTuple):
    """What comes next.

    Attributes:
        moves: positions to go to one after the other (steps).
        measure: then a picture is taken and its stars are measured; without, the run has ended.
        problem: why it failed; empty while it goes on and when it is done. After a failure the
            moves lead back to where it began.

    """

    moves: tuple[float, ...]
    measure: bool
    problem: str = ""


class FocusRun:
    """One run.

    Attributes:
        points: what was measured so far.
        fit: of all points; of no use before the run has ended.

    """

    def __init__(self, start: float, settings: FocusSettings | None = None) -> None:
        """Begin around a position (steps)."""
        self.settings = settings or FocusSettings()
        self.points: list[FocusPoint] = []
        self.fit = FocusFit(problem="nothing was measured")
        self._start = start
        half = self.settings.step * (self.settings.points - 1) / 2
        self._wanted = self._row(start + half, self.settings.points)
        self._last: float | None = None

    def next_step(self) -> FocusStep:
        """Say where to go; ask again after `add_measurement`."""
        if self._wanted:
            return FocusStep(self._way_to(self._wanted[0]), measure=True)
        self.fit = fit_focus(self.points)
        if not self.fit.problem:
            return FocusStep(self._way_to(self.fit.position), measure=False)
        if self.fit.side and len(self.points) < self.settings.most:
            self._look_on(self.fit.side)
            if self._wanted:
                return FocusStep(self._way_to(self._wanted[0]), measure=True)
        return FocusStep(self._way_to(self._start), measure=False, problem=self.fit.problem)

    def add_measurement(self, hfr: float, stars: int) -> None:
        """Hear what was measured at the position that `next_step` said."""
        position = self._wanted.pop(0)
        self._last = position
        self.points.append(FocusPoint(position, hfr, stars))

    def _look_on(self, side: int) -> None:
        """Add positions beyond the end towards which stars get smaller."""
        tried = [point.position for point in self.points]
        step, more = self.settings.step, min(4, self.settings.most - len(self.points))
        first = max(tried) + step * more if side > 0 else min(tried) - step
        self._wanted = self._row(first, more)

    def _row(self, first: float, count: int) -> list[float]:
        row = [first - self.settings.step * index for index in range(count)]
        return [at for at in row if self.settings.lowest <= at <= self.settings.highest]

    def _way_to(self, position: float) -> tuple[float, ...]:
        if self._last is not None and position < self._last:
            return (position,)
        return (min(self.settings.highest, position + self.settings.play), position)
