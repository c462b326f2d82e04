"""Rights that include one another, and the one to raw topics that stands beside them."""

from __future__ import annotations

import pytest

from talaia.hub.auth.permissions import Grants, Permission, Right, seen_camera
from talaia.model.yaml_text.load import load_site

PLACES = [("*", "*"), ("agv", "*"), ("agv", "base")]


def test_the_right_to_tap_comes_with_admin_and_with_nothing_else() -> None:
    for held in Right:
        grants = Grants(frozenset({Permission(held)}))
        assert grants.has_right(Right.TAP, "agv") == (held in {Right.TAP, Right.ADMIN})
    tap = Grants(frozenset({Permission(Right.TAP)}))
    assert not any(tap.has_right(right, "agv") for right in Right if right is not Right.TAP)
    assert tap.rights_on("agv", "base") == []


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("ours", Right)
@pytest.mark.parametrize("theirs", Right)
def test_what_is_left_of_two_rights_is_never_more_than_either(ours, theirs, place) -> None:
    held = Grants(frozenset({Permission(ours, *place)}))
    given = frozenset({Permission(theirs)})
    left = held.limited_to(given)
    for right in Right:
        expected = held.has_right(right, "agv", "base") and Grants(given).has_right(
            right, "agv", "base"
        )
        assert left.has_right(right, "agv", "base") == expected


def test_a_calibration_names_its_camera_to_whoever_may_see_it() -> None:
    site = load_site(
        """
talaia: 1
site: agv
name: A
ros2: {}
devices:
  base:
    name: Base
    streams: {front: {name: Front, source: {topic: /front/image, type: sensor_msgs/msg/Image}}}
  gate: {name: Gate}
"""
    )

    def named(right: Right, device: str, topic: str = "/front/camera_info") -> str:
        grants = Grants(frozenset({Permission(right, "agv", device)}))
        return seen_camera(grants, site, topic, "sensor_msgs/msg/CameraInfo")

    assert named(Right.VIEW, "base") == "base/front"
    # Raw topics are another right, and another device has other cameras.
    assert named(Right.TAP, "*") == named(Right.VIEW, "gate") == ""
    assert named(Right.VIEW, "base", "/rear/camera_info") == ""
