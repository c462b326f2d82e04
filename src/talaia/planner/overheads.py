"""What stands between two blocks: slew, settling, centring, filter, dome, meridian flip."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.planner.night_problem import Ints, NightProblem
    from talaia.planner.sky import Floats

__all__ = ["PARKED", "TelescopePointing", "overhead_matrix", "overheads_from", "unpark_overhead"]

# Nearer than this is the same field (°, in right ascension and declination).
SAME_FIELD = 0.01


class TelescopePointing(NamedTuple):
    """Where a telescope points, and the filter that is in (an index); `PARKED`: nowhere."""

    ra: float
    dec: float
    filter: int


PARKED: TelescopePointing | None = None


def unpark_overhead(problem: NightProblem) -> int:
    """Give what leads from the parked telescope to the first exposure (s)."""
    instrument = problem.instrument
    return int(np.ceil(instrument.unpark + instrument.settle + instrument.acquire))


def overheads_from(problem: NightProblem, pointing: TelescopePointing | None, rows: Ints) -> Ints:
    """Give what leads from a pointing to each visit (s)."""
    if pointing is None:
        seconds = np.full(len(rows), unpark_overhead(problem), np.int64)
        seconds[~problem.table.needs_sky[rows]] = 0
        return seconds
    table = problem.table
    return _overheads(
        problem,
        np.abs(table.ra[rows] - pointing.ra),
        np.abs(table.dec[rows] - pointing.dec),
        _changes(table.filter_first[rows], np.array(pointing.filter)),
    )


def overhead_matrix(problem: NightProblem, rows: Ints) -> Ints:
    """Give what leads from each visit (first axis) to each other (second axis), in seconds."""
    table = problem.table
    ra, dec = table.ra[rows], table.dec[rows]
    return _overheads(
        problem,
        np.abs(ra[None, :] - ra[:, None]),
        np.abs(dec[None, :] - dec[:, None]),
        _changes(table.filter_first[rows][None, :], table.filter_last[rows][:, None]),
    )


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
