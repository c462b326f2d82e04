"""What each signal of a group does that neither its own past nor the other signals explain.

One distance over all signals (`GroupDetector`) says that a machine is not as usual; this says so of
each signal by itself, so that a small fault of a quiet signal is not hidden by a great one that is
usual elsewhere. A budget of false alarms gives each a threshold of its own.

- Departures of all signals from a level that follows them, at a few paces, are taken together as
  one normal variable with the covariance ``S`` that was seen in the last days. What of a signal's
  departures the others do not explain is then ``(K_ii)⁻¹ (K d)_i``, where ``K = S⁻¹`` and ``i`` are
  the places of that signal at all paces; its covariance is ``(K_ii)⁻¹`` (Whittaker 1990, "Graphical
  models in applied multivariate statistics": what a partial regression on all others leaves).
- Signals beside the group (`beside`) explain, and are not judged.
- How much a signal scatters is the smoothed square of what is left at the fastest pace; and, beside
  what is usual where it stands now, that of its steps (`LevelScatter`).
- How long it has not moved at all is counted in its samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec
import numpy as np

from talaia.hub.anomaly.base import Floats, format_duration, format_number
from talaia.hub.anomaly.groups.held_values import NEVER, HeldValues
from talaia.hub.anomaly.groups.level_scatter import LevelScatter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["SignalResiduals", "StrangeSignal"]

# Fast and slow spans of each pace (steps); a mean of span n follows by 2/(n+1) a step.
_PACES = ((1, 30), (10, 100), (30, 300))
_SPANS = (10, 30, 100, 300)
_COUNT = len(_PACES)
# Besides: how much it scatters, how long it has not moved. After these of all signals: how large
# the steps of each are for its level.
_KINDS = _COUNT + 2
_STEPS = _KINDS
_SCATTER = 2.0 / (20 + 1)
# Fewer samples alike are nothing.
_LEAST_STILL = 10
# It learns for a day before it judges, but for so many steps at the least; so many days of the past
# count, the newest most.
_DAY_US, _LEAST_ROWS, _DAYS = 86_400_000_000, 1_000, 3
# Departures count as no more than so many spreads of theirs while it learns.
_FARTHEST = 8.0
# Correlations are taken for so much smaller than they seem.
_RIDGE = 0.003
# Rows that are learned from at once, and after how many the covariance is inverted anew.
_BATCH, _RENEWED = 64, 1_024
# A residual counts as no greater than so many spreads.
_MOST = 1e6
# What a person called usual is told again from so much more on.
_EXCUSED = 5.0
# A peak of late fades so much with each row.
_FADING = 0.98


class StrangeSignal(NamedTuple):
    """A signal that does what is not explained.

    Attributes:
        place: of the signal among those of the group.
        excess: its magnitude in thresholds.
        spreads: its residual in usual ones.
        why: in words.

    """

    place: int
    excess: float
    spreads: float
    why: str


class SignalResiduals(msgspec.Struct, kw_only=True):
    """Judges each signal of a group against the others; bounded by their number squared.

    Attributes:
        own: so many signals are judged.
        beside: so many more, which come after these, only explain.
        step_us: so long is a step (µs).
        heard: so many rows came.
        judged: so many of them were judged.

    """

    own: int
    beside: int = 0
    step_us: int = 1_000_000
    heard: int = 0
    judged: int = 0
    held: HeldValues = msgspec.field(default_factory=lambda: HeldValues(count=0))
    # Means of each signal (spans × signals), row after row; of how many rows, 0: it is not there.
    means: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    followed: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # The newest departures (paces × signals), those that are still to be learned from, how many.
    apart: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    recent: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    waiting: int = 0
    # Mean products of departures, row after row; of so many rows.
    moments: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    learned: int = 0
    # By what departures become residuals in their spreads, row after row; the departures' spreads.
    # Reckoned from the moments: empty in what is kept.
    weights: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    spreads: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    # Of each signal: residuals at each pace in spreads, smoothed squares of the fastest, samples
    # without a move, the newest value.
    residuals: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    scatter: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    still: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    newest: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    levels: LevelScatter = msgspec.field(default_factory=lambda: LevelScatter(count=0))
    # What `magnitudes` gives, the greatest of these of late, and up to which a person called usual
    # what was told.
    rated: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    peaks: Floats = msgspec.field(default_factory=lambda: np.empty(0))
    excused: Floats = msgspec.field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Make room for as many signals as there are."""
        count = self.own + self.beside
        if self.levels.count != self.own:
            self.levels = LevelScatter(count=self.own, learns=self.learns)
            # What an older version kept knew nothing of levels.
            self.rated, self.peaks, self.excused = np.zeros((3, self.magnitude_count))
        if self.held.count == count:
            return
        self.held = HeldValues(count=count)
        self.means = np.full(len(_SPANS) * count, np.nan)
        self.followed, self.apart = np.zeros(count), np.zeros(_COUNT * count)
        self.recent = np.zeros(_BATCH * _COUNT * count)
        self.moments = np.zeros((_COUNT * count) ** 2)
        self.residuals = np.zeros(_COUNT * self.own)
        self.scatter, self.still, self.newest = np.zeros(self.own), np.zeros(self.own), self._none()

    def _none(self) -> Floats:
        return np.full(self.own, np.nan)

    @property
    def magnitude_count(self) -> int:
        """So many magnitudes there are in all."""
        return (_KINDS + 1) * self.own

    @property
    def learns(self) -> int:
        """It learns from so many rows."""
        return max(_LEAST_ROWS, _DAY_US // self.step_us)

    @property
    def trusted(self) -> bool:
        """It has judged for as long as it learned: thresholds of it stand on something."""
        return self.judged >= self.learns

    def see(self, time_us: int, place: int, value: float) -> None:
        """Take a sample of one signal; a step is judged once a sample of a later one comes."""
        held, step = self.held, time_us // self.step_us
        if step < held.gathering:
            return
        if step > held.gathering:
            if held.gathering != NEVER:
                self.see_row(held.gathering * self.step_us, held.gathered)
            held.begin_step(step)
        held.gathered[place] = value

    def see_row(self, time_us: int, values: Sequence[float] | Floats) -> None:
        """Take a value of each signal, NaN where there is none, and judge them."""
        held = self.held
        if time_us <= held.newest_us:
            return
        steps = 1
        if held.newest_us != NEVER:
            steps = max(1, round((time_us - held.newest_us) / self.step_us))
        came = np.array(values, dtype=np.float64)
        row = held.hold_row(time_us, steps, came)
        self.heard += 1
        if self.heard == _LEAST_ROWS:
            held.learn_holds(self.heard, np.zeros(held.count, bool))
        self._count_still(came[: self.own])
        changed = self.levels.see_rows(came[np.newaxis, : self.own])
        self._follow_row(row)
        if self.weights.size or self._is_learned():
            self._judge_departures(changed[0])
        self._learn_departures(self.apart[np.newaxis])

    def see_rows(self, times: NDArray[np.int64], rows: Floats) -> Floats:
        """Take rows in their order as `see_row` does one by one, many times faster.

        Args:
            times: rising, and newer than all that came before (µs) (n,).
            rows: a value of each signal, NaN where there is none (n, signals).

        Returns:
            `magnitudes` after each (n, m).

        """
        found, at = np.empty((len(rows), self.magnitude_count)), 0
        while at < len(rows):
            upto = min(len(rows), at + _BATCH - self.waiting)
            plain = self.weights.size > 0 and float(self.followed.min()) >= _SPANS[-1]
            if plain and np.isfinite(rows[at:upto]).all():
                found[at:upto] = self._see_block(times[at:upto], rows[at:upto])
                at = upto
                continue
            self.see_row(int(times[at]), rows[at])
            found[at] = self.rated
            at += 1
        return found

    def _see_block(self, times: NDArray[np.int64], rows: Floats) -> Floats:
        """Take rows in which every signal is there, and has been for long."""
        many, held = len(rows), self.held
        held.hold_row(int(times[-1]), many, rows[-1])
        held.came += many - 1
        self.heard += many
        self.followed += many
        still = self._still_rows(rows[:, : self.own])
        steps = self.levels.see_rows(rows[:, : self.own])
        means = np.empty((many + 1, len(_SPANS), held.count))
        means[0] = self.means.reshape(len(_SPANS), -1)
        for at, row in enumerate(rows):
            means[at + 1] = means[at] + _FOLLOWS * (row - means[at])
        self.means = means[-1].ravel()
        apart = np.empty((many, _COUNT, held.count))
        for at, (fast, far) in enumerate(_PACES):
            newest = rows if fast == 1 else means[1:, _SPANS.index(fast)]
            apart[:, at] = newest - means[:-1, _SPANS.index(far)]
        flat = apart.reshape(many, -1)
        self.apart = flat[-1].copy()
        rated = self._rate_rows(flat, still, steps)
        self._learn_departures(flat)
        return rated

    def _still_rows(self, rows: Floats) -> Floats:
        """Count for how many samples each signal has not moved, after each row."""
        before = np.vstack((self.newest, rows[:-1]))
        number = np.arange(1.0, len(rows) + 1.0)[:, None]
        moved = np.maximum.accumulate(np.where(rows == before, 0.0, number), axis=0)
        still: Floats = number - moved + np.where(moved == 0.0, self.still, 0.0)
        self.still, self.newest = still[-1].copy(), rows[-1].copy()
        return still

    def _rate_rows(self, apart: Floats, still: Floats, steps: Floats) -> Floats:
        """Rate departures (n, paces × signals) as `_judge_departures` does one by one."""
        many, size = apart.shape
        found = apart @ self.weights.reshape(self.own * _COUNT, size).T
        found = np.minimum(np.maximum(found, -_MOST), _MOST)
        squares, scatter = np.square(found), np.empty((many, self.own))
        for at, fastest in enumerate(squares[:, ::_COUNT]):
            self.scatter = self.scatter + _SCATTER * (fastest - self.scatter)
            scatter[at] = self.scatter
        self.residuals = found[-1].copy()
        self.judged += many
        rated = np.empty((many, self.own, _KINDS))
        rated[:, :, :_COUNT] = np.square(squares).reshape(many, self.own, _COUNT)
        rated[:, :, _COUNT] = np.square(scatter)
        rated[:, :, _COUNT + 1] = still * (still >= _LEAST_STILL)
        flat: Floats = np.hstack((rated.reshape(many, -1), np.square(steps)))
        flat *= flat > self.excused
        self.rated = flat[-1].copy()
        faded = flat * (_FADING ** np.arange(many - 1.0, -1.0, -1.0))[:, None]
        self.peaks = np.maximum(self.peaks * _FADING**many, faded.max(axis=0))
        return flat

    def _is_learned(self) -> bool:
        """Make what is not kept, where it has learned enough."""
        if self.learned < self.learns:
            return False
        self._renew_weights()
        return True

    def _count_still(self, came: Floats) -> None:
        alike = came == self.newest
        self.still = np.where(alike, self.still + 1.0, np.where(np.isnan(came), self.still, 0.0))
        self.newest = np.where(np.isnan(came), self.newest, came)

    def _follow_row(self, row: Floats) -> None:
        count = self.held.count
        means, there = self.means.reshape(len(_SPANS), count), np.isfinite(row)
        if not np.array_equal(there, self.followed > 0.0):
            # One that comes back begins anew: what was before says nothing of now.
            new = there & (self.followed == 0.0)
            means[:, new] = row[new]
            self.weights = np.empty(0)
        self.followed = np.where(there, self.followed + 1.0, 0.0)
        apart = self.apart.reshape(_COUNT, count)
        slow = means.copy()
        # A mean of few rows is that of all of them.
        follows = np.maximum(_FOLLOWS, 1.0 / np.maximum(self.followed, 1.0))
        means += follows * (np.where(there, row, means) - means)
        for at, (fast, far) in enumerate(_PACES):
            newest = row if fast == 1 else means[_SPANS.index(fast)]
            apart[at] = np.where(there, newest - slow[_SPANS.index(far)], 0.0)

    def _learn_departures(self, newest: Floats) -> None:
        """Learn from departures (n, paces × signals), at most as many as make a batch full."""
        size = len(self.apart)
        self.recent.reshape(_BATCH, size)[self.waiting : self.waiting + len(newest)] = newest
        self.waiting += len(newest)
        if self.waiting < _BATCH:
            return
        rows = self.recent.reshape(_BATCH, size)
        if self.spreads.size:
            far = _FARTHEST * self.spreads
            rows = np.minimum(np.maximum(rows, -far), far)
        self.learned += _BATCH
        share = max(_BATCH / self.learned, _BATCH / (_DAYS * self.learns))
        moments = self.moments.reshape(size, size)
        moments *= 1.0 - share
        moments += (share / _BATCH) * (rows.T @ rows)
        self.waiting = 0
        if self.weights.size and self.learned % _RENEWED == 0:
            self._renew_weights()

    def _renew_weights(self) -> None:
        """Reckon by what departures become residuals, of the signals that are there."""
        size = len(self.apart)
        moments = self.moments.reshape(size, size)
        self.spreads = np.sqrt(np.maximum(np.diag(moments), 1e-300))
        known = np.tile(self.followed, _COUNT) > 0.0
        self.weights = _residual_weights(moments, known, self.own)

    def _judge_departures(self, steps: Floats) -> None:
        size = len(self.apart)
        found = self.weights.reshape(self.own * _COUNT, size) @ self.apart
        self.residuals = np.minimum(np.maximum(found, -_MOST), _MOST)
        squares = np.square(self.residuals)
        self.scatter += _SCATTER * (squares[::_COUNT] - self.scatter)
        self.judged += 1
        rated = np.empty((self.own, _KINDS))
        rated[:, :_COUNT] = np.square(squares).reshape(self.own, _COUNT)
        rated[:, _COUNT] = np.square(self.scatter)
        rated[:, _COUNT + 1] = self.still * (self.still >= _LEAST_STILL)
        flat = np.concatenate((rated.ravel(), np.square(steps)))
        self.rated = flat * (flat > self.excused)
        self.peaks *= _FADING
        np.maximum(self.peaks, self.rated, out=self.peaks)

    def magnitudes(self) -> Floats:
        """Give what each signal's newest residuals are: by pace, its scatter, and how still it is.

        All of the first signal come first; after those of all signals, how large the steps of each
        are. They are fourth powers of spreads, on which scale the tails of all kinds of signals
        lie between the slopes that a budget reckons with; and samples. Zero while it learns.
        """
        return self.rated

    def excuse_newest(self, needs: Floats) -> None:
        """Learn that what was above its threshold of late is usual."""
        self.excused = np.where(self.peaks >= needs, _EXCUSED * self.peaks, self.excused)
        self.peaks[:] = 0.0

    def list_strange(self, needs: Floats, names: Sequence[str]) -> list[StrangeSignal]:
        """List the signals that are nearest to or above their thresholds, the strangest first."""
        excess = _by_signal(self.magnitudes() / needs, self.own)
        kinds = excess.argmax(axis=1)
        found = [
            StrangeSignal(
                place,
                float(excess[place, kind]),
                float(self.residuals[place * _COUNT + min(kind, _COUNT - 1)]),
                self._why(place, kind, names[place]),
            )
            for place, kind in enumerate(kinds.tolist())
            if excess[place, kind] > 0.0
        ]
        return sorted(found, key=lambda strange: -strange.excess)

    def _why(self, place: int, kind: int, name: str) -> str:
        if kind == _STEPS:
            times = format_number(float(np.sqrt(self.levels.smoothed[place])))
            return f"{name} changes {times} times as much from step to step as is usual there"
        if kind == _COUNT + 1:
            return f"{name} has not moved for {self.still[place]:.0f} samples"
        if kind == _COUNT:
            times = format_number(float(np.sqrt(self.scatter[place])))
            return f"{name} scatters {times} times as much as usual around what is expected of it"
        spreads = float(self.residuals[place * _COUNT + kind])
        lasts = format_duration(_PACES[kind][0] * self.step_us / 1e6)
        way = "above" if spreads >= 0.0 else "below"
        return (
            f"{name} is {format_number(abs(spreads))} usual spreads {way} what its past and the"
            f" other signals make of it ({lasts})"
        )


def _by_signal(magnitudes: Floats, own: int) -> Floats:
    """Put what `SignalResiduals.magnitudes` gives in a row for each signal."""
    most = own * _KINDS
    return np.column_stack((magnitudes[:most].reshape(own, _KINDS), magnitudes[most:]))


_FOLLOWS = np.array([[2.0 / (span + 1)] for span in _SPANS])


def _residual_weights(moments: Floats, known: NDArray[np.bool_], own: int) -> Floats:
    """Give by what departures become residuals in their spreads (own × paces × size), flat.

    Args:
        moments: mean products of the departures (size, size).
        known: which of these there are now (size,).
        own: so many signals are judged, the first ones.

    """
    size = len(known)
    count = size // _COUNT
    weights = np.zeros((own, _COUNT, size))
    # What has never moved explains nothing, and has no spread to be measured in.
    places = np.flatnonzero(known & (np.diag(moments) > 0.0))
    if not len(places):
        return weights.ravel()
    # As correlations: signals come in all units, and an inverse would mix their sizes.
    scales = np.sqrt(np.diag(moments)[places])
    correlated = moments[np.ix_(places, places)] / np.outer(scales, scales)
    np.fill_diagonal(correlated, 1.0 + _RIDGE)
    inverse = np.linalg.inv(correlated)
    # Where each departure is among those that are known; -1: it is not.
    position = np.full(size, -1)
    position[places] = np.arange(len(places))
    for signal in range(own):
        at = position[np.arange(_COUNT) * count + signal]
        if (at < 0).any():
            continue
        # What is left of it has the inverse of its own block as covariance.
        left = np.linalg.inv(inverse[np.ix_(at, at)])
        spread = np.sqrt(np.diag(left))
        weights[signal][:, places] = (left @ inverse[at]) / spread[:, None] / scales
    return weights.ravel()
