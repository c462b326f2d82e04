"""What tracks do: how long they dwell in zones, which lines they cross, how fast they are. Pure.

For one camera. A thing is where it stands: see `TrackedThing.foot`.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.detection import Measured
from talaia.objects.floor_lines import FloorMapping, LineCounter, is_inside

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.detection import Detect, DetectionSource
    from talaia.objects.tracker import TrackedThing

__all__ = ["CONFIRMED", "Movements", "Story", "ZoneVisit"]

Point = tuple[float, float]
# A detector errs on single pictures: a thing is there when it was seen so often.
CONFIRMED = 3
# Speed is measured over so long (µs): from picture to picture a box trembles.
_SPEED_US = 1_000_000
# Out of a zone for less than this it has not left (µs): at its edge a box trembles.
_LEFT_US = 1_000_000
# A path has so many points at the most; then every other one goes.
MOST_POINTS = 64
_FIRST_EVERY_US = 500_000
# Crossings that are remembered for signals that count those of the last while.
_MOST_CROSSINGS = 10_000


class ZoneVisit(NamedTuple):
    """Of one thing in one zone: how often it came in, and how long it was there in all (s)."""

    entries: int
    dwell_s: float


class Story(NamedTuple):
    """What one thing has done.

    Attributes:
        path: where it stood: time (UTC, µs), and the place by parts of the picture.
        zones: by what the zones are called.
        crossings: by what the lines are called: how often to the left, and to the right.
        speed: mean on the floor (m/s); none where that is not known.

    """

    path: tuple[tuple[int, float, float], ...] = ()
    zones: tuple[tuple[str, ZoneVisit], ...] = ()
    crossings: tuple[tuple[str, int, int], ...] = ()
    speed: float | None = None

    def path_on_picture(self) -> list[tuple[int, float, float]]:
        """Give the path with every place on the picture; a filter's may lie a little beside it."""
        return [(us, min(max(x, 0.0), 1.0), min(max(y, 0.0), 1.0)) for us, x, y in self.path]


class _Stay:
    """One thing in one zone."""

    def __init__(self, at_us: int) -> None:
        # How often it came in, and how long the visits before this one took (s).
        self.entries, self.before_s = 1, 0.0
        # In the zone from the one to the other, at the last visit (µs).
        self.came_us = self.last_us = at_us

    def enter_zone(self, at_us: int, gone_us: float) -> None:
        """Be in the zone."""
        if at_us - self.last_us > gone_us:
            self.before_s += (self.last_us - self.came_us) / 1e6
            self.entries, self.came_us = self.entries + 1, at_us
        self.last_us = at_us

    @property
    def visit(self) -> ZoneVisit:
        """All of it."""
        return ZoneVisit(self.entries, self.before_s + (self.last_us - self.came_us) / 1e6)


class _Mover:
    """One thing, as long as it is followed."""

    def __init__(self, label: str) -> None:
        # Its class, and when it was seen last (µs).
        self.label, self.last_us = label, 0
        # Time and place of each point, and how far they are apart in time (µs).
        self.path: list[tuple[int, float, float]] = []
        self.every_us = _FIRST_EVERY_US
        # By zone, and by line: how often to the left and to the right.
        self.stays: dict[str, _Stay] = {}
        self.crossings: dict[str, list[int]] = {}
        # Where it stood on the floor lately: when, and where (m).
        self.floor: deque[tuple[int, Point]] = deque()
        # Now (m/s); and of all of its way, for the mean.
        self.speed = 0.0
        self.metres = self.seconds = 0.0

    def keep_place(self, foot: Point, at_us: int) -> None:
        """Add to the path."""
        if self.path and at_us - self.path[-1][0] < self.every_us:
            return
        self.path.append((at_us, round(foot[0], 4), round(foot[1], 4)))
        if len(self.path) > MOST_POINTS:
            self.path, self.every_us = self.path[::2], self.every_us * 2

    def keep_floor(self, place: Point, at_us: int) -> None:
        """Measure the speed by where it was a second ago."""
        self.floor.append((at_us, place))
        while len(self.floor) > 2 and at_us - self.floor[1][0] >= _SPEED_US:
            self.floor.popleft()
        since_us, (x, y) = self.floor[0]
        seconds = (at_us - since_us) / 1e6
        if seconds >= _SPEED_US / 2e6:
            metres = float(((place[0] - x) ** 2 + (place[1] - y) ** 2) ** 0.5)
            self.speed = metres / seconds
            part = (at_us - self.floor[-2][0]) / 1e6
            self.metres, self.seconds = self.metres + self.speed * part, self.seconds + part


