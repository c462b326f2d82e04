"""Which boxes of one picture after the other are the same thing.

Pure: things on pictures and their times in, numbers of tracks out.

A thing is followed as SORT does (Bewley et al. 2016, https://arxiv.org/abs/1602.00763): where its
box will be is foretold with a constant velocity by a Kalman filter, and boxes are given to tracks
so that they fit best in all. Boxes that are less sure only go on with what is there already
(ByteTrack, Zhang et al. 2021, https://arxiv.org/abs/2110.06864). What is lost, behind an obstacle
say, is found again within the reach of a walk, by its size and, where they are given, its colours.

Lengths are parts of the picture's width; heights are made so by its shape.

Long, because a track's whole life is told here: begun, followed, lost, and found again.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.objects.assignment import assign_pairs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.objects.detection import Detection

    Floats = NDArray[np.float64]

__all__ = ["FORGOTTEN_US", "HITS", "TrackedThing", "Tracker", "TrackerRule", "colours_of"]

# What is not seen for so long is another one when it comes again (µs).
FORGOTTEN_US = 8_000_000
# Seen so lately it is still in sight (µs): a detector misses now and then what is there.
_IN_SIGHT_US = 1_000_000
# Where pictures are rare both are longer: so many pictures.
_IN_SIGHT_PICTURES, _FORGOTTEN_PICTURES = 3, 6
# Between two pictures a machine that is too busy may let this much pass, and is followed so far.
_LONGEST_BETWEEN_US = 10_000_000
# Between two pictures a clock that jumps may seem to let days pass (s).
_LONGEST_STEP_S = 1.0
# Noise of the filter, for each part of the box's height: of where a box lies (1), of how much its
# velocity changes in a second (1/s). DeepSORT's are alike at 10 pictures a second.
_BOX_NOISE, _VELOCITY_NOISE = 0.05, 0.5
# A velocity at the first picture may be this (heights a second).
_FIRST_VELOCITY = 1.0
# Beyond so many tracks of a camera the longest unseen ones are forgotten.
_MOST_TRACKS = 200
# A detector errs on single pictures: a thing is there when it was seen so often.
HITS = 3
# Boxes that are nobody's are remembered, so many, to see where one came from: with no longer a gap
# between two of them (s), and heights that differ by no more.
_MOST_WEAK, _WEAK_GAP_S, _WEAK_SIZE = 100, 0.8, 1.25


class TrackerRule(NamedTuple):
    """How boxes are joined.

    Attributes:
        sure: what is less sure (0 to 1) begins no track, and only goes on with one.
        overlap: intersection over union that a box has with where it was awaited, at the least.
        near: or its middle is so near to where it was awaited (parts of its height).
        reach: so far may a lost one have gone in a second, beside where it was awaited (parts of
            its height).
        start: the same at once.
        size: a lost one that comes again is at the most so many times as high, or as low.
        colours: as unlike the colours of a lost one may be at the most, 0 to 1.
        forgotten_us: lost for longer, it is another one.

    """

    sure: float = 0.5
    overlap: float = 0.2
    near: float = 0.35
    reach: float = 0.45
    start: float = 0.6
    size: float = 1.6
    colours: float = 0.45
    forgotten_us: int = FORGOTTEN_US


class TrackedThing(NamedTuple):
    """A thing on a picture, and whose it is.

    Attributes:
        track: its number; the same on all pictures, never given twice. 0 where it is too unsure
            to be anybody's.
        hits: on how many pictures it was seen.
        thing: as the detector told it.
        foot: where it stands, the middle of the lower edge of its box (parts of the picture),
            steadier than the box itself.
        came: where it was seen first, if only by a box that was not sure; told on the picture on
            which it is believed.

    """

    track: int
    hits: int
    thing: Detection
    foot: tuple[float, float]
    came: tuple[float, float] | None = None


class _WeakBox(NamedTuple):
    """A box that was too unsure to be anybody's."""

    at_us: int
    label: str
    box: Floats


