"""From the tails of all detectors of a site to a threshold for each, for a budget. Pure.

How often the site may be called is a property of the site and not of a detector, so it is counted
there. Each detector's magnitudes are put on one scale, the logarithm of how rare they are for it;
then what happened at a site within ten minutes is one, and the threshold is the value above which
there were as many as the budget allows in as long a time: an order statistic. Of ``n`` past values
and ``n`` to come, as many are expected above the ``k``-th greatest as there were, ``k``, whatever
they are distributed like, if only nothing changes (they are exchangeable).

Where fewer than `FEWEST_COUNTED` are due in the time that was seen, the order statistic is carried
on along the tail: the spacings of the greatest values of an exponential tail, each times its rank,
are alike (Rényi 1953), and on the logarithm of the magnitudes that is Hill's estimator (1975). The
two greatest have no part in it: a true fault that nobody confirmed must not make it deaf.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.anomaly.budget.score_tail import WEEK_BLOCKS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.anomaly.budget.score_tail import Peak, ScoreTail

__all__ = ["FEWEST_BLOCKS", "FEWEST_COUNTED", "Basis", "SiteThresholds", "site_thresholds"]

# Before a day was seen nothing is set: it would be a guess.
FEWEST_BLOCKS = WEEK_BLOCKS // 7
# From so many false alarms on that were due in what was seen, they are counted.
FEWEST_COUNTED = 3
# The greatest two may be faults.
_DOUBTED = 2
# The level that a detector's tail is measured from: two peaks from the top for each week that was
# seen, but so many at the least and at the most. Its slope is of so many peaks, or of three times
# as many as that where these are more.
_NEAREST, _FARTHEST, _FITTED, _POOLED = 2, 14, 10, 30
# More false alarms are not asked for: 50 a week for eight weeks.
_MOST_POOLED = 400
# How heavy a tail is (its slope on the logarithm): usually, and within what bounds.
_FEWEST_PEAKS = 5
_USUAL, _COUNTS_AS, _LIGHTEST, _HEAVIEST = 0.25, 12, 0.15, 0.4


class Basis(StrEnum):
    """What the thresholds stand on."""

    # Less than a day was seen: the detectors' own bars hold.
    LEARNING = "learning"
    # Fewer false alarms were due than can be counted: the tail is carried on.
    SHORT = "short"
    COUNTED = "counted"


class _TailFit(NamedTuple):
    """How rare the magnitudes of a detector are: ``rate = above · (x / level)^(-1/slope)``."""

    level: float
    slope: float
    above: int
    blocks: int

    def rareness(self, magnitude: float) -> float:
        """Give the logarithm of the blocks in which one so great is expected once."""
        if magnitude <= 0.0 or self.level <= 0.0:
            return -math.inf if magnitude <= self.level else math.inf
        return (
            math.log(self.blocks / self.above)
            + (math.log(magnitude) - math.log(self.level)) / self.slope
        )

    def magnitude(self, rareness: float) -> float:
        """Give the magnitude that is so rare."""
        beyond = (rareness - math.log(self.blocks / self.above)) * self.slope
        return self.level * math.exp(min(beyond, 300.0))


class SiteThresholds(NamedTuple):
    """Thresholds for all detectors of a site.

    Attributes:
        basis: what they stand on.
        blocks: blocks of ten minutes that were looked at.
        needed: so many are needed to count instead of carrying the tail on.
        of: by detector, for each of its magnitudes; without one: its own bar holds.

    """

    basis: Basis
    blocks: int
    needed: int
    of: Mapping[tuple[str, str], tuple[float, ...]]


def site_thresholds(tails: Mapping[tuple[str, str], ScoreTail], a_week: float) -> SiteThresholds:
    """Set the thresholds of a site's detectors.

    Args:
        tails: by address and detector.
        a_week: so many false alarms a week are allowed for the whole site.

    """
    blocks = max((tail.blocks for tail in tails.values()), default=0)
    needed = math.ceil(FEWEST_COUNTED * WEEK_BLOCKS / a_week)
    if blocks < FEWEST_BLOCKS:
        return SiteThresholds(Basis.LEARNING, blocks, needed, {})
    due = a_week * blocks / WEEK_BLOCKS
    anchor = min(max(2 * blocks // WEEK_BLOCKS, _NEAREST), _FARTHEST)
    fits, rated = {}, []
    for key, tail in tails.items():
        if tail.blocks < FEWEST_BLOCKS:
            continue
        fits[key] = [_fit_tail(peaks, tail.blocks, anchor) for peaks in tail.peaks]
        for peaks in tail.peaks:
            rated += _rate_peaks(peaks, tail.blocks, anchor)
    rareness = _rareness_for(_pool(rated), due, blocks)
    of = {key: tuple(fit.magnitude(rareness) for fit in some) for key, some in fits.items()}
    basis = Basis.COUNTED if due >= FEWEST_COUNTED else Basis.SHORT
    return SiteThresholds(basis, blocks, needed, of)


def _fit_tail(peaks: Sequence[Peak], blocks: int, anchor: int) -> _TailFit:
    # A long fault is one peak, however many hours it had.
    there = [(peak.first, peak.last, peak.greatest) for peak in peaks if peak.greatest > 0.0]
    values = _pool(there)
    if not values:
        # Nothing came near: whatever does is rarer than what was seen.
        return _TailFit(math.ulp(0.0), _USUAL, 1, blocks)
    count = min(len(values), anchor)
    index = _USUAL
    if len(values) >= _FEWEST_PEAKS:
        logs = [math.log(value) for value in values[: max(_FITTED, 3 * anchor)]]
        # From few it is known badly: the usual one counts as so many more spacings.
        many, more = len(logs) - 1 - _DOUBTED, _COUNTS_AS / anchor
        index = (many * _mean_spacing(logs) + more * _USUAL) / (many + more)
        index = min(max(index, _LIGHTEST), _HEAVIEST)
    return _TailFit(values[count - 1], index, count, blocks)


def _mean_spacing(falling: Sequence[float]) -> float:
    """Give the mean of an exponential tail: spacings times their ranks, but for the greatest."""
    first = min(_DOUBTED + 1, len(falling) - 1)
    spacings = [rank * (falling[rank - 1] - falling[rank]) for rank in range(first, len(falling))]
    return sum(spacings) / len(spacings)


def _rate_peaks(peaks: Sequence[Peak], blocks: int, anchor: int) -> list[tuple[int, int, float]]:
    """Tell when each peak was and how rare, by every other stretch of the time but its own.

    By its own tail the greatest peak is never as rare as the next one of its kind will be.
    """
    rated: list[tuple[int, int, float]] = []
    # Every other day: what lasts for hours is on one side.
    sides: tuple[list[Peak], list[Peak]] = ([], [])
    for peak in peaks:
        # Nothing at all is no peak: by a side of such any other would be endlessly rare.
        if peak.greatest > 0.0:
            sides[peak.first // FEWEST_BLOCKS % 2].append(peak)
    halved = min(len(side) for side in sides) >= _FEWEST_PEAKS
    for mine, others in (sides, sides[::-1]):
        fit = (
            _fit_tail(others, max(1, blocks // 2), anchor)
            if halved
            else _fit_tail(peaks, blocks, anchor)
        )
        rated += [(peak.first, peak.last, fit.rareness(peak.greatest)) for peak in mine]
    return rated


def _pool(rated: Sequence[tuple[int, int, float]]) -> list[float]:
    """Give the rareness above which there was one stretch of time, two, three, and so on.

    What touches in time is one stretch, as long as all of it is above.
    """
    # Begins and ends of the stretches that are above, in order; they lie apart.
    begins: list[int] = []
    ends: list[int] = []
    pooled: list[float] = []
    for first, last, rareness in sorted(rated, key=lambda one: -one[2]):
        low, high = bisect_left(ends, first - 1), bisect_right(begins, last + 1)
        begin, end = min([first, *begins[low:high]]), max([last, *ends[low:high]])
        begins[low:high], ends[low:high] = [begin], [end]
        if len(begins) > len(pooled):
            pooled.append(rareness)
        if len(pooled) >= _MOST_POOLED:
            break
    return pooled


def _rareness_for(pooled: Sequence[float], due: float, blocks: int) -> float:
    """Give the rareness above which so many are due in as long a time as was seen."""
    if not pooled:
        return math.log(blocks / due)
    if due >= FEWEST_COUNTED:
        rank = min(due, float(len(pooled)))
        below = min(math.floor(rank), len(pooled) - 1)
        share = rank - math.floor(rank)
        above = pooled[math.floor(rank) - 1]
        return above + share * (pooled[below] - above) if below else above
    rank = min(FEWEST_COUNTED, len(pooled))
    slope = 1.0
    if len(pooled) >= _FEWEST_PEAKS:
        slope = min(max(_mean_spacing(pooled[:_POOLED]), 0.2), 3.0)
    return pooled[rank - 1] + slope * math.log(rank / due)
