"""The path of a rehearsal, and what would have been said of it."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.clock import SECOND
from talaia.gateway.driving.rehearsal import Rehearsal, TwinPose
from talaia.wire.frames import MOST_POSES, MOST_VERDICTS

pytestmark = pytest.mark.pure

numbers = st.floats(-1e3, 1e3)
poses = st.builds(TwinPose, numbers, numbers, st.floats(-math.pi, math.pi))


@given(st.lists(poses, min_size=1, max_size=600))
@settings(max_examples=examples(50, many=2000), deadline=None)
def test_a_path_is_bounded_and_ends_where_the_twin_is(walk: list[TwinPose]) -> None:
    rehearsal = Rehearsal()
    for number, pose in enumerate(walk):
        rehearsal.add_pose(pose, number * SECOND)
        assert len(rehearsal.path) <= MOST_POSES
        assert rehearsal.path[-1] == pose
    assert rehearsal.path[0] == walk[0]
    assert rehearsal.seconds == len(walk) - 1


@given(st.lists(st.tuples(poses, st.sampled_from(["", "rain", "wind"])), max_size=600))
@settings(max_examples=examples(50, many=2000), deadline=None)
def test_verdicts_are_bounded_and_stand_on_the_path(walk: list[tuple[TwinPose, str]]) -> None:
    rehearsal = Rehearsal()
    for number, (pose, why) in enumerate(walk):
        rehearsal.add_pose(pose, number * SECOND)
        rehearsal.add_verdict(why, 1.0)
    assert len(rehearsal.verdicts) <= MOST_VERDICTS
    places = [one.at for one in rehearsal.verdicts]
    assert places == sorted(places)
    assert all(place < len(rehearsal.path) for place in places)
    # Neighbours differ: only changes are told.
    whys = [one.why for one in rehearsal.verdicts]
    assert all(one != other for one, other in pairwise(whys))


def test_a_way_that_is_free_needs_no_word() -> None:
    rehearsal = Rehearsal()
    rehearsal.add_pose(TwinPose(0, 0, 0), 0)
    rehearsal.add_verdict("", 1.0)
    assert rehearsal.verdicts == []


def test_the_length_is_of_the_way_and_not_of_the_line_between_its_ends() -> None:
    rehearsal = Rehearsal()
    for x in (0.0, 1.0, 0.0):
        rehearsal.add_pose(TwinPose(x, 0, 0), 0)
    assert rehearsal.metres == pytest.approx(2.0)


def test_a_pose_that_is_no_number_is_left_out() -> None:
    rehearsal = Rehearsal()
    rehearsal.add_pose(TwinPose(math.nan, 0, 0), 0)
    assert rehearsal.path == []
