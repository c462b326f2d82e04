"""From things on single pictures to what was seen, from when to when.

Pure: told things and their times, it says when something comes into sight and when it is gone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.objects.detection import Detection

__all__ = ["ObjectSighting", "Sightings"]

# A detector errs on single pictures: something is there when it is seen this often within a
# moment, and gone when it is not seen for a while. Where pictures are rare both are longer: so
# many pictures.
HITS = 3
WITHIN_US = 1_500_000
GONE_US = 3_000_000
WITHIN_PICTURES, GONE_PICTURES = 4, 6
# Between two pictures a machine that is too busy may let this much pass, and is followed so far.
LONGEST_BETWEEN_US = 10_000_000
# What is told before its end is told again when it is surer by this.
SURER = 0.05


class ObjectSighting(NamedTuple):
    """Something of one class, as long as it was in sight.

    Attributes:
        label: the class's name.
        most: how many at once at the most.
        score: the surest.
        began_us, ended_us: UTC (µs); ``ended_us`` is none while it is in sight.

    """

    label: str
    most: int
    score: float
    began_us: int
    ended_us: int | None


class _Watch:
    """What is known of one class."""

    def __init__(self) -> None:
        # When it was seen sure enough (µs), before it is told; emptied when its sighting ends.
        self.hits: list[int] = []
        # As it was told last; none while nothing is open.
        self.told: ObjectSighting | None = None
        # When it was last seen (µs): the end of its sighting, not the moment that the end was
        # noticed.
        self.last_us = 0
        # The surest score and the most at once since the first hit.
        self.best, self.most = 0.0, 0

    def end_sighting(self, told: ObjectSighting) -> ObjectSighting:
        """End what was open, when it was last seen."""
        self.told, self.hits = None, []
        return told._replace(most=self.most, score=self.best, ended_us=self.last_us)


class Sightings:
    """Follow the classes that somebody wants to know of.

    Attributes:
        fresh: classes that the picture taken last shows surer than any before of the sighting.

    """

    def __init__(self, wanted: Sequence[str], least: float, rate: float = 10.0) -> None:
        """Follow classes, when they are as sure as ``least``, on ``rate`` pictures a second."""
        # What is less sure is not there at all (0 to 1).
        self._least = least
        # What is known of each wanted class.
        self._watches = {label: _Watch() for label in wanted}
        # Mean time between two pictures (µs), followed while they come, and the newest one's time.
        self._between_us = 1e6 / rate
        self._at_us: int | None = None
        # Set anew by each picture; `CameraObjects` cuts its thumbnails by it.
        self.fresh: frozenset[str] = frozenset()

    def add_picture(self, things: Sequence[Detection], at_us: int) -> list[ObjectSighting]:
        """Take what is on a picture, in order of time.

        Returns:
            Sightings that began, are surer or of more at once, or ended: one that goes on has no
            end yet.

        """
        # First, for the limits below are counted in pictures; then what is over, so that something
        # that comes back after a gap is another sighting.
        self._measure_pace(at_us)
        news = self.pass_time(at_us)
        fresh = set()
        for label, watch in self._watches.items():
            scores = [
                thing.score
                for thing in things
                if thing.label == label and thing.score >= self._least
            ]
            if scores:
                # Before the sighting is told, each picture that is the surest so far is kept for
                # it.
                before = watch.best if watch.told is not None else 0.0
                told = self._update_sighting(
                    label, watch, count=len(scores), score=max(scores), at_us=at_us
                )
                news += [] if told is None else [told]
                if watch.best > before and watch.best == max(scores):
                    fresh.add(label)
        self.fresh = frozenset(fresh)
        return news

    def pass_time(self, at_us: int) -> list[ObjectSighting]:
        """Give the sightings that are over because nothing was seen for a while."""
        gone_us = max(GONE_US, GONE_PICTURES * self._between_us)
        return [
            watch.end_sighting(watch.told)
            for watch in self._watches.values()
            if watch.told is not None and at_us - watch.last_us > gone_us
        ]

    def end_sightings(self) -> list[ObjectSighting]:
        """Give all that are still open as ended, for nobody looks any more."""
        return [
            watch.end_sighting(watch.told)
            for watch in self._watches.values()
            if watch.told is not None
        ]

    def _measure_pace(self, at_us: int) -> None:
        """Follow how far pictures are apart, a fifth of the way each time."""
        # A clock set back, or a camera that was off, says nothing of its pace.
        if self._at_us is not None and 0 < at_us - self._at_us <= LONGEST_BETWEEN_US:
            self._between_us += (at_us - self._at_us - self._between_us) / 5
        self._at_us = at_us

    def _update_sighting(
        self, label: str, watch: _Watch, *, count: int, score: float, at_us: int
    ) -> ObjectSighting | None:
        told = watch.told
        if told is None:
            within_us = max(WITHIN_US, WITHIN_PICTURES * self._between_us)
            # Hits with a later time are of before the clock was set back.
            watch.hits = [hit_us for hit_us in watch.hits if 0 <= at_us - hit_us <= within_us] + [
                at_us
            ]
            # Older hits have lapsed: what they saw is not of this sighting.
            if len(watch.hits) == 1:
                watch.best, watch.most = 0.0, 0
        watch.last_us = at_us
        watch.best, watch.most = max(watch.best, score), max(watch.most, count)
        if told is None:
            if len(watch.hits) < HITS:
                return None
            # It began with its first hit, though it took three to be believed.
            watch.told = ObjectSighting(label, watch.most, watch.best, watch.hits[0], None)
            return watch.told
        if watch.most > told.most or watch.best >= told.score + SURER:
            watch.told = told._replace(most=watch.most, score=watch.best)
            return watch.told
        return None
