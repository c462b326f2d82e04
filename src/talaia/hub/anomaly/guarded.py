"""A detector that an extension brings, held so that it harms nobody but itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from talaia.hub.anomaly.base import AnomalyDetector

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from talaia.extensions.declarations import DetectorExtension
    from talaia.hub.anomaly.base import Floats
    from talaia.model.alarms.anomaly import Watch

__all__ = ["MOST_FAILURES", "SLOW_S", "GuardedDetector", "extension_detector"]

# After so many errors, or samples that took too long, it is asked no more until the hub starts
# anew or its entry of the description changes.
MOST_FAILURES = 3
# All other detectors and all pages wait as long (s).
SLOW_S = 0.05


class GuardedDetector:
    """Asks an extension's detector, and takes no harm from what it answers.

    Attributes:
        detector: the extension's own.
        off: why it is asked no more; empty while it is.

    """

    faster_many = False

    def __init__(self, detector: AnomalyDetector, fail: Callable[[str], None]) -> None:
        """Tell ``fail`` in words what goes wrong."""
        self.detector = detector
        self.off = ""
        # Tells people what fails.
        self._fail = fail
        # Errors and slow samples so far.
        self._failures = 0

    def see(self, time_us: int, value: float) -> float:
        """See `AnomalyDetector.see`; 0 while it cannot say."""
        return self._guarded_score(lambda: self.detector.see(time_us, value))

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """See `AnomalyDetector.see_many`: one by one, for each is bounded by itself."""
        pairs = zip(times.tolist(), values.tolist(), strict=True)
        return np.array([self.see(time_us, value) for time_us, value in pairs])

    def idle(self, time_us: int) -> float:
        """See `AnomalyDetector.idle`; 0 while it cannot say."""
        return self._guarded_score(lambda: self.detector.idle(time_us))

    def why(self) -> str:
        """See `AnomalyDetector.why`."""
        try:
            return str(self.detector.why())[:500]
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            self.record_failure(f"it fails to say why: {type(error).__name__}: {error}")
            return "the detector does not say why"

    def forgive(self) -> bool:
        """See `AnomalyDetector.forgive`."""
        try:
            return bool(self.detector.forgive())
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            self.record_failure(f"it fails to learn: {type(error).__name__}: {error}")
            return False

    def record_duration(self, seconds: float) -> None:
        """Take note how long it looked at one sample (s)."""
        if seconds > SLOW_S:
            self.record_failure(f"it took more than {SLOW_S * 1000:.0f} ms for one sample")

    def record_failure(self, problem: str) -> None:
        """Count a failure; the last one that is borne ends it."""
        self._failures += 1
        self._fail(problem)
        if self._failures >= MOST_FAILURES and not self.off:
            self.off = problem
            self._fail(f"it is asked no more after {MOST_FAILURES} failures")

    def _guarded_score(self, ask: Callable[[], float]) -> float:
        if self.off:
            return 0.0
        try:
            score = float(ask())
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            # One that fails counts as calm: an extension must not raise alarms by its faults.
            self.record_failure(f"it fails: {type(error).__name__}: {error}")
            return 0.0
        if math.isnan(score):
            self.record_failure("its score is no number")
            return 0.0
        return min(1.0, max(0.0, score))


def extension_detector(watch: Watch, unit: str, declared: DetectorExtension) -> AnomalyDetector:
    """Make an extension's detector as a description asks for it.

    Raises:
        Exception: its keys do not fit, or whatever the extension raises.

    """
    keys = msgspec.convert(watch.keys, declared.keys)
    detector = declared.make(unit=unit, **msgspec.structs.asdict(keys))
    if not isinstance(detector, AnomalyDetector):
        raise TypeError(f"it makes a {type(detector).__name__}, which is no Detector")
    return detector
