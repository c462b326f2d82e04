"""The lane before a vehicle, on drawn floors and on the simulator's."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.model.detection import FloorPoints, LaneView
from talaia.objects.floor_lines import FloorMapping
from talaia.objects.lane_finder import LaneFinder

pytestmark = pytest.mark.pure

ROWS, COLUMNS, FOCAL, HEIGHT, PITCH = 240, 320, 250.0, 0.35, math.radians(20)
METRES = ((0.6, 0.4), (0.6, -0.4), (2.0, -0.5), (2.0, 0.5))


def picture_of(x, y):
    """Give where a camera 0.35 m high that looks 20 degrees down sees a place of the floor."""
    ahead = x * math.cos(PITCH) + HEIGHT * math.sin(PITCH)
    below = HEIGHT * math.cos(PITCH) - x * math.sin(PITCH)
    return (0.5 - FOCAL * y / ahead / COLUMNS, 0.5 + FOCAL * below / ahead / ROWS)


def draw_floor(offset, heading, width, *, dashed=False, noise=6.0, light=True):
    """Draw the two markings of a lane as that camera sees them."""
    across, down = np.meshgrid(np.arange(COLUMNS) + 0.5, np.arange(ROWS) + 0.5)
    across, down = (across - COLUMNS / 2) / FOCAL, (down - ROWS / 2) / FOCAL
    fall = down * math.cos(PITCH) + math.sin(PITCH)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.where(fall > 1e-3, HEIGHT / fall, np.nan)
    x, y = away * (math.cos(PITCH) - down * math.sin(PITCH)), -away * across
    beside = offset + x * math.sin(heading) + y * math.cos(heading)
    along = x * math.cos(heading) - y * math.sin(heading)
    marked = np.abs(np.abs(beside) - width / 2) < 0.025
    if dashed:
        marked &= along % 1.0 < 0.6
    grey = np.where(np.isnan(away), 150.0, np.where(marked, 200.0, 90.0))
    grey = grey if light else 255 - grey
    grey = grey + np.random.default_rng(1).normal(0, noise, grey.shape)
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)


def finder(**more):
    """Make one for that camera."""
    points = tuple(picture_of(*point) for point in METRES)
    view = LaneView(floor=FloorPoints(picture=points, metres=METRES), **more)
    return LaneFinder(view, FloorMapping(points, METRES), (ROWS, COLUMNS))


FINDER = finder()


@settings(max_examples=25)
@given(
    st.floats(-0.15, 0.15), st.floats(-0.12, 0.12), st.floats(0.7, 1.0), st.booleans(),
    st.sampled_from([0.0, 6.0, 12.0]),
)  # fmt: skip
def test_the_vehicle_is_where_the_floor_was_drawn(offset, heading, width, dashed, noise) -> None:
    place = FINDER.find_lane(draw_floor(offset, heading, width, dashed=dashed, noise=noise))
    assert place is not None
    assert place.offset == pytest.approx(offset, abs=0.03)
    assert place.heading == pytest.approx(heading, abs=0.02)
    assert place.width == pytest.approx(width, abs=0.03)


def test_dark_markings_on_a_light_floor_are_found_by_whoever_asks_for_them() -> None:
    floor = draw_floor(0.1, 0.05, 1.0, light=False)
    place = finder(light=False).find_lane(floor)
    assert place is not None
    assert place.offset == pytest.approx(0.1, abs=0.03)
    assert FINDER.find_lane(floor) is None


@pytest.mark.parametrize("kind", ["bare", "noise", "one", "too narrow", "black"])
def test_where_there_is_no_lane_none_is_told(kind) -> None:
    random = np.random.default_rng(2)
    floors = {
        "bare": draw_floor(0, 0, 9.0),
        "noise": random.normal(100, 25, (ROWS, COLUMNS, 3)).clip(0, 255).astype(np.uint8),
        # The other marking is out of sight.
        "one": draw_floor(1.4, 0, 3.0),
        "too narrow": draw_floor(0, 0, 0.3),
        "black": np.zeros((ROWS, COLUMNS, 3), np.uint8),
    }
    assert FINDER.find_lane(floors[kind]) is None


def test_nothing_of_the_floor_in_sight_is_no_lane() -> None:
    points = tuple((x, y + 3.0) for x, y in (picture_of(*point) for point in METRES))
    view = LaneView(floor=FloorPoints(picture=points, metres=METRES))
    lost = LaneFinder(view, FloorMapping(points, METRES), (ROWS, COLUMNS))
    assert lost.find_lane(draw_floor(0, 0, 1.0)) is None
