"""From things that are followed to what was seen, from when to when: one sighting for each thing.

Pure: told whose things are on a picture, it says when one comes into sight and when it is gone.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.objects.tracker import TrackedThing

__all__ = ["ObjectSighting", "Sightings"]

# A detector errs on single pictures: something is there when it is seen this often within a
# moment. Where pictures are rare that is longer: so many pictures.
HITS = 3
WITHIN_US = 1_500_000
WITHIN_PICTURES = 4
# What is told before its end is told again when it is surer by this.
SURER = 0.05
# So many begins are remembered, so that no two of a class are told of the same microsecond.
_BEGINS = 200


class ObjectSighting(NamedTuple):
    """One thing, as long as it was in sight.

    Attributes:
        label: the class's name.
        most: how many of the class were in sight at once meanwhile, at the most.
        score: the surest.
        began_us, ended_us: UTC (µs); ``ended_us`` is none while it is in sight. No two of a class
            begin in the same microsecond.
        track: the tracker's number of it.

    """

    label: str
    most: int
    score: float
    began_us: int
    ended_us: int | None
    track: int = 0


class _Watch:
    """What is known of one thing."""

    def __init__(self, label: str) -> None:
        self.label = label
        # When it was seen sure enough (µs), before it is told.
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
        return told._replace(most=self.most, score=self.best, ended_us=self.last_us)


class Sightings:
    """Follow the things of the classes that somebody wants to know of.

    Attributes:
        fresh: tracks that the picture taken last shows surer than any before of the sighting.

    """

    def __init__(self, wanted: Sequence[str], least: float) -> None:
        """Follow classes, when they are as sure as ``least``."""
        self._wanted = frozenset(wanted)
        # What is less sure does not begin a sighting (0 to 1); it goes on with one.
        self._least = least
        # By track.
        self._watches: dict[int, _Watch] = {}
        self._begins: deque[tuple[str, int]] = deque(maxlen=_BEGINS)
        # Set anew by each picture; `CameraObjects` cuts its thumbnails by it.
        self.fresh: frozenset[int] = frozenset()

    def add_picture(
        self, tracked: Sequence[TrackedThing], at_us: int, between_us: float, gone_us: float
    ) -> list[ObjectSighting]:
        """Take whose things are on a picture, in order of time.

        Args:
            tracked: see `Tracker.add_picture`.
            at_us: when it was taken.
            between_us: the mean time between two pictures.
            gone_us: see `Tracker.forgotten_us`.

        Returns:
            Sightings that began, are surer or of more at once, or ended: one that goes on has no
            end yet.

        """
        # First what is over, for a track is never seen again then.
        news = self.pass_time(at_us, gone_us)
        fresh = set()
        seen = [one for one in tracked if one.track and one.thing.label in self._wanted]
        for one in seen:
            watch = self._watches.get(one.track)
            if watch is None:
                watch = self._watches[one.track] = _Watch(one.thing.label)
            elif one.thing.score < self._least and watch.told is None:
                continue
            # Before the sighting is told, each picture that is the surest so far is kept for it.
            before = watch.best if watch.told is not None else 0.0
            many = sum(other.thing.label == one.thing.label for other in seen)
            told = self._update_sighting(watch, one, (many, at_us), between_us)
            news += [] if told is None else [told]
            if watch.best > before and watch.best == one.thing.score:
                fresh.add(one.track)
        self.fresh = frozenset(fresh)
        return news

    def pass_time(self, at_us: int, gone_us: float) -> list[ObjectSighting]:
        """Give the sightings that are over because nothing was seen for a while."""
        return self._end_watches(
            [n for n, watch in self._watches.items() if at_us - watch.last_us > gone_us]
        )

    def end_sightings(self) -> list[ObjectSighting]:
        """Give all that are still open as ended, for nobody looks any more."""
        return self._end_watches(list(self._watches))

    def _end_watches(self, over: Sequence[int]) -> list[ObjectSighting]:
        watches = [self._watches.pop(number) for number in over]
        return [watch.end_sighting(watch.told) for watch in watches if watch.told is not None]

    def _update_sighting(
        self, watch: _Watch, one: TrackedThing, seen: tuple[int, int], between_us: float
    ) -> ObjectSighting | None:
        count, at_us = seen
        told, score = watch.told, one.thing.score
        if told is None:
            within_us = max(WITHIN_US, WITHIN_PICTURES * between_us)
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
            began_us = self._free_begin(watch.label, watch.hits[0])
            watch.told = ObjectSighting(
                watch.label, watch.most, watch.best, began_us, None, one.track
            )
            return watch.told
        if watch.most > told.most or watch.best >= told.score + SURER:
            watch.told = told._replace(most=watch.most, score=watch.best)
            return watch.told
        return None

    def _free_begin(self, label: str, began_us: int) -> int:
        """Give the begin, or the next microsecond: two may come into sight on one picture."""
        while (label, began_us) in self._begins:
            began_us += 1
        self._begins.append((label, began_us))
        return began_us
