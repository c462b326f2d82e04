"""What is watched for anomalies, of one signal or of several: which detectors, from where on."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from talaia.model.base import Shape
from talaia.model.connection import ExtensionScalar  # noqa: TC001 - msgspec reads it

__all__ = ["MOST_LETTERS", "OPTIONS", "DetectorKind", "SignalGroup", "Watch"]

# Of the name of a detector that an extension brings.
MOST_LETTERS = 20


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
    # One that is installed at the hub; see `Watch.extension`.
    EXTENSION = "extension"


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
        extension: extension: the detector's name, as ``talaia extensions`` lists it at the hub.
        keys: extension: what it asks for, by its own names.

    """

    detector: DetectorKind
    bar: float = 0.0
    rest: int = 100
    # Tukey's 1.5 is for looking at a sample of values; of a stream it calls far too much.
    k: float = 6.0
    after: float = 0.0
    within: float = 0.0
    most: float = 0.0
    minimum: float | None = None
    maximum: float | None = None
    extension: str = ""
    keys: dict[str, ExtensionScalar] = {}

    def detector_name(self) -> str:
        """Name the detector: an extension by its own name."""
        return self.extension or str(self.detector)

    def __hash__(self) -> int:
        """Tell apart by all that is said, for what is kept by what watches."""
        # `keys` is a dict, for which msgspec's own hash would fail.
        return hash(msgspec.msgpack.encode(self))


class SignalGroup(Shape, frozen=True, kw_only=True):
    """Signals that are judged together; see `GroupDetector` at the hub.

    Attributes:
        name: what people call it; left out, its short name.
        signals: their addresses, ``device/signal``; numbers only.
        device: instead of these: the numbers of this device that stand on the first page.
        state: address of a state signal: what is usual is learned for each of its states.
        modes: without ``state``: at most so many ways of running are found by themselves.
        learn: it learns what is usual from so many steps, in each way of running.
        step: the signals are looked at together once in so long (s).
        bar: a score (0 to 1) from here on is an anomaly.

    """

    name: str = ""
    signals: tuple[str, ...] = ()
    device: str = ""
    state: str = ""
    modes: int = 1
    learn: int = 3600
    step: float = 1.0
    bar: float = 0.5


# Which keys mean something to which detector, besides `Watch.bar` and `Watch.rest`.
OPTIONS: dict[DetectorKind, tuple[str, ...]] = {
    DetectorKind.IQR: ("k",),
    DetectorKind.STILL: ("after", "within"),
    DetectorKind.MISSING: ("after",),
    DetectorKind.RATE: ("most",),
    DetectorKind.LIMITS: ("minimum", "maximum"),
    DetectorKind.EXTENSION: ("extension", "keys"),
}
