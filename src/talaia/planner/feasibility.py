"""When each visit may be observed: every constraint at every minute, and what follows for starts.

A block may begin at second ``s`` if all marks from the one before it to the one after its end are
allowed by one window: what holds at two marks is taken to hold between them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from talaia.planner.sky import MARK_S, Floats

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from talaia.planner.night_problem import Ints, NightProblem, Visit

__all__ = ["NEVER", "Feasibility", "constraint_masks"]

Bools = NDArray[np.bool_]

# A start that does not come in this night (s).
NEVER = 1 << 28
_NO_MARK = np.int16(32_000)
# Of altitudes and Moon distances (sine of an angle; 0.001°), and of the Sun (°): who judges a block
# by a sky of other make finds other last digits, and a block that is refused is an idle telescope.
_GRAIN = 2e-5
_SUN_GRAIN = 0.01
# Rows whose sky is worked out at a time, so that what lies between stays in the cache.
_ROWS = 1024


class Feasibility:
    """The allowed marks of each visit, and from them its possible starts.

    Attributes:
        allowed: by sky, Moon, Sun, phase, without windows (visits × marks).
        run_end: last mark to which a block that begins at a mark may reach; -1: none.

    """

    def __init__(self, problem: NightProblem) -> None:
        """Work out all visits of a problem."""
        self._problem = problem
        marks = len(problem.sky.unix)
        self.marks = marks
        self.allowed: Bools = np.zeros((0, marks), np.bool_)
        self.run_end: NDArray[np.int16] = np.zeros((0, marks), np.int16)
        self._latest: NDArray[np.int32] = np.zeros((0, marks + 1), np.int32)
        self._next_mark: NDArray[np.int16] = np.zeros((0, marks + 1), np.int16)
        self.add_rows()

    def add_rows(self) -> None:
        """Work out the visits that were added to the problem since."""
        first, last = len(self.allowed), len(self._problem.table)
        pieces = [
            self._compute_rows(range(begin, min(begin + _ROWS, last)))
            for begin in range(first, last, _ROWS)
        ]
        if pieces:
            allowed, run_end, latest, next_mark = zip(*pieces, strict=True)
            self.allowed = np.concatenate([self.allowed, *allowed])
            self.run_end = np.concatenate([self.run_end, *run_end])
            self._latest = np.concatenate([self._latest, *latest])
            self._next_mark = np.concatenate([self._next_mark, *next_mark])

    def update_block(self, row: int) -> None:
        """Work out a visit's starts anew after its block has become shorter."""
        block = self._problem.table.block_s[row : row + 1]
        latest, next_mark = _starts(self.run_end[row : row + 1], block)
        self._latest[row], self._next_mark[row] = latest[0], next_mark[0]

    def earliest_starts(self, rows: Ints, seconds: Ints) -> Ints:
        """Give the first possible start of each row at or after a second; `NEVER` if none.

        ``rows`` and ``seconds`` are broadcast against each other.
        """
        mark = np.clip(seconds // MARK_S, 0, self.marks - 1)
        width = self.marks + 1
        here = rows * width + mark
        at_once = (seconds <= self._latest.take(here)) & (seconds >= 0)
        later = self._next_mark.take(here + 1).astype(np.int64)
        boundary = np.where(later == _NO_MARK, NEVER, later * MARK_S)
        # Before the night the first mark itself counts.
        boundary = np.where(seconds < 0, self._boundary(rows), boundary)
        return np.where(at_once, seconds, boundary)

    def _boundary(self, rows: Ints) -> Ints:
        first = self._next_mark[rows, 0].astype(np.int64)
        return np.where(first == _NO_MARK, NEVER, first * MARK_S)

    def may_start(self, row: int, second: int) -> bool:
        """Tell whether a visit's block may begin at a second."""
        mark = second // MARK_S
        return 0 <= mark < self.marks and second <= int(self._latest[row, mark])

    def lasts_until(self, rows: Ints, starts: Ints, longer: Ints) -> Bools:
        """Tell whether blocks that begin at possible starts may be so much longer (s)."""
        mark = np.clip(starts // MARK_S, 0, self.marks - 1)
        return np.asarray(starts + longer <= self._latest.take(rows * (self.marks + 1) + mark))

    def next_start(self, row: int, second: int) -> int:
        """Give a visit's first possible start at or after a second; `NEVER` if none."""
        return int(self.earliest_starts(np.array([row]), np.array([second]))[0])

    def startable(self, rows: Ints, marks: Ints) -> NDArray[np.int16]:
        """Give the next mark with a possible start (rows × marks); at least 32 000: none."""
        return np.asarray(self._next_mark[rows[:, None], marks[None, :]])

    def _compute_rows(
        self, rows: range
    ) -> tuple[Bools, NDArray[np.int16], NDArray[np.int32], NDArray[np.int16]]:
        visits = self._problem.table.visits[rows.start : rows.stop]
        allowed = np.ones((len(visits), self.marks), np.bool_)
        for _, mask in constraint_masks(self._problem, visits):
            allowed &= mask
        run_end = _run_ends(allowed, visits)
        block = self._problem.table.block_s[rows.start : rows.stop]
        return allowed, run_end, *_starts(run_end, block)


def constraint_masks(problem: NightProblem, visits: Sequence[Visit]) -> list[tuple[str, Bools]]:
    """Give what each constraint allows (visits × marks), by its name, in the order of reasons.

    The names are those of `talaia.model.observing.plan.VetoCause`.
    """
    sky, instrument = problem.sky, problem.instrument
    floor = _column(max(visit.min_altitude, instrument.horizon) for visit in visits)
    airmass = _column(visit.max_airmass for visit in visits)
    sun_limit = _column(visit.max_sun_altitude for visit in visits)
    moon_distance = _column(visit.min_moon_distance for visit in visits)
    moon_lit = _column(visit.max_moon_illumination for visit in visits)
    hour_limit = _column(visit.max_hour_angle for visit in visits)
    indoors = np.array([not visit.needs_sky for visit in visits])[:, None]
    directions = sky.star_directions(
        np.array([visit.ra for visit in visits]), np.array([visit.dec for visit in visits])
    ).astype(np.float32)
    moving = {row: visit.track for row, visit in enumerate(visits) if visit.track is not None}
    sine = directions @ sky.zenith.astype(np.float32)
    to_moon = directions @ sky.moon.astype(np.float32)
    for row, track in moving.items():
        sine[row] = (track * sky.zenith).sum(0)
        to_moon[row] = (track * sky.moon).sum(0)
    moon_down = (sky.moon_altitude <= 0.0)[None, :]
    masks = [
        ("sun", (sky.sun_altitude[None, :] <= sun_limit - _SUN_GRAIN) | indoors),
        ("altitude", (sine >= np.sin(np.radians(floor)).astype(np.float32) + _GRAIN) | indoors),
        ("airmass", (sine >= (1.0 / airmass).astype(np.float32) + _GRAIN) | indoors),
        (
            "moon_illumination",
            (sky.moon_illumination[None, :] <= moon_lit) | moon_down | indoors,
        ),
        (
            "moon_distance",
            (to_moon <= np.cos(np.radians(moon_distance)).astype(np.float32) - _GRAIN)
            | (moon_distance <= 0.0)
            | moon_down
            | indoors,
        ),
    ]
    if instrument.horizon_mask:
        azimuth = sky.azimuths(directions.astype(np.float64))
        for row, track in moving.items():
            azimuth[row] = sky.track_azimuths(track)
        lowest = _mask_altitudes(instrument.horizon_mask, azimuth)
        masks.append(("horizon", (sine >= np.sin(np.radians(lowest))) | indoors))
    if (hour_limit < 12.0).any():
        right = np.arctan2(directions[:, 1], directions[:, 0])[:, None].astype(np.float64)
        right = np.broadcast_to(right, sine.shape).copy()
        for row, track in moving.items():
            right[row] = np.arctan2(track[1], track[0])
        angle = np.degrees(sky.sidereal[None, :] - right) / 15.0
        masks.append(("hour_angle", (np.abs((angle + 12.0) % 24.0 - 12.0) <= hour_limit) | indoors))
    if any(visit.phase is not None for visit in visits):
        masks.append(("phase", np.stack([_phase_mask(visit, sky.unix) for visit in visits])))
    return masks


def _column(values: Iterable[float]) -> Floats:
    return np.array(list(values), np.float64)[:, None]


def _mask_altitudes(points: tuple[tuple[float, float], ...], azimuth: Floats) -> Floats:
    """Interpolate a horizon of azimuths and altitudes (°) round the compass."""
    ordered = sorted(points)
    return np.interp(
        azimuth, [place for place, _ in ordered], [high for _, high in ordered], period=360.0
    )


def _phase_mask(visit: Visit, unix: Floats) -> Bools:
    wanted = visit.phase
    if wanted is None:
        return np.ones(len(unix), np.bool_)
    phase = ((unix - wanted.epoch) / wanted.period) % 1.0
    if wanted.start <= wanted.end:
        return np.asarray((phase >= wanted.start) & (phase <= wanted.end))
    return np.asarray((phase >= wanted.start) | (phase <= wanted.end))


def _run_ends(allowed: Bools, visits: Sequence[Visit]) -> NDArray[np.int16]:
    """Give the last mark of each run of allowed marks inside one window; -1 where none is."""
    count, marks = allowed.shape
    numbers = np.arange(marks, dtype=np.int16)
    # The mark before the next that is not allowed.
    blocked = np.where(allowed, np.int16(marks), numbers)
    ends = np.minimum.accumulate(blocked[:, ::-1], axis=1)[:, ::-1] - np.int16(1)
    inside = np.full((count, marks), -1, np.int16)
    for row, visit in enumerate(visits):
        for begin, end in visit.windows:
            first, last = max(0, math.ceil(begin / MARK_S)), min(marks - 1, end // MARK_S)
            if first <= last:
                part = inside[row, first : last + 1]
                np.maximum(part, np.int16(last), out=part)
    return np.where(allowed, np.minimum(ends, inside), np.int16(-1)).astype(np.int16)


def _starts(
    run_end: NDArray[np.int16], block_s: Ints
) -> tuple[NDArray[np.int32], NDArray[np.int16]]:
    """Give the latest start in each mark's run (s), and the next mark at which one may start.

    Both have one column more than there are marks, in which nothing starts.
    """
    count, marks = run_end.shape
    latest = np.full((count, marks + 1), -1, np.int32)
    latest[:, :-1] = run_end.astype(np.int32) * MARK_S - block_s[:, None].astype(np.int32)
    numbers = np.arange(marks, dtype=np.int32)
    latest[:, :-1][run_end < 0] = -1
    can = latest[:, :-1] >= numbers * MARK_S
    latest[:, :-1][~can & (latest[:, :-1] < numbers * MARK_S)] = -1
    following = np.full((count, marks + 1), _NO_MARK, np.int16)
    here = np.where(can, numbers.astype(np.int16), _NO_MARK)
    following[:, :-1] = np.minimum.accumulate(here[:, ::-1], axis=1)[:, ::-1]
    return latest, following
