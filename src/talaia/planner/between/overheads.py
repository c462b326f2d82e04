"""What stands between two blocks: slew, settling, centring, filter, dome, rotator, flip."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.observing.plan import MountAxes
from talaia.planner.sky import MARK_S

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.planner.night_problem import Ints, NightProblem
    from talaia.planner.sky import Floats

__all__ = ["PARKED", "TelescopePointing", "overhead_matrix", "overheads_from", "unpark_overhead"]

# Nearer than this is the same field (°, in right ascension and declination).
SAME_FIELD = 0.01
# The sine of a declination within 5° of a pole.
_NEAR_POLE = math.cos(math.radians(5.0))
# Where nobody knows how the camera stands: the mean of what may come (°).
_USUAL_TURN = 90.0


class TelescopePointing(NamedTuple):
    """Where a telescope points, and the filter that is in (an index); `PARKED`: nowhere.

    Attributes:
        ra: (°).
        dec: (°).
        filter: see above.
        angle: position angle to which the camera is turned (°); NaN: nobody knows.

    """

    ra: float
    dec: float
    filter: int
    angle: float = math.nan


PARKED: TelescopePointing | None = None


def unpark_overhead(problem: NightProblem) -> int:
    """Give what leads from the parked telescope to the first exposure (s)."""
    instrument = problem.instrument
    return int(np.ceil(instrument.unpark + instrument.settle + instrument.acquire))


def overheads_from(
    problem: NightProblem, pointing: TelescopePointing | None, rows: Ints, second: int
) -> Ints:
    """Give what leads from a pointing, at a second of the night, to each visit (s)."""
    if pointing is None:
        seconds = np.full(len(rows), unpark_overhead(problem), np.int64)
        seconds += _slews_from_park(problem, rows, second)
        seconds += _turning(problem, problem.table.angle[rows], np.array(math.nan))
        seconds[~problem.table.needs_sky[rows]] = 0
        return seconds
    table = problem.table
    between = _overheads(
        problem,
        np.abs(table.ra[rows] - pointing.ra),
        np.abs(table.dec[rows] - pointing.dec),
        _changes(table.filter_first[rows], np.array(pointing.filter)),
    )
    return between + _turning(problem, table.angle[rows], np.array(pointing.angle))


def _slews_from_park(problem: NightProblem, rows: Ints, second: int) -> Ints:
    """Give how long the telescope, and its dome, turn from the park to each visit (s).

    Nothing where nobody knows where it is parked: then all are equally far.
    """
    park, table, instrument = problem.park, problem.table, problem.instrument
    if park is None:
        return np.zeros(len(rows), np.int64)
    sky = problem.sky
    mark = min(max(second // MARK_S, 0), len(sky.unix) - 1)
    now = sky.at_mark(mark)
    directions = sky.star_directions(table.ra[rows], table.dec[rows])
    # What goes its own way is where it is at that moment.
    for place, row in enumerate(rows):
        track = table.visits[row].track
        if track is not None:
            directions[place] = track[:, mark]
    turn = _shortest(now.azimuths(directions)[:, 0] - park.azimuth)
    if instrument.mount is MountAxes.ALTAZIMUTH:
        altitude = np.degrees(np.arcsin(np.clip(directions @ now.zenith[:, 0], -1.0, 1.0)))
        angle = np.maximum(turn, np.abs(altitude - park.altitude))
    else:
        x, y, z = now.fixed_track(park.altitude, park.azimuth)[:, 0]
        across = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]) - np.arctan2(y, x))
        along = np.degrees(np.arcsin(np.clip(directions[:, 2], -1.0, 1.0)) - np.arcsin(z))
        # At the pole, where many are parked, no right ascension means anything.
        across = _shortest(across) if abs(z) < _NEAR_POLE else np.zeros_like(along)
        angle = np.maximum(across, np.abs(along))
    seconds = angle / instrument.slew_rate
    if instrument.dome_rate > 0.0:
        seconds = np.maximum(seconds, turn / instrument.dome_rate)
    # What rounding leaves is no second more.
    return np.asarray(np.ceil(np.round(seconds, 3)).astype(np.int64))


def _shortest(angle: Floats) -> Floats:
    """Give the shorter way round (0 to 180°)."""
    return np.asarray(np.abs((angle + 180.0) % 360.0 - 180.0))


def overhead_matrix(problem: NightProblem, rows: Ints) -> Ints:
    """Give what leads from each visit (first axis) to each other (second axis), in seconds."""
    table = problem.table
    ra, dec, angle = table.ra[rows], table.dec[rows], table.angle[rows]
    between = _overheads(
        problem,
        np.abs(ra[None, :] - ra[:, None]),
        np.abs(dec[None, :] - dec[:, None]),
        _changes(table.filter_first[rows][None, :], table.filter_last[rows][:, None]),
    )
    return between + _turning(problem, angle[None, :], angle[:, None])


def _turning(problem: NightProblem, wanted: Floats, present: Floats) -> Ints:
    """Give what it takes to turn the camera, which is done before the telescope slews (s).

    A visit that wants no angle turns nothing; how it leaves the camera nobody knows here.
    """
    rate = problem.instrument.rotator_rate
    shape = np.broadcast_shapes(wanted.shape, present.shape)
    if rate <= 0.0 or np.isnan(wanted).all():
        return np.zeros(shape, np.int64)
    angle = np.abs((wanted - present + 180.0) % 360.0 - 180.0)
    angle = np.where(np.isnan(angle), _USUAL_TURN, angle)
    return np.asarray(np.where(np.isnan(wanted), 0.0, np.ceil(angle / rate)).astype(np.int64))


def _changes(wanted: Ints, present: Ints) -> NDArray[np.bool_]:
    return np.asarray((wanted != present) & (wanted >= 0))


def _overheads(
    problem: NightProblem, across: Floats, along: Floats, changes: NDArray[np.bool_]
) -> Ints:
    instrument = problem.instrument
    angle = np.maximum(np.minimum(across, 360.0 - across), along)
    new_field = angle >= SAME_FIELD
    # A dome turns by about as much as the telescope, and both move at once.
    rate = instrument.slew_rate
    if instrument.dome_rate > 0.0:
        rate = min(rate, instrument.dome_rate)
    slew = np.where(new_field, angle / rate + instrument.settle, 0.0)
    change = np.where(changes, instrument.filter_change, 0.0)
    total = np.maximum(slew, change) + np.where(new_field, instrument.acquire, 0.0)
    return np.asarray(np.ceil(total).astype(np.int64))