class Movements:
    """All that is followed on one camera. For one thread at a time."""

    def __init__(self, detect: Detect) -> None:
        """Take the camera's zones, lines and floor; `Detect` has been checked."""
        # As people call them, for stories.
        self._zone_names = {name: zone.name for name, zone in detect.zones.items()}
        self._line_names = {name: line.name for name, line in detect.lines.items()}
        self._zones = {name: zone.points for name, zone in detect.zones.items()}
        self._lines = {name: LineCounter(line.points) for name, line in detect.lines.items()}
        floor = detect.floor
        self._plan = None if floor is None else FloorMapping(floor.picture, floor.metres)
        # By track; forgotten some time after it.
        self._movers: dict[int, _Mover] = {}
        # How often in all, by line, class and side; and when, for those of the last while.
        self._counts: dict[tuple[str, str, int], int] = {}
        self._crossed: deque[tuple[int, str, str, int]] = deque(maxlen=_MOST_CROSSINGS)
        # Time of the newest picture, and how long before it something is still there (µs).
        self._at_us = 0
        self._in_sight_us = 0.0

    def add_picture(
        self, tracked: Sequence[TrackedThing], at_us: int, in_sight_us: float, forgotten_us: float
    ) -> None:
        """Take whose things are on a picture.

        Args:
            tracked: see `Tracker.add_picture`.
            at_us: when it was taken.
            in_sight_us: see `Tracker.in_sight_us`.
            forgotten_us: see `Tracker.forgotten_us`.

        """
        if at_us < self._at_us:
            # A clock set back: what was measured by it would be negative.
            self._movers.clear()
            self._crossed.clear()
        self._at_us, self._in_sight_us = at_us, in_sight_us
        for number in [
            number
            for number, mover in self._movers.items()
            # Kept a little longer than its sighting, which asks for its story at the end.
            if at_us - mover.last_us > 2 * forgotten_us
        ]:
            del self._movers[number]
        for one in tracked:
            if one.hits >= CONFIRMED and one.track:
                self._follow_thing(one, at_us)

    def _follow_thing(self, one: TrackedThing, at_us: int) -> None:
        foot = one.foot
        mover = self._movers.setdefault(one.track, _Mover(one.thing.label))
        mover.last_us = at_us
        mover.keep_place(foot, at_us)
        for name, points in self._zones.items():
            if is_inside(points, foot):
                if name not in mover.stays:
                    mover.stays[name] = _Stay(at_us)
                mover.stays[name].enter_zone(at_us, max(_LEFT_US, self._in_sight_us))
        for name, line in self._lines.items():
            if one.came is not None:
                # Who comes in may have crossed it before they were believed.
                line.move_track(one.track, one.came, at_us)
            side = line.move_track(one.track, foot, at_us)
            if side:
                mover.crossings.setdefault(name, [0, 0])[0 if side > 0 else 1] += 1
                key = (name, mover.label, side)
                self._counts[key] = self._counts.get(key, 0) + 1
                self._crossed.append((at_us, *key))
        place = None if self._plan is None else self._plan.to_floor(foot)
        if place is not None:
            mover.keep_floor(place, at_us)

    def value_of(self, source: DetectionSource) -> float:
        """Say what a signal tells that does not count things on the picture alone."""
        if source.measure in (Measured.LEFT, Measured.RIGHT):
            key = (source.line, source.sees, 1 if source.measure is Measured.LEFT else -1)
            if not source.over:
                return float(self._counts.get(key, 0))
            since_us = self._at_us - source.over * 1e6
            return float(sum(when >= since_us for when, *one in self._crossed if key == (*one,)))
        here = [
            mover
            for mover in self._movers.values()
            if mover.label == source.sees
            and self._at_us - mover.last_us <= self._in_sight_us
            and (not source.zone or self._is_in(mover, source.zone))
        ]
        if source.measure is Measured.DWELL:
            stays = [mover.stays[source.zone] for mover in here]
            return max(((self._at_us - stay.came_us) / 1e6 for stay in stays), default=0.0)
        return max((mover.speed for mover in here), default=0.0)

    def _is_in(self, mover: _Mover, zone: str) -> bool:
        stay = mover.stays.get(zone)
        return stay is not None and self._at_us - stay.last_us <= max(_LEFT_US, self._in_sight_us)

    def story_of(self, track: int) -> Story:
        """Tell what a thing has done so far."""
        mover = self._movers.get(track)
        if mover is None:
            return Story()
        return Story(
            tuple(mover.path),
            tuple((self._zone_names[name], stay.visit) for name, stay in mover.stays.items()),
            tuple(
                (self._line_names[name], left, right)
                for name, (left, right) in mover.crossings.items()
            ),
            mover.metres / mover.seconds if mover.seconds > 0 else None,
        )
