"""One camera as something that sees: how many there are, what came into sight, and a picture of it.

Pure but for the JPEG of a thumbnail. For one thread at a time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.objects.sightings import ObjectSighting, Sightings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from talaia.model.detection import Detect, DetectionSource
    from talaia.objects.detection import Detection

__all__ = ["MOST_THUMBNAIL", "SHOWN_FROM", "CameraObjects", "SightingNews", "counts_as", "least_of"]

# What is drawn on a page may be less sure than what counts.
SHOWN_FROM = 0.3
# A thumbnail: at the most so many bytes (the wire takes three times as many, yet it stands before
# other words on a narrow line), no longer than this (px), and of the box's surroundings so much on
# each side (of its size, and at the least px).
MOST_THUMBNAIL = 20 * 1024
THUMBNAIL_PX = 240
AROUND, AROUND_PX = 0.25, 16
QUALITIES = (80, 60, 40, 20)


class SightingNews(NamedTuple):
    """News of a sighting, and a JPEG of its surest moment; empty where it was told before."""

    sighting: ObjectSighting
    thumbnail: bytes


def least_of(detect: Detect) -> float:
    """Say how sure a box must be to be told at all."""
    return min(SHOWN_FROM, detect.confidence)


class CameraObjects:
    """What is seen on one camera."""

    def __init__(self, detect: Detect, counted: Mapping[str, DetectionSource]) -> None:
        """Take what is to be seen.

        Args:
            detect: the camera's.
            counted: by whatever names them: the sources of signals that count what it sees.

        """
        # The camera's keys; with others the owner makes another instance.
        self._detect = detect
        # Sources by signal; changed by `apply_counts` alone.
        self._counted = dict(counted)
        # What comes into sight and goes; counts do not wait for it.
        self._sightings = Sightings(detect.classes, detect.confidence, detect.max_rate)
        # The best picture of each class that is in sight, until its sighting is reported.
        self._moments: dict[str, NDArray[np.uint8]] = {}

    def apply_counts(self, counted: Mapping[str, DetectionSource]) -> None:
        """Count for these signals from here on; what is in sight stays so."""
        self._counted = dict(counted)

    def count_things(self, things: Sequence[Detection]) -> dict[str, int]:
        """Say how many each signal counts on one picture."""
        # Drawn from `SHOWN_FROM` on, counted from the description's confidence on.
        sure = [thing for thing in things if thing.score >= self._detect.confidence]
        return {
            name: sum(counts_as(source, thing) for thing in sure)
            for name, source in self._counted.items()
        }

    def add_picture(
        self, things: Sequence[Detection], rgb: NDArray[np.uint8] | None, at_us: int
    ) -> list[SightingNews]:
        """Take what is on a picture (rows × columns × 3), in order of time; give what is new.

        None of the picture is shown to anybody where ``rgb`` is not given.
        """
        # First: only it knows which classes this picture shows best.
        news = self._sightings.add_picture(things, at_us)
        for label in self._sightings.fresh:
            if rgb is None:
                continue
            best = max(
                (thing for thing in things if thing.label == label), key=lambda one: one.score
            )
            self._moments[label] = cut_out(rgb, best)
        return self._with_pictures(news)

    def pass_time(self, at_us: int) -> list[SightingNews]:
        """Give what is over because no picture showed it, or none came, for a while."""
        return self._with_pictures(self._sightings.pass_time(at_us))

    def end_sightings(self) -> list[SightingNews]:
        """Give all that is in sight as ended, for nobody looks any more."""
        return self._with_pictures(self._sightings.end_sightings())

    def _with_pictures(self, news: Sequence[ObjectSighting]) -> list[SightingNews]:
        told = []
        for sighting in news:
            # Told once with a picture; a later one comes only when a surer moment was cut out
            # meanwhile.
            moment = self._moments.pop(sighting.label, None)
            told.append(SightingNews(sighting, b"" if moment is None else jpeg_of(moment)))
        return told


def counts_as(source: DetectionSource, thing: Detection) -> bool:
    """Tell whether a signal counts a thing: its class, and where it stands."""
    if thing.label != source.sees:
        return False
    if source.within is None:
        return True
    left, top, right, bottom = source.within
    # Where it stands: the middle of the box's lower edge.
    return left <= (thing.left + thing.right) / 2 <= right and top <= thing.bottom <= bottom


def cut_out(rgb: NDArray[np.uint8], thing: Detection) -> NDArray[np.uint8]:
    """Cut a thing and a little around it out of a picture, thinned to a thumbnail."""
    height, width = rgb.shape[:2]

    def span(low: float, high: float, size: int) -> slice:
        # A share of the box, and at the least some pixels: a far thing is shown with its
        # surroundings.
        more = max((high - low) * size * AROUND, AROUND_PX)
        first = int(np.clip(low * size - more, 0, max(0, size - 1)))
        return slice(first, int(np.clip(high * size + more, first + 1, size)))

    cut = rgb[span(thing.top, thing.bottom, height), span(thing.left, thing.right, width)]
    # Every n-th pixel, rounded up: the longer side is never above the limit.
    by = -(-max(cut.shape[:2]) // THUMBNAIL_PX)
    return np.ascontiguousarray(cut[::by, ::by])


def jpeg_of(rgb: NDArray[np.uint8]) -> bytes:
    """Write a thumbnail; empty where it cannot be made small enough, or no encoder is there."""
    try:
        # An extra; without it sightings are told, only without pictures.
        import simplejpeg
    except ImportError:
        return b""
    for quality in QUALITIES:
        data: bytes = simplejpeg.encode_jpeg(rgb, quality=quality, colorspace="RGB")
        if len(data) <= MOST_THUMBNAIL:
            return data
    return b""