class _Seen(NamedTuple):
    """Of each thing on a picture its box (middle, width, height) and its colours; and the time."""

    boxes: Floats
    looks: Sequence[Floats | None]
    at_us: int


class _Track:
    """One thing: its filter, and when it was seen last."""

    def __init__(self, number: int, label: str, box: Floats, at_us: int) -> None:
        self.number, self.label = number, label
        # Middle (x, y), width, height: with a velocity each, and the covariance of the two, the
        # same filter four times.
        self.place, self.velocity = box.copy(), np.zeros(4)
        # In the order: of the place, of both together, of the velocity.
        noise = _BOX_NOISE * box[3]
        self.spread = np.array([noise**2, 0.0, (_FIRST_VELOCITY * box[3]) ** 2])
        # On how many pictures it was seen; when first and last; and for when it is foretold (µs).
        self.hits, self.began_us, self.last_us, self.at_us = 1, at_us, at_us, at_us
        # It may still turn out to be somebody who was lost.
        self.is_new = True
        # Its first box; and where it was seen first, until that is told.
        self.first = box
        self.came: tuple[float, float] | None = None
        # A slow mean, for light and pose change; none while they were never known.
        self.colours: Floats | None = None

    def predict_box(self, at_us: int) -> None:
        """Move on to a time."""
        step = min(max((at_us - self.at_us) / 1e6, 0.0), _LONGEST_STEP_S)
        self.at_us = at_us
        lost = (at_us - self.last_us) / 1e6
        # Who is covered may stop there: what is foretold slows down, and does not run away.
        pace = 1.0 if lost < 0.5 else 0.5 ** (2 * step)
        self.velocity = self.velocity * pace
        # A box does not grow while nobody sees it.
        self.velocity[2:] *= 1.0 if lost < 0.5 else 0.0
        self.place = self.place + self.velocity * step
        place, both, speed = self.spread
        more = (_VELOCITY_NOISE * self.place[3]) ** 2
        self.spread = np.array(
            [
                place + 2 * step * both + step * step * speed + more * step**3 / 3,
                both + step * speed + more * step**2 / 2,
                speed + more * step,
            ]
        )

    def correct_box(self, box: Floats, at_us: int, colours: Floats | None) -> None:
        """Take a box that is its own."""
        place, both, speed = self.spread
        noise = (_BOX_NOISE * box[3]) ** 2
        # How much of the miss the place takes, and how much the velocity.
        gain, follow = place / (place + noise), both / (place + noise)
        miss = box - self.place
        if at_us - self.last_us > 1_500_000:
            # Found again: where it was in between, nobody knows, nor how fast.
            self.place, self.velocity = box.copy(), np.zeros(4)
            self.spread = np.array([noise, 0.0, (_FIRST_VELOCITY * box[3]) ** 2])
        else:
            self.place = self.place + gain * miss
            self.velocity = self.velocity + follow * miss
            self.spread = np.array([(1 - gain) * place, (1 - gain) * both, speed - follow * both])
        self.hits, self.last_us = self.hits + 1, at_us
        if colours is not None:
            known = self.colours
            self.colours = colours if known is None else 0.9 * known + 0.1 * colours


