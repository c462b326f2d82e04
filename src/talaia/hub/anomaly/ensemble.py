"""The detector we recommend: change, nearest stretches and time of day, judged together."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar

import msgspec
import numpy as np

from talaia.hub.anomaly.base import AnomalyDetector, Floats
from talaia.hub.anomaly.change import ChangePointDetector
from talaia.hub.anomaly.knn_cad import Nearest
from talaia.hub.anomaly.rarity import rate_together
from talaia.hub.anomaly.seasonal import Season

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Together"]

# Share of the stretches against one of the changes.
_SHARE = 0.5
# A departure from the rhythm of the day counts only if it is (nearly) the greatest there was.
_SEASON_LESS = 0.30


class Together(AnomalyDetector, kw_only=True):
    """Scores by three detectors: the first two in the mean, the third where it is sure."""

    faster_many: ClassVar[bool] = True
    change: ChangePointDetector = msgspec.field(default_factory=ChangePointDetector)
    nearest: Nearest = msgspec.field(default_factory=Nearest)
    season: Season = msgspec.field(default_factory=Season)
    scores: list[float] = msgspec.field(default_factory=lambda: [0.0, 0.0, 0.0])

    def __post_init__(self) -> None:
        """Pass the unit on."""
        for member in (self.change, self.nearest, self.season):
            member.unit = self.unit

    def see(self, time_us: int, value: float) -> float:
        """Score the newest sample."""
        change = self.change.see(time_us, value)
        nearest = self.nearest.see(time_us, value)
        season = max(0.0, self.season.see(time_us, value) - _SEASON_LESS)
        self.scores = [change, nearest, season]
        both = math.sqrt((change * change + _SHARE * nearest * nearest) / (1.0 + _SHARE))
        return max(both, season)

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Score samples in their order (n,), as `see` does one by one; see `Rarity.rate_many`."""
        return self.rate_many(times, values)[0]

    def magnitudes(self) -> tuple[float, ...]:
        """Give those of all three."""
        return tuple(
            magnitude
            for member in (self.change, self.nearest, self.season)
            for magnitude in member.magnitudes()
        )

    def rate_many(self, times: NDArray[np.int64], values: Floats) -> tuple[Floats, Floats]:
        """See `AnomalyDetector.rate_many`."""
        sizes = np.vstack(
            (
                self.change.measure_many(times, values),
                self.nearest.measure_many(values),
                self.season.measure_many(times, values),
            )
        )
        paces = len(sizes) - 2
        rated = rate_together(
            [*self.change.rarities, self.nearest.rarity, self.season.rarity], sizes
        )
        change = self.change.score_sizes(sizes[:paces], rated[:paces])
        nearest, season = rated[paces], rated[paces + 1]
        self.nearest.score = float(nearest[-1])
        season = np.maximum(0.0, season - _SEASON_LESS)
        self.scores = [float(one[-1]) for one in (change, nearest, season)]
        both = np.sqrt((change * change + _SHARE * nearest * nearest) / (1.0 + _SHARE))
        scores: Floats = np.maximum(both, season)
        return scores, np.maximum(sizes, 0.0).T

    def why(self) -> str:
        """Give the words of the one that speaks loudest."""
        change, nearest, season = self.scores
        both = math.sqrt((change * change + _SHARE * nearest * nearest) / (1.0 + _SHARE))
        if season > both:
            return self.season.why()
        return self.change.why() if change >= nearest else self.nearest.why()

    def forgive(self) -> bool:
        """Let all three learn."""
        learned = [member.forgive() for member in (self.change, self.nearest, self.season)]
        return all(learned)
