"""From boxes on single pictures to what was seen, from when to when.

Pure: told boxes and their times, it says when something comes into sight and when it is gone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.gateway.objects.boxes import Box

__all__ = ["Counts", "Sighting", "Sightings"]

# A detector errs on single pictures: something is there when it is seen this often within a
# moment, and gone when it is not seen for a while.
HITS = 3
WITHIN_US = 1_500_000
GONE_US = 3_000_000

Counts = dict[str, int]


class Sighting(NamedTuple):
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
        self.hits: list[int] = []
        self.open: Sighting | None = None
        self.last_us = 0
        self.best, self.most = 0.0, 0

    def over(self, open_: Sighting) -> Sighting:
        """End what was open, when it was last seen."""
        self.open, self.hits = None, []
        return open_._replace(most=self.most, score=self.best, ended_us=self.last_us)


class Sightings:
    """Follow the classes that somebody wants to know of."""

    def __init__(self, classes: Sequence[str], wanted: Sequence[str], least: float) -> None:
        """Follow ``wanted`` of ``classes``, when they are as sure as ``least``."""
        self._classes, self._least = classes, least
        self._watches = {label: _Watch() for label in wanted}

    def take(self, boxes: Sequence[Box], at_us: int) -> tuple[Counts, list[Sighting]]:
        """Take what is on a picture, in order of time.

        Returns:
            How many of each wanted class there are, and sightings that began or ended: one that
            began has no end yet.

        """
        counts: Counts = dict.fromkeys(self._watches, 0)
        best: dict[str, float] = {}
        for box in boxes:
            label = self._classes[box.label]
            if label in counts and box.score >= self._least:
                counts[label] += 1
                best[label] = max(best.get(label, 0.0), box.score)
        news = []
        for label, watch in self._watches.items():
            if counts[label]:
                began = self._seen(label, watch, counts[label], best[label], at_us)
                news += [] if began is None else [began]
        return counts, news + self.pass_time(at_us)

    def pass_time(self, at_us: int) -> list[Sighting]:
        """Give the sightings that are over because nothing was seen for a while."""
        return [
            watch.over(watch.open)
            for watch in self._watches.values()
            if watch.open is not None and at_us - watch.last_us > GONE_US
        ]

    def end(self) -> list[Sighting]:
        """Give all that are still open as ended, for nobody looks any more."""
        return [
            watch.over(watch.open) for watch in self._watches.values() if watch.open is not None
        ]

    def _seen(
        self, label: str, watch: _Watch, count: int, score: float, at_us: int
    ) -> Sighting | None:
        if watch.open is not None and at_us - watch.last_us <= GONE_US:
            watch.last_us = at_us
            watch.best, watch.most = max(watch.best, score), max(watch.most, count)
            return None
        if watch.open is not None:
            return None  # it is over by time first; the next picture begins anew
        watch.hits = [each for each in watch.hits if 0 <= at_us - each <= WITHIN_US] + [at_us]
        if len(watch.hits) == 1:
            watch.best, watch.most = score, count
        watch.best, watch.most = max(watch.best, score), max(watch.most, count)
        watch.last_us = at_us
        if len(watch.hits) < HITS:
            return None
        watch.open = Sighting(label, watch.most, watch.best, watch.hits[0], None)
        return watch.open
