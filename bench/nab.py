"""The part of the Numenta Anomaly Benchmark that scores a detector, standard profile.

Written from the description of its scorer (Lavin & Ahmad 2015, "Evaluating Real-time Anomaly
Detection Algorithms"). The series stay where they are; nothing of them belongs to the project.
"""

from __future__ import annotations

import csv
import datetime
import json
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

__all__ = ["Scored", "Series", "best", "load", "score"]

A_FP, PROBATION, LONGEST = 0.11, 0.15, 5000


class Series(NamedTuple):
    """One labelled series: times in µs, values, and the windows as (first, last) index."""

    name: str
    times: np.ndarray
    values: np.ndarray
    windows: list[tuple[int, int]]

    @property
    def probation(self) -> int:
        """Tell how many samples at the beginning do not count."""
        return int(PROBATION * min(len(self.values), LONGEST))


class Scored(NamedTuple):
    """What a set of scores comes to: 0 is a detector that is silent, 100 a perfect one."""

    score: float
    threshold: float
    found: int
    windows: int
    false: int


def load(where: Path) -> list[Series]:
    """Read all series below ``where``; ``FileNotFoundError`` when there are none."""
    labels = json.loads((where / "windows.json").read_text())
    return [_series(where / "data" / name, name, spans) for name, spans in sorted(labels.items())]


def _micros(text: str) -> int:
    moment = datetime.datetime.fromisoformat(text).replace(tzinfo=datetime.UTC)
    return round(moment.timestamp() * 1_000_000)


def _series(path: Path, name: str, spans: list[list[str]]) -> Series:
    with path.open(newline="") as file:
        rows = list(csv.reader(file))[1:]
    times = np.array([_micros(row[0]) for row in rows], np.int64)
    windows = []
    for first, last in spans:
        inside = np.flatnonzero((times >= _micros(first)) & (times <= _micros(last)))
        windows.append((int(inside[0]), int(inside[-1])))
    return Series(name, times, np.array([float(row[1]) for row in rows]), windows)


def _sigmoid(y: np.ndarray) -> np.ndarray:
    return np.where(y > 3.0, -1.0, 2.0 / (1.0 + np.exp(5.0 * np.minimum(y, 3.0))) - 1.0)


def _worth(series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Give for each sample what a detection there is worth, and its window (−1: none)."""
    count = len(series.values)
    worth, window = np.full(count, -A_FP), np.full(count, -1)
    for first, last in series.windows:
        width = last - first + 1
        behind = np.arange(last + 1, count)
        worth[behind] = A_FP * _sigmoid((behind - last) / max(width - 1, 1))
    for at, (first, last) in enumerate(series.windows):
        width = last - first + 1
        inside = np.arange(first, last + 1)
        worth[inside] = _sigmoid(-(last - inside + 1) / width) / _sigmoid(np.array(-1.0))
        window[inside] = at
    return worth, window


def _gathered(
    series: Sequence[Series], scores: Mapping[str, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Put all samples that count side by side: score, worth and window, numbered through."""
    found, worths, windows, total = [], [], [], 0
    for one in series:
        worth, window = _worth(one)
        counts = slice(one.probation, None)
        found.append(np.asarray(scores[one.name], float)[counts])
        worths.append(worth[counts])
        windows.append(np.where(window < 0, -1, window + total)[counts])
        total += len(one.windows)
    return np.concatenate(found), np.concatenate(worths), np.concatenate(windows), total


def score(series: Sequence[Series], scores: Mapping[str, np.ndarray], threshold: float) -> Scored:
    """Score with this threshold; ``scores`` by the name of the series."""
    found, worth, window, total = _gathered(series, scores)
    hits = found >= threshold
    outside = hits & (window < 0)
    best_of = np.full(total, -np.inf)
    np.maximum.at(best_of, window[hits & (window >= 0)], worth[hits & (window >= 0)])
    seen = best_of > -np.inf
    raw = worth[outside].sum() + best_of[seen].sum() - (total - seen.sum())
    return Scored(
        100.0 * (raw + total) / (2.0 * total) if total else 0.0,
        threshold,
        int(seen.sum()),
        total,
        int(outside.sum()),
    )


def best(series: Sequence[Series], scores: Mapping[str, np.ndarray]) -> Scored:
    """Take the threshold with the greatest total, as the benchmark does."""
    found, worth, window, total = _gathered(series, scores)
    order = np.argsort(-found, kind="stable")
    found, worth, window = found[order], worth[order], window[order]
    reached, have = np.where(window < 0, worth, 0.0), np.full(total, -np.inf)
    for at in np.flatnonzero(window >= 0):
        before, now = have[window[at]], worth[at]
        if now > before:
            reached[at] = now + 1.0 if before == -np.inf else now - before
            have[window[at]] = now
    sums = np.cumsum(reached)
    ends = np.flatnonzero(np.diff(found, append=-np.inf) < 0)  # equal scores stand or fall together
    top = ends[np.argmax(sums[ends])]
    if sums[top] <= 0.0:
        return score(series, scores, np.inf)
    return score(series, scores, float(found[top]))
