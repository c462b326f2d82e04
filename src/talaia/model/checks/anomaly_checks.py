"""Cross-checks of what is watched for anomalies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.alarms.anomaly import MOST_LETTERS, OPTIONS, DetectorKind, Watch
from talaia.model.checks.identifiers import Finding, id_fits

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["anomaly_findings"]

# Every detector knows these.
_ANY = {"detector", "bar", "rest"}


def anomaly_findings(where: str, watches: tuple[Watch, ...], *, number: bool) -> Iterator[Finding]:
    """List what does not fit in the detectors of one signal.

    Args:
        where: the signal's path.
        watches: as they stand in the description.
        number: whether the signal is a number.

    """
    if watches and not number:
        yield Finding(f"{where}.anomalies", "only numbers are watched", "leave it out")
    # Scores are channels named ``<signal>~<detector>``, so a detector stands there once.
    seen: set[str] = set()
    for index, watch in enumerate(watches):
        at = f"{where}.anomalies[{index}]"
        if watch.detector_name() in seen:
            yield Finding(
                f"{at}.detector",
                f"the detector '{watch.detector_name()}' stands here twice",
                "keep one of them",
            )
        seen.add(watch.detector_name())
        yield from _check_watch(at, watch)


def _check_watch(where: str, watch: Watch) -> Iterator[Finding]:
    if not 0.0 <= watch.bar <= 1.0:
        yield Finding(f"{where}.bar", f"expected 0 to 1, found {watch.bar:g}")
    if not 1 <= watch.rest <= 1_000_000:
        yield Finding(f"{where}.rest", f"expected 1 to 1000000 samples, found {watch.rest}")
    means = _ANY | set(OPTIONS.get(watch.detector, ()))
    for field in msgspec.structs.fields(Watch):
        # What stands at its default may have been written, but says nothing.
        if field.name in means or getattr(watch, field.name) == _default_of(field):
            continue
        owner = ", ".join(kind for kind, keys in OPTIONS.items() if field.name in keys)
        yield Finding(
            f"{where}.{field.name}",
            f"the detector '{watch.detector}' does not know '{field.name}'",
            f"it belongs to: {owner}",
        )
    for name in ("after", "within", "most"):
        if getattr(watch, name) < 0.0:
            yield Finding(f"{where}.{name}", f"expected 0 or more, found {getattr(watch, name):g}")
    if watch.k <= 0.0:
        yield Finding(f"{where}.k", f"expected more than 0, found {watch.k:g}")
    if watch.detector is DetectorKind.EXTENSION:
        yield from id_fits(f"{where}.extension", watch.extension)
        if len(watch.extension) > MOST_LETTERS:
            problem = f"a detector's name has at most {MOST_LETTERS} letters"
            yield Finding(f"{where}.extension", problem)
        if watch.extension in set(DetectorKind):
            problem = f"'{watch.extension}' is a detector of Talaia itself"
            yield Finding(f"{where}.extension", problem, f"write: detector: {watch.extension}")
    if watch.detector is DetectorKind.LIMITS:
        low, high = watch.minimum, watch.maximum
        if low is None and high is None:
            yield Finding(where, "limits without a limit", "give minimum, maximum or both")
        elif low is not None and high is not None and low >= high:
            yield Finding(f"{where}.minimum", f"{low:g} is not below the maximum, {high:g}")


def _default_of(field: msgspec.structs.FieldInfo) -> object:
    return field.default if field.default_factory is msgspec.NODEFAULT else field.default_factory()
