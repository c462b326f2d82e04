"""One camera as something that sees: what is there, what it does, and a picture of each.

Pure but for the JPEG of a thumbnail. For one thread at a time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.detection import Measured
from talaia.objects.floor_lines import is_inside
from talaia.objects.movements import Movements, Story
from talaia.objects.sightings import ObjectSighting, Sightings
from talaia.objects.tracker import Tracker, TrackerRule, colours_of

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
# Cut out and not told yet, of so many things at the most.
MOST_MOMENTS = 50


class SightingNews(NamedTuple):
    """News of a sighting.

    Attributes:
        thumbnail: JPEG of its surest moment; empty where it was told before.
        story: what it has done so far.

    """

    sighting: ObjectSighting
    thumbnail: bytes
    story: Story = Story()


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
        # Says whose each box is. What is a little less sure than counts goes on with a track.
        self._tracker = Tracker(TrackerRule(sure=detect.confidence), rate=detect.max_rate)
        self._movements = Movements(detect)
        # What comes into sight and goes; counts do not wait for it.
        self._sightings = Sightings(detect.classes, detect.confidence)
        # The best picture of each track that is in sight, until its sighting is reported.
        self._moments: dict[int, NDArray[np.uint8]] = {}

    def apply_counts(self, counted: Mapping[str, DetectionSource]) -> None:
        """Count for these signals from here on; what is in sight stays so."""
        self._counted = dict(counted)

    def count_things(self, things: Sequence[Detection]) -> dict[str, float]:
        """Say what each signal tells of a picture, which `add_picture` has taken just before."""
        # What is tracked (dwell, crossings, speed) is of all pictures so far; plain counts are of
        # this one, so that they say what the boxes on it show.
        # Drawn from `SHOWN_FROM` on, counted from the description's confidence on.
        sure = [thing for thing in things if thing.score >= self._detect.confidence]
        return {
            name: float(sum(counts_as(source, thing, self._detect) for thing in sure))
            if source.measure is Measured.COUNT
            else self._movements.value_of(source)
            for name, source in self._counted.items()
        }

    def add_picture(
        self,
        things: Sequence[Detection],
        rgb: NDArray[np.uint8] | None,
        at_us: int,
        colours: Sequence[NDArray[np.float64] | None] | None = None,
    ) -> list[SightingNews]:
        """Take what is on a picture (rows × columns × 3), in order of time; give what is new.

        Args:
            things: what the detector told of it.
            rgb: of which thumbnails may be shown; none of the picture is shown to anybody where
                it is not given.
            at_us: when it was taken (UTC, µs).
            colours: of each thing, where they are known from elsewhere; see `colours_of`.

        """
        if colours is None and rgb is not None:
            colours = [colours_of(rgb, thing) for thing in things]
        tracker = self._tracker
        tracked = tracker.add_picture(things, at_us, colours)
        self._movements.add_picture(tracked, at_us, tracker.in_sight_us, tracker.forgotten_us)
        # First: only it knows which tracks this picture shows best.
        news = self._sightings.add_picture(tracked, at_us, tracker.between_us, tracker.forgotten_us)
        if rgb is not None:
            for one in tracked:
                if one.track in self._sightings.fresh:
                    self._moments[one.track] = cut_out(rgb, one.thing)
        return self._with_pictures(news)

    def pass_time(self, at_us: int) -> list[SightingNews]:
        """Give what is over because no picture showed it, or none came, for a while."""
        return self._with_pictures(self._sightings.pass_time(at_us, self._tracker.forgotten_us))

    def end_sightings(self) -> list[SightingNews]:
        """Give all that is in sight as ended, for nobody looks any more."""
        return self._with_pictures(self._sightings.end_sightings())

    def _with_pictures(self, news: Sequence[ObjectSighting]) -> list[SightingNews]:
        told = []
        for sighting in news:
            # Told once with a picture; a later one comes only when a surer moment was cut out
            # meanwhile.
            moment = self._moments.pop(sighting.track, None)
            story = self._movements.story_of(sighting.track)
            told.append(SightingNews(sighting, b"" if moment is None else jpeg_of(moment), story))
        # Of tracks that were never believed.
        while len(self._moments) > MOST_MOMENTS:
            del self._moments[next(iter(self._moments))]
        return told


def counts_as(source: DetectionSource, thing: Detection, detect: Detect) -> bool:
    """Tell whether a signal counts a thing: its class, and where it stands."""
    if thing.label != source.sees:
        return False
    # Where it stands: the middle of the box's lower edge.
    if source.zone:
        zone = detect.zones.get(source.zone)
        foot = ((thing.left + thing.right) / 2, thing.bottom)
        return zone is not None and is_inside(zone.points, foot)
    if source.within is None:
        return True
    left, top, right, bottom = source.within
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