class Tracker:
    """Follows the things on one camera. For one thread at a time."""

    def __init__(
        self, rule: TrackerRule | None = None, *, rate: float = 10.0, shape: float = 0.75
    ) -> None:
        """Know of nothing yet.

        Args:
            rule: how boxes are joined.
            rate: pictures a second, until some have come.
            shape: the picture's height for its width.

        """
        self._rule = rule or TrackerRule()
        # Mean time between two pictures (µs), followed while they come.
        self._between_us = 1e6 / rate
        self._shape = shape
        # In sight, or lost and not forgotten.
        self._tracks: list[_Track] = []
        # Nobody's boxes of the last moment, in order of time.
        self._weak: deque[_WeakBox] = deque(maxlen=_MOST_WEAK)
        self._given = 0  # The number given last.
        self._at_us = 0  # Time of the newest picture.

    @property
    def between_us(self) -> float:
        """Mean time between two pictures (µs)."""
        return self._between_us

    @property
    def in_sight_us(self) -> float:
        """How long after it was seen something is still in sight (µs)."""
        return max(_IN_SIGHT_US, _IN_SIGHT_PICTURES * self._between_us)

    @property
    def forgotten_us(self) -> float:
        """How long after it was seen something is another one when it comes again (µs)."""
        return max(self._rule.forgotten_us, _FORGOTTEN_PICTURES * self._between_us)

    def add_picture(
        self,
        things: Sequence[Detection],
        at_us: int,
        colours: Sequence[Floats | None] | None = None,
    ) -> list[TrackedThing]:
        """Take what is on a picture, in order of time.

        Args:
            things: what the detector told of it, in any order.
            at_us: when it was taken (µs). An earlier time than the last one's, of a clock that was
                set back, is taken as if no time had passed.
            colours: of each thing, see `colours_of`; without them place and size alone count.

        Returns:
            Of each thing in the same order, whose it is.

        """
        self._pass_time(at_us)
        boxes = np.array([self._box_of(thing) for thing in things]).reshape(-1, 4)
        looks = list(colours) if colours is not None else [None] * len(things)
        whose: dict[int, _Track] = {}
        # A class by itself: a detector's boxes of a rider and of the bicycle lie over each other.
        for label in dict.fromkeys(thing.label for thing in things):
            mine = [at for at, thing in enumerate(things) if thing.label == label]
            whose |= self._join_class(mine, things, _Seen(boxes, looks, at_us))
        return [self._tracked(thing, whose.get(at)) for at, thing in enumerate(things)]

    def _tracked(self, thing: Detection, track: _Track | None) -> TrackedThing:
        if track is None:
            return TrackedThing(0, 0, thing, ((thing.left + thing.right) / 2, thing.bottom))
        came, track.came = track.came, None
        # By the filter: boxes tremble, and who stands at a line would cross it all the time.
        return TrackedThing(track.number, track.hits, thing, self._foot_of(track.place), came)

    def _foot_of(self, box: Floats) -> tuple[float, float]:
        x, y, _, height = box
        return float(x), float((y + height / 2) / self._shape)

    def _pass_time(self, at_us: int) -> None:
        if at_us < self._at_us:
            # A clock set back: tracks are as old as they were.
            back = self._at_us - at_us
            for track in self._tracks:
                track.last_us, track.at_us = track.last_us - back, track.at_us - back
                track.began_us -= back
        elif self._at_us and at_us - self._at_us <= _LONGEST_BETWEEN_US:
            # A fifth of the way each time; a camera that was off says nothing of its pace.
            self._between_us += (at_us - self._at_us - self._between_us) / 5
        self._at_us = at_us
        self._tracks = [
            track
            for track in self._tracks
            if at_us - track.last_us <= self.forgotten_us
            # One box that was never there again was none.
            and (track.hits >= HITS or at_us - track.last_us <= self.in_sight_us)
        ]
        for track in self._tracks:
            track.predict_box(at_us)

    def _join_class(
        self,
        mine: list[int],
        things: Sequence[Detection],
        seen_now: _Seen,
    ) -> dict[int, _Track]:
        """Give each thing of a class its track."""
        boxes, looks, at_us = seen_now
        label = things[mine[0]].label
        sure = [at for at in mine if things[at].score >= self._rule.sure]
        weak = [at for at in mine if things[at].score < self._rule.sure]
        tracks = [track for track in self._tracks if track.label == label]
        seen = [track for track in tracks if at_us - track.last_us <= self.in_sight_us]
        whose: dict[int, _Track] = {}

        def join(candidates: list[_Track], rest: list[int], costs: Floats) -> None:
            for row, column in assign_pairs(costs):
                track, at = candidates[row], rest[column]
                whose[at] = track
                track.correct_box(boxes[at], at_us, looks[at])

        # What is sure first: a weak box must not take a track from a sure one.
        join(seen, sure, self._costs_in_sight(seen, boxes[sure]))
        left = [track for track in seen if track not in whose.values()]
        join(left, weak, self._costs_in_sight(left, boxes[weak]))
        for at in sure:
            if at not in whose:
                whose[at] = self._begin_track(label, boxes[at], at_us, looks[at])
        self._find_again(label, whose, at_us)
        self._weak.extend(_WeakBox(at_us, label, boxes[at]) for at in weak if at not in whose)
        return whose

    def _find_again(self, label: str, whose: dict[int, _Track], at_us: int) -> None:
        """Give what has just been seen often enough to be believed the number of who was lost.

        Not at its first box: a detector errs on single pictures, and a lost one would go there.
        """
        new = [at for at, track in whose.items() if track.hits == HITS and track.is_new]
        lost = [
            track
            for track in self._tracks
            if track.label == label and track.hits >= HITS and track.last_us < at_us
        ]
        costs = self._costs_lost(lost, [whose[at] for at in new], at_us)
        for row, column in assign_pairs(costs):
            track, old = whose[new[column]], lost[row]
            track.number, track.hits = old.number, track.hits + old.hits
            if old.colours is not None and track.colours is not None:
                track.colours = 0.5 * (old.colours + track.colours)
            self._tracks.remove(old)
        for at in new:
            # Who was lost has a way of their own already.
            if whose[at].hits == HITS:
                whose[at].came = self._trace_back(whose[at])
            whose[at].is_new = False

    def _trace_back(self, track: _Track) -> tuple[float, float]:
        """Find where boxes that were not sure show a thing before its first sure one.

        Who comes into the picture is seen in part at first, and a detector is not sure of that.
        """
        at_us, box = track.began_us, track.first
        for weak in reversed(self._weak):
            gap_s = (at_us - weak.at_us) / 1e6
            if weak.label != track.label or gap_s <= 0:
                continue
            apart = np.hypot(*(weak.box[:2] - box[:2])) / box[3]
            size = weak.box[3] / box[3]
            near = apart <= self._rule.near + self._rule.reach * gap_s
            if gap_s <= _WEAK_GAP_S and near and 1 / _WEAK_SIZE <= size <= _WEAK_SIZE:
                at_us, box = weak.at_us, weak.box
        return self._foot_of(box)

    def _begin_track(self, label: str, box: Floats, at_us: int, look: Floats | None) -> _Track:
        self._given += 1
        track = _Track(self._given, label, box, at_us)
        track.colours = look
        self._tracks.append(track)
        if len(self._tracks) > _MOST_TRACKS:
            self._tracks.remove(min(self._tracks, key=lambda one: one.last_us))
        return track

    def _costs_in_sight(self, tracks: Sequence[_Track], boxes: Floats) -> Floats:
        """Rows of tracks, columns of boxes; infinite where they cannot be the same."""
        if not tracks or not len(boxes):
            return np.zeros((len(tracks), len(boxes)))
        awaited = np.array([track.place for track in tracks])
        overlap = overlaps(awaited, boxes)
        apart = _distances(awaited, boxes)
        fits = (overlap >= self._rule.overlap) | (apart <= self._rule.near)
        # Overlap decides; where there is none for thin boxes that are fast, nearness does.
        return np.where(fits, (1 - overlap) + 0.5 * apart, np.inf)

    def _costs_lost(self, lost: Sequence[_Track], new: Sequence[_Track], at_us: int) -> Floats:
        if not lost or not new:
            return np.zeros((len(lost), len(new)))
        rule = self._rule
        awaited = np.array([track.place for track in lost])
        boxes = np.array([track.place for track in new])
        lost_s = np.array([(at_us - track.last_us) / 1e6 for track in lost])
        reach = rule.start + rule.reach * lost_s
        apart = _distances(awaited, boxes) / reach[:, None]
        ratio = boxes[None, :, 3] / np.maximum(awaited[:, None, 3], 1e-9)
        fits = (apart <= 1) & (ratio <= rule.size) & (ratio >= 1 / rule.size)
        unlike = np.array([[_apart_of(one, other) for other in new] for one in lost])
        # Who was seen while the new one was there already is somebody else.
        fits &= np.array([[one.last_us < other.began_us for other in new] for one in lost])
        fits &= unlike <= rule.colours
        return np.where(fits, apart + 2 * unlike, np.inf)

    def _box_of(self, thing: Detection) -> tuple[float, float, float, float]:
        return (
            (thing.left + thing.right) / 2,
            (thing.top + thing.bottom) / 2 * self._shape,
            max(thing.right - thing.left, 1e-4),
            max((thing.bottom - thing.top) * self._shape, 1e-4),
        )


