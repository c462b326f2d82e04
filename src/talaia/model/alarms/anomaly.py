"""What of a signal is watched for anomalies: which detectors, told from where on."""

from __future__ import annotations

from enum import StrEnum

from talaia.model.base import Shape

__all__ = ["OPTIONS", "DetectorKind", "Watch"]


class DetectorKind(StrEnum):
    """The detectors; every part downstream knows each."""

    TOGETHER = "together"
    CHANGE = "change"
    NEAREST = "nearest"
    SEASON = "season"
    BASELINE = "baseline"
    CONTEXT = "context"
    IQR = "iqr"
    STILL = "still"
    MISSING = "missing"
    RATE = "rate"
    LIMITS = "limits"


class Watch(Shape, frozen=True, kw_only=True):
    """One detector on a signal.

    Attributes:
        bar: a score (0 to 1) from here on is an anomaly; 0 takes the detector's own.
        rest: after one began, no other begins for so many samples.
        k: iqr: so many times the distance of the quartiles beyond them.
        after: still, missing: so long is too long (s); 0 learns it.
        within: still: a change up to this is none, in the signal's unit.
        most: rate: so fast is too fast, in the signal's unit a second; 0 learns it.
        minimum: limits: below is an anomaly, in the signal's unit.
        maximum: limits: above is an anomaly, in the signal's unit.

    """

    detector: DetectorKind
    bar: float = 0.0
    rest: int = 100
    k: float = 1.5
    after: float = 0.0
    within: float = 0.0
    most: float = 0.0
    minimum: float | None = None
    maximum: float | None = None


# Which keys mean something to which detector, besides `Watch.bar` and `Watch.rest`.
OPTIONS: dict[DetectorKind, tuple[str, ...]] = {
    DetectorKind.IQR: ("k",),
    DetectorKind.STILL: ("after", "within"),
    DetectorKind.MISSING: ("after",),
    DetectorKind.RATE: ("most",),
    DetectorKind.LIMITS: ("minimum", "maximum"),
}
