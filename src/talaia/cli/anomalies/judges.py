"""What judges the rows of a table: a detector across all signals, or one on each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from talaia.cli.errors import CliError
from talaia.hub.anomaly.groups.group import FEWEST_LEARNED, MOST_SIGNALS, most_learned
from talaia.hub.anomaly.groups.modal_group import ModalGroup
from talaia.hub.anomaly.kinds import KINDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats

__all__ = ["DETECTORS", "RowJudge", "RowVerdict", "make_judge"]

_GROUP = "group"
# Limits are what a person knows, not what a table shows, and silence is no row.
_OF_ONE_SIGNAL = tuple(name for name in KINDS if name not in ("limits", "missing"))
DETECTORS = (_GROUP, *_OF_ONE_SIGNAL)
# Each detector of a single signal takes about 100 kB.
_MOST_COLUMNS = 1_000
# Signals with a smaller share of a distance are not named.
_LEAST_SHARE = 0.1


class RowVerdict(NamedTuple):
    """What is said of one row: a score (0 to 1), whether it is anomalous, which signals made it."""

    score: float
    anomalous: bool
    # In words for people, such as ``flow 62 %``; empty unless it is anomalous.
    signals: Sequence[str]


class RowJudge(Protocol):
    """Judges rows in the order of their times; each by itself and those before it."""

    def judge_rows(self, times: NDArray[np.int64], rows: Floats) -> list[RowVerdict]:
        """Judge the next rows, each newer than the one before.

        Args:
            times: of the rows (n,), µs since the epoch.
            rows: their values (n, signals); NaN: no value.

        """
        ...


class GroupJudge:
    """Judges by all signals together."""

    def __init__(self, signals: Sequence[str], learn_rows: int) -> None:
        """Learn from the first ``learn_rows`` rows."""
        # A table's rows are its steps, however far they lie apart.
        self._group = ModalGroup(signals=list(signals), learn_rows=learn_rows, step_us=0)

    def judge_rows(self, times: NDArray[np.int64], rows: Floats) -> list[RowVerdict]:
        """See `RowJudge.judge_rows`."""
        return list(map(self._judge_row, times.tolist(), rows.tolist()))

    def _judge_row(self, time_us: int, values: Sequence[float]) -> RowVerdict:
        score = self._group.see_row(time_us, values)
        if not self._group.anomalous:
            return RowVerdict(score, anomalous=False, signals=[])
        shares = self._group.list_shares()
        named = [
            f"{signal.name} {signal.share * 100:.0f} %"
            for at, signal in enumerate(shares)
            # The first is named however the distance is spread.
            if at == 0 or signal.share >= _LEAST_SHARE
        ]
        return RowVerdict(score, anomalous=True, signals=named)


class SeparateJudge:
    """Judges each signal by a detector of its own; the greatest score is the row's."""

    def __init__(self, name: str, signals: Sequence[str], learn_rows: int) -> None:
        """Say nothing of the first ``learn_rows`` rows."""
        kind = KINDS[name]
        self._bar, self._left = kind.bar, learn_rows
        self._signals = list(signals)
        self._detectors = [kind.make() for _ in signals]

    def judge_rows(self, times: NDArray[np.int64], rows: Floats) -> list[RowVerdict]:
        """See `RowJudge.judge_rows`."""
        scores = np.zeros(rows.shape)
        for column, values, detector in zip(scores.T, rows.T, self._detectors, strict=True):
            # A value that is not there is passed over, as the hub does.
            there = np.isfinite(values)
            if there.any():
                column[there] = detector.see_many(times[there], values[there])
        # Nothing is said of the rows that are learned from.
        high = scores >= self._bar
        high[: self._left] = False
        self._left = max(0, self._left - len(rows))
        verdicts = [
            RowVerdict(score, anomalous=False, signals=[]) for score in scores.max(axis=1).tolist()
        ]
        for at in np.flatnonzero(high.any(axis=1)).tolist():
            named = [
                f"{self._signals[one]} {scores[at, one]:.2f}" for one in np.flatnonzero(high[at])
            ]
            verdicts[at] = RowVerdict(verdicts[at].score, anomalous=True, signals=named)
        return verdicts


def make_judge(detector: str, signals: Sequence[str], learn_rows: int) -> RowJudge:
    """Make what judges rows of these signals.

    Raises:
        CliError: too many signals, or too few or many rows to learn from.

    """
    most = MOST_SIGNALS if detector == _GROUP else _MOST_COLUMNS
    if len(signals) > most:
        raise CliError(
            f"expected at most {most} signals for {detector!r}, found {len(signals)}; choose some"
            " with --signals"
        )
    if detector == _GROUP:
        if not FEWEST_LEARNED <= learn_rows <= most_learned(len(signals)):
            raise CliError(
                f"--learn-rows: expected {FEWEST_LEARNED} to {most_learned(len(signals))} for"
                f" {detector!r} with {len(signals)} signals,"
                f" found {learn_rows}"
            )
        return GroupJudge(signals, learn_rows)
    if learn_rows < 0:
        raise CliError(f"--learn-rows: expected 0 or more, found {learn_rows}")
    return SeparateJudge(detector, signals, learn_rows)
