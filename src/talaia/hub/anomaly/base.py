"""What all detectors share: they see samples, give a score with a reason, and can be kept.

A detector is a struct of plain numbers and arrays, bounded however long it runs, so that its
state is the detector itself: `dump_detector` makes bytes of it and `load_detector` a detector of
the bytes.
"""

from __future__ import annotations

import copy
import math
from typing import Any, ClassVar, TypeVar, get_origin

import msgspec
import numpy as np
from numpy.typing import NDArray

__all__ = [
    "LARGEST",
    "SPREAD_OF_MEDIAN",
    "AnomalyDetector",
    "Floats",
    "clamp_value",
    "copy_detector",
    "dump_detector",
    "fading_peak",
    "format_duration",
    "format_number",
    "keep_newest",
    "load_detector",
]

Floats = NDArray[np.float64]
_NDARRAY = np.ndarray
# Squares of such values, and sums of them, still fit into a float.
LARGEST = 1e150
# Spread of a normal distribution, in its median absolute deviation.
SPREAD_OF_MEDIAN = 1.4826
# A peak of late fades so much with each sample; what is left of it after 0, 1, 2 … of them, for
# so many that nothing is left.
_FADING = 0.98
_FADED = _FADING ** np.arange(0.0, 2000.0)


class AnomalyDetector(msgspec.Struct, kw_only=True):
    """Sees one sample at a time and scores it; knows nothing of what comes. By itself it sees none.

    Attributes:
        unit: of the values, for the words.

    """

    # Whether `see_many` takes less time than one by one.
    faster_many: ClassVar[bool] = False
    unit: str = ""

    def see(self, time_us: int, value: float) -> float:
        """Take the next sample (µs since the epoch, a finite number); score it, 0 to 1."""
        return 0.0

    def see_many(self, times: NDArray[np.int64], values: Floats) -> Floats:
        """Take samples in their order (n,), as `see` does one by one; give their scores (n,)."""
        pairs = zip(times.tolist(), values.tolist(), strict=True)
        return np.array([self.see(time_us, value) for time_us, value in pairs])

    def magnitudes(self) -> tuple[float, ...]:
        """Give what the newest score stands on, without an upper end: by it scores are told apart.

        Empty where there is no such number; then no budget of false alarms is kept with it.
        """
        return ()

    def rate_many(self, times: NDArray[np.int64], values: Floats) -> tuple[Floats, Floats]:
        """Take samples as `see_many` does; give their scores (n,) and `magnitudes` (n, m)."""
        scores, rated = np.empty(len(values)), []
        for at, (time_us, value) in enumerate(zip(times.tolist(), values.tolist(), strict=True)):
            scores[at] = self.see(time_us, value)
            rated.append(self.magnitudes())
        return scores, np.array(rated, dtype=np.float64).reshape(len(values), -1)

    def idle(self, time_us: int) -> float:
        """Score that nothing has come up to now; most detectors have no opinion (0)."""
        return 0.0

    def why(self) -> str:
        """Say in words what the newest score stands on."""
        return "nothing is looked at"

    def forgive(self) -> bool:
        """Learn that the newest peak was not an anomaly; false where nothing can be learned."""
        return False


# Also of several signals, which see rows and are no `AnomalyDetector`.
D = TypeVar("D", bound=msgspec.Struct)


def _encode_value(thing: object) -> object:
    if isinstance(thing, _NDARRAY):
        # Little-endian whatever the machine, for the database may move to another one.
        return thing.astype("<f8").tobytes()
    raise TypeError(f"a detector holds a {type(thing).__name__}, which is not kept")


def _decode_value(kind: type, raw: object) -> object:
    if (get_origin(kind) or kind) is _NDARRAY and isinstance(raw, bytes):
        # A copy, for an array of bytes cannot be written to.
        return np.frombuffer(raw, "<f8").copy()
    raise TypeError(f"a detector holds a {kind}, which is not kept")


def dump_detector(detector: msgspec.Struct) -> bytes:
    """Make bytes of a detector and all it has learned."""
    return msgspec.msgpack.encode(detector, enc_hook=_encode_value)


def load_detector(kind: type[D], kept: bytes) -> D:
    """Make a detector of what `dump_detector` gave; ``msgspec.ValidationError`` for other bytes."""
    return msgspec.msgpack.decode(kept, type=kind, dec_hook=_decode_value)


def copy_detector(detector: D) -> D:
    """Copy a detector and all it has learned, in a tenth of what `copy.deepcopy` takes."""
    copied = copy.copy(detector)
    for name in detector.__struct_fields__:
        value = getattr(detector, name)
        # These are copied already; most fields are such.
        if type(value) not in (float, int, str):
            setattr(copied, name, _copy_value(value))
    return copied


def _copy_value(thing: Any) -> Any:  # noqa: ANN401 - of whatever kind a field is
    if isinstance(thing, _NDARRAY):
        return thing.copy()
    if isinstance(thing, msgspec.Struct):
        return copy_detector(thing)
    if isinstance(thing, list):
        return [_copy_value(one) for one in thing]
    # Numbers, words and tuples of them do not change.
    return thing


def clamp_value(value: float) -> float:
    """Give the value, or the largest whose square is still a number."""
    return min(max(value, -LARGEST), LARGEST)


def keep_newest(kept: Floats, end: int, values: Floats) -> int:
    """Write values behind those before them, as one by one; where it is full half of it goes.

    Args:
        kept: an even number of values, the newest of which ends before ``end``.
        end: one past the newest.
        values: what comes (n,).

    Returns:
        One past the newest of these.

    """
    half, at = len(kept) // 2, 0
    while at < len(values):
        if end == len(kept):
            kept[:half] = kept[half:]
            end = half
        upto = min(len(values), at + len(kept) - end)
        kept[end : end + upto - at] = values[at:upto]
        end, at = end + upto - at, upto
    return end


def fading_peak(peak: float, values: Floats) -> float:
    """Give the greatest of late after values have come (n,), from the one before them."""
    late = values[-len(_FADED) :]
    return max(peak * _FADING ** len(values), float((late * _FADED[len(late) - 1 :: -1]).max()))


def format_number(value: float) -> str:
    """Write a number as people read it: four digits that say something."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}"
    digits = max(0, 3 - math.floor(math.log10(abs(value))))
    text = f"{value:.{min(digits, 9)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def format_duration(seconds: float) -> str:
    """Write a length of time: ``40 s``, ``5 min``, ``2 h``, ``3 days``."""
    for name, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * length:
            return f"{seconds / length:.0f} {name}"
    return f"{seconds:.0f} s" if seconds >= 1.0 else f"{seconds * 1000:.0f} ms"
