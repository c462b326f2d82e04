"""How much each signal changes from step to step, beside what is usual where it stands.

A motor's current is quiet while it stands and noisy while it turns. Beside the scatter of a whole
day five times its usual noise while it stands is nothing; beside the steps it makes while it
stands, it is. So the values of a day are cut into a few levels, once; each level has a mean square
of the steps within it, and the newest such steps are held against that. A step from one level to
another says nothing here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import SPREAD_OF_MEDIAN, Floats

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["LevelScatter"]

# Levels of a signal at the most; rows of a day that they are found in.
_LEVELS, _KEPT = 8, 512
# Levels lie so many usual steps apart at the least, and have so many of those rows.
_APART, _FEWEST = 4.0, 4
# From so many steps within a level it is known how large they are; a greater one than so many
# spreads counts as no more while that is learned.
_KNOWN, _FARTHEST = 100, 5.0
# Squares are smoothed over five steps, and count as no more than so much.
_FOLLOWS, _MOST = 2.0 / (5 + 1), 1e4
# Rows that are learned from at once; so many times the first day counts.
_BATCH, _DAYS = 64, 3


class LevelScatter(msgspec.Struct, kw_only=True):
    """Holds each signal's newest steps against those that are usual at its level.

    Attributes:
        count: of the signals.
        learns: so many rows are a day.
        seen: so many rows came.

    """

    count: int
    learns: int = 1_000
    seen: int = 0
    # Until levels are found: rows of the day and the steps that led to them, row after row.
    kept: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # Where levels meet (count × levels - 1), infinite where there are fewer; empty: not found yet.
    edges: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # Of each level: mean squares of steps within it, and of how many (count × levels).
    squares: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    steps: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # Steps that are still to be learned from: squares and their levels, -1 for none; how many.
    recent: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    waiting: int = 0
    newest: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # Newest squares in usual ones, smoothed.
    smoothed: Floats = msgspec.field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Make room for as many signals as there are."""
        if len(self.newest) != self.count:
            self.newest, self.smoothed = np.full(self.count, np.nan), np.zeros(self.count)
            self.squares, self.steps = np.zeros((2, self.count * _LEVELS))
            self.recent = np.zeros(_BATCH * 2 * self.count)

    def see_rows(self, rows: Floats) -> Floats:
        """Take rows (n, signals), NaN where nothing came; give the smoothed squares after each."""
        found, at = np.empty((len(rows), self.count)), 0
        while at < len(rows):
            upto = min(len(rows), at + _BATCH - self.waiting)
            found[at:upto] = self._see_part(rows[at:upto])
            at = upto
        return found

    def _see_part(self, rows: Floats) -> Floats:
        """Take rows, at most as many as make a batch full."""
        many = len(rows)
        line = np.vstack((self.newest, rows))
        came = np.isfinite(rows)
        if not came.all():
            # A signal that comes seldom steps from its newest sample.
            for at in range(many):
                line[at + 1] = np.where(came[at], rows[at], line[at])
        self.newest = line[-1].copy()
        moves = np.where(came, line[1:] - line[:-1], np.nan)
        if not self.edges.size:
            self._keep_rows(rows, moves)
            self.seen += many
            return np.zeros((many, self.count))
        self.seen += many
        squares = np.square(moves)
        levels = (line[:, :, None] > self.edges.reshape(self.count, -1)).sum(axis=2)
        same = np.isfinite(moves) & (levels[1:] == levels[:-1])
        place = np.arange(self.count) * _LEVELS + levels[1:]
        usual = self.squares[place]
        judged = same & (self.steps[place] >= _KNOWN) & (usual > 0.0)
        ratios = np.zeros((many, self.count))
        # Cut off before: beside next to nothing a quotient is more than a number can be.
        np.divide(np.minimum(squares, _MOST * usual), usual, out=ratios, where=judged)
        smoothed = np.empty((many, self.count))
        for at in range(many):
            follow = judged[at] * _FOLLOWS
            self.smoothed = self.smoothed + follow * (ratios[at] - self.smoothed)
            smoothed[at] = self.smoothed
        part = self.recent.reshape(_BATCH, 2, self.count)[self.waiting : self.waiting + many]
        part[:, 0], part[:, 1] = np.where(same, squares, 0.0), np.where(same, place, -1.0)
        self.waiting += many
        if self.waiting == _BATCH:
            self._learn_steps()
        return smoothed

    def _learn_steps(self) -> None:
        """Learn how large steps within each level are."""
        squares, places = self.recent.reshape(_BATCH, 2, self.count).transpose(1, 0, 2)
        within = places >= 0.0
        at = places[within].astype(np.int64)
        # A fault of minutes is little in it.
        far = np.where(self.steps >= _KNOWN, _FARTHEST**2 * self.squares, np.inf)
        size = len(self.squares)
        came = np.bincount(at, minlength=size)
        sums = np.bincount(at, np.minimum(squares[within], far[at]), minlength=size)
        self.steps = np.minimum(self.steps + came, float(_DAYS * self.learns))
        self.squares += (sums - came * self.squares) / np.maximum(self.steps, 1.0)
        self.waiting = 0

    def _keep_rows(self, rows: Floats, moves: Floats) -> None:
        """Keep one of so many rows; find levels once there are enough."""
        stride = max(1, self.learns // _KEPT)
        chosen = (self.seen + np.arange(len(rows))) % stride == stride - 1
        pairs = np.hstack((rows[chosen], moves[chosen]))
        self.kept = np.concatenate((self.kept, pairs.ravel()))
        if self.kept.size < _KEPT * 2 * self.count:
            return
        values, steps = self.kept.reshape(-1, 2, self.count).transpose(1, 2, 0)
        edges = [_find_edges(one, moved) for one, moved in zip(values, steps, strict=True)]
        self.edges, self.kept = np.concatenate(edges), np.empty(0)


def _find_edges(values: Floats, steps: Floats) -> Floats:
    """Cut values into levels by their nearest middles (Lloyd 1982); give where they meet."""
    edges, values = np.full(_LEVELS - 1, np.inf), values[np.isfinite(values)]
    steps = np.abs(steps[np.isfinite(steps)])
    if not len(values) or not len(steps):
        return edges
    low, high = float(values.min()), float(values.max())
    middles = low + (high - low) * (np.arange(_LEVELS) + 0.5) / _LEVELS
    for _ in range(10):
        middles = _move_middles(values, middles)
    apart = _APART * SPREAD_OF_MEDIAN * float(np.median(steps))
    while len(middles) > 1 and float(np.diff(middles).min()) < apart:
        # The two nearest are one.
        at = int(np.diff(middles).argmin())
        middles = np.delete(middles, at)
        middles = _move_middles(values, middles)
    edges[: len(middles) - 1] = 0.5 * (middles[1:] + middles[:-1])
    return edges


def _move_middles(values: Floats, middles: Floats) -> Floats:
    """Move each middle to the mean of what is nearest to it; those of few values are left out."""
    nearest: NDArray[np.intp] = np.searchsorted(0.5 * (middles[1:] + middles[:-1]), values)
    many = np.bincount(nearest, minlength=len(middles))
    there = many >= min(_FEWEST, len(values))
    sums = np.bincount(nearest, values, minlength=len(middles))
    moved: Floats = sums[there] / many[there]
    return moved if len(moved) else middles
