"""Zones, lines and the floor: what things on a camera do."""

import pytest

from talaia.model.detection import (
    Detect,
    DetectionSource,
    FloorPoints,
    Measured,
    PictureLine,
    PictureZone,
)
from talaia.objects.detection import Detection
from talaia.objects.floor_lines import FloorMapping, LineCounter, is_inside
from talaia.objects.movements import MOST_POINTS, Movements, ZoneVisit
from talaia.objects.tracker import TrackedThing

pytestmark = pytest.mark.pure
STEP = 100_000
CORNERS = ((0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8))
HALL = Detect(
    zones={"mat": PictureZone(name="Mat", points=((0.4, 0.0), (0.6, 0.0), (0.6, 1.0), (0.4, 1.0)))},
    lines={"door": PictureLine(name="Door", points=((0.5, 1.0), (0.5, 0.0)))},
    # The picture's 0.6 are 6 m of floor.
    floor=FloorPoints(picture=CORNERS, metres=((0, 0), (6, 0), (6, 6), (0, 6))),
)


def source(**about: object) -> DetectionSource:
    return DetectionSource(stream="front", sees="person", **about)  # type: ignore[arg-type]


def at_place(x: float, y: float = 0.5, track: int = 1) -> TrackedThing:
    return TrackedThing(track, 9, Detection("person", 0.8, x, y, x, y), (x, y))


class Moving:
    """Movements on ten pictures a second."""

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self.movements, self.at_us = Movements(HALL), 0

    def show(self, *tracked: TrackedThing) -> None:
        self.at_us += STEP
        self.movements.add_picture(tracked, self.at_us, 1_000_000, 8_000_000)

    def walk(self, start: float, to: float, pictures: int) -> None:
        for at in range(pictures):
            self.show(at_place(start + (to - start) * at / (pictures - 1)))

    def value(self, **about: object) -> float:
        return self.movements.value_of(source(**about))


def test_a_polygon_holds_what_is_inside_of_it_also_where_it_is_bent() -> None:
    bent = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.2), (0.0, 1.0))
    assert is_inside(bent, (0.1, 0.5))
    assert not is_inside(bent, (0.5, 0.8))
    assert is_inside(CORNERS, (0.5, 0.5))
    assert not is_inside(CORNERS, (0.9, 0.5))


def test_crossings_are_counted_by_direction_and_those_of_the_last_while_alone() -> None:
    moving = Moving()
    moving.walk(0.1, 0.9, 40)
    assert (moving.value(line="door", measure=Measured.LEFT),
            moving.value(line="door", measure=Measured.RIGHT)) == (0, 1)  # fmt: skip
    moving.walk(0.9, 0.1, 40)
    assert (moving.value(line="door", measure=Measured.LEFT),
            moving.value(line="door", measure=Measured.RIGHT)) == (1, 1)  # fmt: skip
    assert moving.value(line="door", measure=Measured.RIGHT, over=3.0) == 0
    assert moving.value(line="door", measure=Measured.LEFT, over=3.0) == 1
    assert moving.movements.story_of(1).crossings == (("Door", 1, 1),)


def test_who_was_hardly_seen_before_the_line_has_crossed_it_and_who_turns_round_has_not() -> None:
    moving = Moving()
    # Sure only beyond the line; of the other nobody has seen anything before it.
    moving.show(at_place(0.52)._replace(came=(0.4, 0.5)), at_place(0.55, track=2))
    assert moving.value(line="door", measure=Measured.RIGHT) == 1
    assert moving.movements.story_of(1).crossings == (("Door", 0, 1),)
    # Back to where they were before: that is seen, and counted as ever.
    for x in (0.55, 0.52, 0.45):
        moving.show(at_place(x), at_place(0.55, track=2))
    assert moving.value(line="door", measure=Measured.LEFT) == 1
    # Seen on this side first, and turned round before the line.
    moving.show(at_place(0.45, track=3)._replace(came=(0.3, 0.5)))
    for x in (0.48, 0.45, 0.3):
        moving.show(at_place(x, track=3))
    assert moving.value(line="door", measure=Measured.RIGHT) == 1


def test_one_who_sways_on_a_line_and_one_who_goes_around_its_end_do_not_cross_it() -> None:
    counter = LineCounter([(0.5, 1.0), (0.5, 0.5)])
    swaying = [
        counter.move_track(1, (x, 0.7), at) for at, x in enumerate([0.45, 0.503, 0.497, 0.505])
    ]
    assert swaying == [0, 0, 0, 0]
    around = [
        counter.move_track(2, foot, 9) for foot in [(0.4, 0.8), (0.4, 0.3), (0.6, 0.3), (0.6, 0.8)]
    ]
    assert around == [0, 0, 0, 0]


def test_dwell_goes_on_while_somebody_is_in_the_zone_and_is_kept_with_the_story() -> None:
    moving = Moving()
    moving.walk(0.1, 0.3, 5)
    assert moving.value(zone="mat", measure=Measured.DWELL) == 0
    for _ in range(31):
        moving.show(at_place(0.5))
    assert moving.value(zone="mat", measure=Measured.DWELL) == pytest.approx(3.0)
    # Missed for a moment is not gone.
    for _ in range(5):
        moving.show()
    assert moving.value(zone="mat", measure=Measured.DWELL) == pytest.approx(3.5)
    for _ in range(20):
        moving.show(at_place(0.9))
    assert moving.value(zone="mat", measure=Measured.DWELL) == 0
    for _ in range(11):
        moving.show(at_place(0.5))
    ((name, visit),) = moving.movements.story_of(1).zones
    assert (name, visit.entries) == ("Mat", 2)
    assert visit == ZoneVisit(2, pytest.approx(4.0))


def test_speed_is_in_metres_a_second_on_the_floor() -> None:
    moving = Moving()
    # 0.4 of the picture in 4 s: 1 m/s.
    moving.walk(0.3, 0.7, 41)
    assert moving.value(measure=Measured.SPEED) == pytest.approx(1.0, abs=0.02)
    assert moving.movements.story_of(1).speed == pytest.approx(1.0, abs=0.02)
    for _ in range(30):
        moving.show()
    assert moving.value(measure=Measured.SPEED) == 0


def test_a_floor_seen_aslant_is_measured_by_its_four_points() -> None:
    plan = FloorMapping(
        [(0.3, 0.5), (0.7, 0.5), (1.0, 1.0), (0.0, 1.0)], [(0, 4), (2, 4), (2, 0), (0, 0)]
    )
    assert plan.to_floor((0.3, 0.5)) == pytest.approx((0, 4))
    assert plan.to_floor((0.5, 1.0)) == pytest.approx((1, 0))
    # Where the picture shows no floor.
    assert plan.to_floor((0.5, 0.05)) is None
    with pytest.raises(ValueError, match="one line"):
        FloorMapping([(0, 0), (0.5, 0.5), (1, 1), (0, 1)], [(0, 0), (1, 0), (1, 1), (0, 1)])


def test_a_long_path_is_thinned_and_keeps_its_begin() -> None:
    moving = Moving()
    for _ in range(10):
        moving.walk(0.1, 0.9, 200)
    path = moving.movements.story_of(1).path
    assert len(path) <= MOST_POINTS
    assert path[0] == (STEP, 0.1, 0.5)
    assert path[-1][0] > 150_000_000


def test_a_clock_that_is_set_back_gives_no_negative_times() -> None:
    moving = Moving()
    for _ in range(30):
        moving.show(at_place(0.5))
    moving.at_us = 0
    moving.show(at_place(0.5))
    assert moving.value(zone="mat", measure=Measured.DWELL) == 0
