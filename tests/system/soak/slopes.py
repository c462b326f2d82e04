"""How fast a figure grows, and whether that is too fast. Pure.

A slope is the median of the slopes between all pairs of points (Theil and Sen), so that a spike or
a saw-tooth moves it little. Its interval is Sen's, by Kendall's variance with ties, at 95 %. Points
near each other in time are not independent; so the points given should be a minute's median each.

A process that is killed begins anew: pairs are made within one life of it only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Point", "Slope", "Verdict", "by_minute", "judge", "slope_of"]

Z = 1.96
# Fewer points in a life than this say nothing.
LEAST = 4


class Point(NamedTuple):
    """A figure at a moment (h since the start) in one life of its process."""

    hours: float
    value: float
    life: int = 0


class Slope(NamedTuple):
    """A slope per hour with its interval; points: what it stands on."""

    each_hour: float
    low: float
    high: float
    points: int


class Verdict(StrEnum):
    """What a slope says about its limit."""

    HOLDS = "holds"
    BROKEN = "**broken**"
    UNCLEAR = "unclear"


def by_minute(points: Iterable[Point]) -> list[Point]:
    """Give the median of each minute of each life, at the middle of its points."""
    minutes: dict[tuple[int, int], list[Point]] = {}
    for each in points:
        minutes.setdefault((each.life, math.floor(each.hours * 60)), []).append(each)
    return [
        Point(
            float(np.mean([each.hours for each in found])),
            float(np.median([each.value for each in found])),
            life,
        )
        for (life, _), found in sorted(minutes.items())
    ]


def slope_of(points: Sequence[Point]) -> Slope | None:
    """Give the slope within lives; none where no life has enough points."""
    slopes: list[NDArray[np.float64]] = []
    variance, used = 0.0, 0
    for life in sorted({each.life for each in points}):
        mine = [each for each in points if each.life == life]
        if len(mine) < LEAST:
            continue
        hours = np.array([each.hours for each in mine])
        values = np.array([each.value for each in mine])
        first, second = np.triu_indices(len(mine), 1)
        apart = hours[second] - hours[first]
        slopes.append((values[second] - values[first])[apart > 0] / apart[apart > 0])
        variance += _kendall_variance(values)
        used += len(mine)
    every = np.sort(np.concatenate(slopes)) if slopes else np.empty(0)
    if not every.size:
        return None
    half = Z * math.sqrt(variance)
    low = every[max(0, math.floor((every.size - half) / 2) - 1)]
    high = every[min(every.size - 1, math.ceil((every.size + half) / 2))]
    return Slope(float(np.median(every)), float(low), float(high), used)


def _kendall_variance(values: NDArray[np.float64]) -> float:
    """Give the variance of Kendall's score of so many values without a trend."""
    _, ties = np.unique(values, return_counts=True)
    every = values.size * (values.size - 1) * (2 * values.size + 5)
    return float(every - np.sum(ties * (ties - 1) * (2 * ties + 5))) / 18


def judge(slope: Slope | None, limit: float) -> Verdict:
    """Hold a slope against a limit (per hour): broken only where the whole interval is over it."""
    if slope is None:
        return Verdict.UNCLEAR
    if slope.low > limit:
        return Verdict.BROKEN
    return Verdict.HOLDS if slope.high <= limit else Verdict.UNCLEAR
