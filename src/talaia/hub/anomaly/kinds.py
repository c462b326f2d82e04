"""Every kind of detector by its name in the site description, with the bar it is told from."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.anomaly.baseline import Baseline, Quartiles
from talaia.hub.anomaly.change import ChangePointDetector
from talaia.hub.anomaly.context import Context
from talaia.hub.anomaly.ensemble import Together
from talaia.hub.anomaly.knn_cad import Nearest
from talaia.hub.anomaly.seasonal import Season
from talaia.hub.anomaly.simple_rules import LimitsDetector, Missing, RateOfChange, Still
from talaia.model.alarms.anomaly import DetectorKind

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.extensions.declarations import DetectorExtension
    from talaia.hub.anomaly.base import AnomalyDetector
    from talaia.model.alarms.anomaly import Watch

__all__ = ["KINDS", "RegisteredDetector", "kind_of"]


class RegisteredDetector(NamedTuple):
    """One kind of detector.

    Attributes:
        make: its class.
        bar: a score from here on is an anomaly, unless the description says another.
        name: as pages call it.
        quiet: it tells of nothing before it has seen so many samples.
        learning: and of what is clear only before it has seen so many.
        learns: a person can tell it what is usual.

    """

    make: type[AnomalyDetector]
    bar: float
    name: str
    quiet: int = 0
    learning: int = 0
    learns: bool = True


# A signal that drifts slowly looks new with every sample until a long stretch of it is known.
_QUIET, _LEARNING = 250, 1_000
KINDS: dict[str, RegisteredDetector] = {
    "together": RegisteredDetector(Together, 0.65, "all together", _QUIET, _LEARNING),
    "change": RegisteredDetector(ChangePointDetector, 0.66, "change of level", _QUIET, _LEARNING),
    "nearest": RegisteredDetector(Nearest, 0.51, "nearest stretches (KNN-CAD)", _QUIET, _LEARNING),
    "season": RegisteredDetector(Season, 0.7, "time of day"),
    "baseline": RegisteredDetector(Baseline, 0.5, "robust baseline"),
    "context": RegisteredDetector(Context, 0.7, "context"),
    "iqr": RegisteredDetector(Quartiles, 0.5, "quartiles"),
    "still": RegisteredDetector(Still, 0.5, "flat line"),
    "missing": RegisteredDetector(Missing, 0.5, "missing data"),
    "rate": RegisteredDetector(RateOfChange, 0.5, "rate of change"),
    "limits": RegisteredDetector(LimitsDetector, 0.5, "limits", learns=False),
}


def kind_of(watch: Watch, extensions: Mapping[str, DetectorExtension]) -> RegisteredDetector | None:
    """Give the kind of detector that a description asks for.

    Args:
        watch: what the description says.
        extensions: the detectors that are installed here beside ours.

    Returns:
        None for one that is not installed here.

    """
    if watch.detector is not DetectorKind.EXTENSION:
        return KINDS[watch.detector]
    found = extensions.get(watch.extension)
    if found is None:
        return None
    return RegisteredDetector(
        found.make, found.bar, found.summary, found.quiet, found.learning, found.learns
    )
