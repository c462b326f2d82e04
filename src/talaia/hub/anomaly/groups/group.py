"""Several signals judged together: how far all of them are from what they usually are together.

Long, because learning, judging and forgiving work on one state.

The distance is Hotelling's T² (Hotelling 1947, "Multivariate quality control"): with ``d`` the
departures of the signals and ``S`` their usual covariance, ``T² = dᵀ S⁻¹ d``. Signals that
usually go together and now go apart are far away though each of them is where it often is.

- ``d`` is the difference of two exponential means (Roberts 1959), a fast and a slow one, as in
  the multivariate control chart of Lowry et al. (1992): noise is averaged out, a slow drift is
  followed.
- ``S`` is shrunk towards its diagonal (Ledoit and Wolf 2004).
- The shares are ``(S^(-½) d)²/T²``: of all ways to whiten, this one keeps each new variable
  nearest to its signal (Kessy, Lewin and Strimmer 2018), and the shares add up to one (the
  complete decomposition of Alcala and Qin 2009).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import Floats, format_number
from talaia.hub.anomaly.groups.held_values import NEVER, HeldValues
from talaia.hub.anomaly.groups.whitening import (
    SignalShare,
    inverse_root,
    share_distance,
    shrink_covariance,
    usual_spreads,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "FEWEST_LEARNED",
    "MOST_LEARNED",
    "MOST_SIGNALS",
    "GroupDetector",
    "most_learned",
    "score_of_distance",
]

# What it keeps while it learns is a number for each signal and step: 5 MB at the most.
MOST_SIGNALS, MOST_KEPT = 64, 640_000
FEWEST_LEARNED, MOST_LEARNED = 60, 30_000
# Spans of the fast and the slow mean (steps); a mean of span n follows by 2/(n+1) a step.
_FAST, _SLOW = 2.0 / (30 + 1), 2.0 / (180 + 1)
# The slow mean begins as the mean of so many steps, which are not judged by.
_BEGINNING = 50
# A single value counts as no farther than so many spreads, however wild it is.
_FARTHEST = 100.0
# So many times the greatest distance of the learning stretch is an anomaly...
_BAR = 2.3
# ...which is over below so much of that.
_LEAVE = 0.6
# Below such a part of the greatest squared distance of late nothing is told: a machine that was
# far away does not come back to where it was, and its aftermath is no second fault. The part is
# never more than so many limits, and halves in so many steps.
_AFTERMATH, _MOST_BAR, _HALVING = 0.05, 100.0, 0.5 ** (1 / 200)
# While an anomaly is on, the slow mean goes on following signals that are within so many spreads.
_WITHIN = 3.5
# After a silence of so many steps the fast mean begins anew.
_SILENCE = 600


def most_learned(signals: int) -> int:
    """Give how many rows of so many signals may be learned from: what is kept is bounded."""
    return min(MOST_LEARNED, MOST_KEPT // max(1, signals))


def score_of_distance(distance: float) -> float:
    """Give the score of a squared distance (in limits) while no anomaly is on."""
    return distance / (distance + _BAR)


class GroupDetector(msgspec.Struct, kw_only=True):
    """Scores several signals together, once a step; it learns from its first steps.

    It sees whole rows; `ModalGroup` makes them of samples. It is bounded in memory by the number of
    signals squared, and while it learns by signals times steps.

    Attributes:
        signals: their names, at most `MOST_SIGNALS`.
        learn_rows: from so many first steps it learns what is normal.
        step_us: so long is a step (µs); 0: as long as the rows of the learning stretch lie apart.
        score: 0 to 1, from one half on an anomaly; 0 while it learns.
        anomalous: an anomaly is on.

    """

    signals: list[str]
    learn_rows: int = 600
    step_us: int = 1_000_000
    score: float = 0.0
    anomalous: bool = False
    # Of the learning stretch: its beginning as it came, then how far the means were apart, row
    # after row, in the signals' units; and its times (µs). Empty once it is over.
    rows: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    times: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    counted: int = 0
    # So many values of each signal were among them.
    seen: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    held: HeldValues = msgspec.field(default_factory=lambda: HeldValues(count=0))
    # Learned: what each signal is scaled by (while it learns: the sum of its squared departures),
    # the covariance (row after row), the distance's limit.
    center: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    scale: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    covariance: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    limit: float = 0.0
    # Its inverse root for the signals that are known now (1; 0: not), which change seldom.
    whitening: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    known: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # The two means of each signal, and how far they are apart.
    fast: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    slow: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    apart: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # The squared distance in limits: now, the greatest of an anomaly of late, and what a person
    # may call usual, with its departure.
    distance: float = 0.0
    aftermath: float = 0.0
    peak: float = 0.0
    peak_apart: Floats = msgspec.field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Make room for as many signals as there are."""
        count = len(self.signals)
        if not 1 <= count <= MOST_SIGNALS:
            raise ValueError(f"expected 1 to {MOST_SIGNALS} signals in a group, found {count}")
        most = most_learned(count)
        if not FEWEST_LEARNED <= self.learn_rows <= most:
            raise ValueError(
                f"expected {FEWEST_LEARNED} to {most} rows to learn from, found {self.learn_rows}"
            )
        if self.held.count == count:
            return
        self.held = HeldValues(count=count)
        self.rows, self.times = np.empty(self.learn_rows * count), np.empty(self.learn_rows)
        self.fast, self.slow = np.full(count, np.nan), np.full(count, np.nan)
        self.center, self.scale, self.seen = np.zeros(count), np.zeros(count), np.zeros(count)
        self.apart, self.known = np.zeros(count), np.zeros(count)
        self.peak_apart = np.zeros(count)

    @property
    def learning(self) -> int:
        """So many steps until it has learned; 0: it judges."""
        return 0 if self.limit else self.learn_rows - self.counted

    def see_row(self, time_us: int, values: Sequence[float] | Floats) -> float:
        """Take a value of each signal, NaN (or infinite) where there is none, and judge them.

        Args:
            time_us: µs since the epoch; not newer than the row before: passed over.
            values: one for each signal, in its unit.

        Returns:
            The score, 0 to 1.

        """
        newest_us = self.held.newest_us
        if time_us <= newest_us:
            return self.score
        steps = 1
        if newest_us != NEVER and self.step_us:
            steps = max(1, round((time_us - newest_us) / self.step_us))
        if steps > _SILENCE and self.limit:
            # What was before says nothing of now; one noisy row must not be all there is either.
            self.fast[:] = self.slow
        row = self.held.hold_row(time_us, steps, np.array(values, dtype=np.float64))
        if not self.limit:
            self._learn_row(time_us, row)
            return 0.0
        self._smooth_row(row)
        self._judge_distance()
        return self.score

    def _learn_row(self, time_us: int, row: Floats) -> None:
        """Take a row of the learning stretch in; the same small work for each of them."""
        count, beginning = len(self.signals), min(_BEGINNING, self.learn_rows // 4)
        there = np.isfinite(row)
        # Mean and squares in one pass (Welford 1962): no row need be looked at again.
        self.seen += there
        before = np.where(there, row - self.center, 0.0)
        self.center += before / np.maximum(self.seen, 1.0)
        self.scale += before * np.where(there, row - self.center, 0.0)
        place = slice(self.counted * count, (self.counted + 1) * count)
        if self.counted < beginning:
            self.rows[place] = row
        else:
            self._follow_raw(row)
            self.rows[place] = self.apart
        self.times[self.counted] = time_us
        self.counted += 1
        if self.counted == beginning:
            # Both means begin as that of all these rows.
            self.fast = np.where(self.seen > 0.0, self.center, np.nan)
            self.slow = self.fast.copy()
            for first in self.rows[: beginning * count].reshape(beginning, count):
                self._follow_raw(first)
        if self.counted == self.learn_rows:
            self._fit_normal(beginning)
            self.rows, self.times, self.seen = np.empty(0), np.empty(0), np.empty(0)

    def _follow_raw(self, row: Floats) -> None:
        """Let both means follow a row that is in the signals' units."""
        there = np.isfinite(row)
        first = there & np.isnan(self.fast)
        self.fast[first] = self.slow[first] = row[first]
        self.fast = np.where(there, self.fast + _FAST * (row - self.fast), self.fast)
        self.apart = np.where(there, self.fast - self.slow, 0.0)
        self.slow += _SLOW * self.apart

    def _fit_normal(self, beginning: int) -> None:
        """Learn scales, covariance and limit of the rows that are there."""
        count = len(self.signals)
        if not self.step_us:
            self.step_us = max(1, int(np.median(np.diff(self.times))))
        # Of a signal that was hardly there nothing is known: it is never judged by.
        self.held.learn_holds(self.learn_rows, self.seen < FEWEST_LEARNED // 2)
        self.scale = usual_spreads(self.center, self.scale / np.maximum(self.seen, 1.0))
        self.fast = np.nan_to_num((self.fast - self.center) / self.scale)
        self.slow = np.nan_to_num((self.slow - self.center) / self.scale)
        apart = self.rows.reshape(self.learn_rows, count)[beginning:] / self.scale
        self.apart = apart[-1].copy()
        self.covariance = shrink_covariance(apart).ravel()
        self._whiten_known(np.ones(count))
        whitened = apart @ self.whitening.reshape(count, -1)
        # Of a stretch in which nothing moved, the distance that one spread each would be.
        self.limit = max(float((whitened**2).sum(axis=1).max()), float(count))

    def _scale_row(self, row: Floats) -> Floats:
        scaled = (row - self.center) / self.scale
        return np.minimum(np.maximum(scaled, -_FARTHEST), _FARTHEST)

    def _smooth_row(self, row: Floats) -> None:
        scaled = self._scale_row(row)
        there = np.isfinite(scaled)
        self.fast = np.where(there, self.fast + _FAST * (scaled - self.fast), self.fast)
        # A signal that is not there departs from nothing, and does not count.
        self.apart = np.where(there, self.fast - self.slow, 0.0)
        if (there != self.known).any():
            self._whiten_known(there.astype(np.float64))

    def _whiten_known(self, known: Floats) -> None:
        """Take the inverse root of the covariance of the signals that are known (1; 0: not)."""
        covariance = self.covariance.reshape(len(self.signals), -1)
        self.whitening, self.known = inverse_root(covariance, known).ravel(), known

    def resume(self) -> None:
        """Begin anew from the usual level: what came meanwhile was not shown to it."""
        self.anomalous, self.score, self.distance = False, 0.0, 0.0
        if self.limit:
            self.fast = self.slow.copy()
            self.apart = np.zeros(len(self.signals))

    def _judge_distance(self) -> None:
        whitened = self.whitening.reshape(len(self.signals), -1) @ self.apart
        self.distance = float(whitened @ whitened) / self.limit
        if self.distance >= self.peak * 0.98:
            self.peak_apart = self.apart.copy()
        # Fades, so that a word of a person means what was just shown.
        self.peak = max(self.distance, self.peak * 0.98)
        bar = min(max(_BAR, _AFTERMATH * self.aftermath), _MOST_BAR) * (
            _LEAVE if self.anomalous else 1.0
        )
        self.score = self.distance / (self.distance + bar)
        self.anomalous = self.distance > bar
        if self.anomalous:
            self.aftermath = max(self.aftermath, self.distance)
            within = np.abs(self.apart) < _WITHIN * self._usual_spreads()
            self.slow += np.where(within, _SLOW * self.apart, 0.0)
        else:
            self.aftermath *= _HALVING
            self.slow += _SLOW * self.apart

    def _usual_spreads(self) -> Floats:
        """Give each signal's usual departure, from the covariance's diagonal."""
        return np.sqrt(self.covariance[:: len(self.signals) + 1])

    def list_shares(self) -> list[SignalShare]:
        """List all signals with their shares of the newest distance, the greatest first.

        The shares add up to 1; the list is empty while it learns, or where nothing departs.
        """
        if not self.limit or self.distance == 0.0:
            return []
        whitened = self.whitening.reshape(len(self.signals), -1) @ self.apart
        return share_distance(self.signals, whitened, self.apart / self._usual_spreads())

    def why(self) -> str:
        """Say in words what the newest score stands on, and which signals made it so."""
        if not self.limit:
            return f"it learns for {self.learning} more rows"
        named = [
            f"{signal.name} ({signal.share:.0%}, {abs(signal.spreads):.1f} spreads "
            f"{'above' if signal.spreads >= 0 else 'below'} its level)"
            for signal in self.list_shares()[:3]
            if signal.share >= 0.1
        ]
        # The distance itself is squared; people think of one that is not.
        times = format_number(self.distance**0.5)
        return (
            f"together {len(self.signals)} signals are {times} times as far from their usual "
            "state as ever while it learned" + (": " if named else "") + ", ".join(named)
        )

    def forgive(self) -> bool:
        """Learn that the newest peak was usual: departures of its kind count less from now on.

        ``S + w d dᵀ`` takes the distance of ``d`` from ``T²`` to ``T²/(1 + w T²)`` (Sherman and
        Morrison 1950), and leaves what has nothing to do with it as far away as it was.
        """
        if not self.limit:
            return False
        wanted = 0.5 * _BAR
        if self.peak > wanted:
            weight = (1.0 / wanted - 1.0 / self.peak) / self.limit
            self.covariance += weight * np.outer(self.peak_apart, self.peak_apart).ravel()
            self._whiten_known(self.known)
        self.peak, self.aftermath, self.anomalous, self.score = 0.0, 0.0, False, 0.0
        return True
