"""Joints and poses in a robot's model, whatever its text is."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from talaia.model.discovery.probe_report import JointFound, PoseFound
from talaia.model.discovery.rules.urdf_joints import joints_in, poses_in

pytestmark = pytest.mark.pure
MODEL = """<?xml version="1.0" encoding="utf-8"?>
<robot name="r">
  <link name="a"/>
  <joint name="pan" type="revolute"><limit lower="-1" upper="2" velocity="3" effort="4"/></joint>
  <joint name="lift" type="prismatic"><limit upper="0.4" effort="9" velocity="0.1"/></joint>
  <joint name="wheel" type="continuous"/>
  <joint name="bolt" type="fixed"/>
  <joint name="odd" type="revolute"><limit lower="2" upper="-2" velocity="nan" effort="x"/></joint>
</robot>"""


def test_joints_that_move_have_their_ends_and_those_that_are_none_have_none() -> None:
    assert joints_in(MODEL) == (
        JointFound("pan", "revolute", -1.0, 2.0, 3.0, 4.0),
        # URDF's own: an end that is not told is 0.
        JointFound("lift", "prismatic", 0.0, 0.4, 0.1, 9.0),
        JointFound("wheel", "continuous"),
        JointFound("odd", "revolute"),
    )


def test_a_pose_counts_only_whole() -> None:
    text = (
        "<robot><group_state name='home' group='arm'><joint name='pan' value='0.5'/></group_state>"
        "<group_state name='bad' group='arm'><joint name='pan' value='0 1'/></group_state></robot>"
    )
    assert poses_in(text) == (PoseFound("home", "arm", {"pan": 0.5}),)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<robot>",
        "<sdf/>",
        "<!DOCTYPE robot [<!ENTITY a 'b'>]><robot><joint name='&a;' type='continuous'/></robot>",
        "<robot>" + " " * (4 * 1024 * 1024) + "</robot>",
    ],
)
def test_a_text_that_is_no_model_or_declares_something_has_no_joints(text: str) -> None:
    assert joints_in(text) == ()
    assert poses_in(text) == ()


@given(st.text())
def test_any_text_is_read_without_an_error(text: str) -> None:
    assert joints_in(text) == ()
    joints_in(f"<robot>{text}</robot>")
