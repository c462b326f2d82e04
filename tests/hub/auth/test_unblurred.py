"""Who may see what a blurred camera sees as it is: by its own right, at every door."""

import itertools

import pytest

from talaia.hub.auth.permissions import ANY, Grants, Permission, Right, may_tap, sees_unblurred
from talaia.hub.live.pictures.camera_viewer import Viewer
from talaia.model.topics import blurred_topics, carries_pictures
from talaia.model.yaml_text.load import load_site

SITE = load_site(
    """
talaia: 1
site: farm
name: Farm
ros2: {}
devices:
  gate:
    name: Gate
    streams:
      eye:
        name: E
        blur: {}
        source: {topic: /gate/image/compressed, type: sensor_msgs/msg/CompressedImage}
      back: {name: B, visibility: public, source: {topic: /back, type: sensor_msgs/msg/Image}}
  barn: {name: Barn}
topics:
  - {pattern: /**, right: view}
recording: {topics: [/gate/image, /odom], cameras: [gate/eye]}
"""
)
IMAGE, SCAN = "sensor_msgs/msg/Image", "sensor_msgs/msg/LaserScan"


def grants(*rights: Right, device: str = ANY) -> Grants:
    return Grants(frozenset(Permission(right, "farm", device) for right in rights))


def test_it_is_a_right_of_its_own_for_a_device_or_a_site_and_shows_nothing_by_itself() -> None:
    for held in Right:
        seen = sees_unblurred(grants(Right.VIEW, held), SITE, "gate", "eye")
        assert seen == (held in {Right.UNBLURRED, Right.ADMIN})
    assert not sees_unblurred(grants(Right.UNBLURRED), SITE, "gate", "eye")
    assert not sees_unblurred(
        grants(Right.VIEW, Right.UNBLURRED, device="barn"), SITE, "gate", "eye"
    )
    assert not sees_unblurred(grants(Right.ADMIN), SITE, "gate", "nothing")


@pytest.mark.parametrize(
    ("topic", "kind", "text", "whose"),
    [
        # The camera's own topic, and what image_transport makes of it, by their names.
        ("/gate/image/compressed", "", "", "gate"),
        ("/gate/image", "", "", "gate"),
        ("/gate/image/theora", "", "", "gate"),
        # Any other that carries pictures, by its type or by what is in it.
        ("/back", IMAGE, "", ANY),
        ("/debug", "foxglove_msgs/msg/CompressedVideo", "", ANY),
        ("/debug", "our_msgs/msg/Seen", "std_msgs/Header header\nsensor_msgs/Image[] shots", ANY),
        # What carries none is tapped as ever.
        ("/scan", SCAN, "# An Image of what is near\nfloat32[] ranges", ""),
        ("/scan", "", "", ""),
    ],
)
def test_raw_topics_with_pictures_take_it_where_a_camera_is_blurred(
    topic, kind, text, whose
) -> None:
    for held, device in itertools.product((None, Right.UNBLURRED), ("gate", "barn", ANY)):
        own = {Permission(held, "farm", device)} if held else set()
        everyone = Grants(frozenset({Permission(Right.VIEW), Permission(Right.TAP), *own}))
        allowed = not whose or (held is not None and device in {whose, ANY})
        assert may_tap(everyone, SITE, topic, type_name=kind, definition=text) == allowed
    # By itself it opens no topic.
    assert not may_tap(grants(Right.UNBLURRED), SITE, "/scan", type_name=SCAN)


def test_of_a_site_without_a_blurred_camera_nothing_changes() -> None:
    plain = load_site("{talaia: 1, site: farm, name: F, ros2: {}, devices: {gate: {name: G}}}")
    assert blurred_topics(plain) == {}
    assert may_tap(grants(Right.TAP), plain, "/back", type_name=IMAGE)


def test_nobody_gets_another_stream_by_its_name() -> None:
    def viewer(**asked: object) -> Viewer:
        return Viewer(None, who=None, site="farm", now_us=lambda: 0, text=False, **asked)  # type: ignore[arg-type]

    assert viewer(stream="gate/eye!unblurred").stream == "gate/eye"
    assert viewer(stream="gate/eye", unblurred=True).stream == "gate/eye!unblurred"
    assert viewer(stream="gate/eye!x", unblurred=True).stream == "gate/eye!unblurred"


def test_a_blurred_cameras_topic_is_filmed_and_not_recorded() -> None:
    assert SITE.recorded_topics() == ("/odom",)
    assert SITE.filmed_cameras() == ("gate/eye",)
    assert carries_pictures(IMAGE)
    assert not carries_pictures("sensor_msgs/msg/CameraInfo")