def overlaps(ones: Floats, others: Floats) -> Floats:
    """Intersection over union of boxes (middle, width, height): rows of ones, columns of others."""
    half, other_half = ones[:, None, 2:] / 2, others[None, :, 2:] / 2
    middle, other_middle = ones[:, None, :2], others[None, :, :2]
    low = np.maximum(middle - half, other_middle - other_half)
    high = np.minimum(middle + half, other_middle + other_half)
    shared = np.prod(np.maximum(high - low, 0), axis=2)
    areas = np.prod(ones[:, None, 2:], axis=2) + np.prod(others[None, :, 2:], axis=2)
    return np.asarray(shared / np.maximum(areas - shared, 1e-12))


def _distances(awaited: Floats, boxes: Floats) -> Floats:
    """Between middles, in parts of the awaited box's height."""
    apart = np.hypot(*(awaited[:, None, at] - boxes[None, :, at] for at in (0, 1)))
    return np.asarray(apart / np.maximum(awaited[:, None, 3], 1e-9))


def colours_of(rgb: NDArray[np.uint8], thing: Detection) -> Floats | None:
    """Give the colours of the middle of a thing: shares of 8 hues by 3 lights, sum 1.

    None of a thing too small to tell.
    """
    height, width = rgb.shape[:2]
    wide, high = thing.right - thing.left, thing.bottom - thing.top
    # The middle half: what is around a thing is the room's.
    left, right = (thing.left + wide * part for part in (0.25, 0.75))
    top, bottom = (thing.top + high * part for part in (0.15, 0.85))
    cut = rgb[int(top * height) : int(bottom * height), int(left * width) : int(right * width)]
    by = max(1, min(cut.shape[:2]) // 24)
    cut = cut[::by, ::by].reshape(-1, 3).astype(np.float64)
    if len(cut) < 16:
        return None
    light, dark = cut.max(axis=1), cut.min(axis=1)
    # A colour that is nearly grey has no hue that the lamp would not change.
    grey = (light - dark) < 0.2 * np.maximum(light, 1)
    # Hue as the angle in the plane across grey.
    red, green, blue = cut.T
    angle = np.arctan2(np.sqrt(3) * (green - blue), 2 * red - green - blue)
    hue = ((angle / (2 * np.pi) % 1) * 8).astype(int) % 8
    kind = np.where(grey, 8, hue) * 3 + np.minimum((light / 86).astype(int), 2)
    counted = np.bincount(kind, minlength=27).astype(np.float64)
    return np.asarray(counted / counted.sum())


def colours_apart(one: Floats, other: Floats) -> float:
    """Say how unlike two are, 0 to 1 (Hellinger distance)."""
    same = float(np.sqrt(one * other).sum())
    return float(np.sqrt(max(0.0, 1.0 - same)))


def _apart_of(one: _Track, other: _Track) -> float:
    """Say how unlike the colours of two are; not at all where they are not known."""
    if one.colours is None or other.colours is None:
        return 0.0
    return colours_apart(one.colours, other.colours)
