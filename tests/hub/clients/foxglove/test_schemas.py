"""Well-known schemas have the fields that foxglove-sdk's have; a position is a pose and a frame."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from foxglove import messages
from google.protobuf import descriptor_pb2

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.foxglove.offer import make_foxglove_offer
from talaia.hub.clients.foxglove.schemas import (
    FRAME_SCHEMA,
    IMAGE_SCHEMA,
    VIDEO_SCHEMA,
    encode_picture,
)
from talaia.hub.clients.foxglove.signal_channels import SignalChannels
from talaia.model.yaml_text.load import load_site
from talaia.wire.browser import Subscribe, Unsubscribe, Values
from talaia.wire.columns import Columns, pack_columns

pytestmark = pytest.mark.pure

SITE = load_site("""
talaia: 1
site: agv
name: Vehicle
ros2: {}
devices:
  base:
    name: Base
    signals:
      pose: {name: Pose, type: position,
             source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.pose}}
      fix: {name: Fix, type: position, frame: wgs84,
            source: {topic: /fix, type: sensor_msgs/msg/NavSatFix}}
  arm:
    name: Arm
    signals:
      hand: {name: Hand, type: position,
             source: {topic: /h, type: geometry_msgs/msg/PoseStamped, field: pose}}
      goal: {name: Goal, type: position,
             source: {topic: /g, type: geometry_msgs/msg/PoseStamped, field: pose}}
""")
OFFER = make_foxglove_offer(SITE, Grants(frozenset({Permission(Right.VIEW)})))
KNOWN = [
    (OFFER.signals["/base/pose"].schema, "PoseInFrame"),
    (OFFER.signals["/base/fix"].schema, "LocationFix"),
    (IMAGE_SCHEMA, "CompressedImage"),
    (VIDEO_SCHEMA, "CompressedVideo"),
    (FRAME_SCHEMA, "FrameTransform"),
]


@pytest.mark.parametrize(("schema", "name"), KNOWN, ids=[name for _, name in KNOWN])
def test_well_known_schema_has_no_field_that_the_sdk_does_not_know(schema, name) -> None:
    theirs = getattr(messages, name).get_schema()
    assert schema.name == theirs.name
    files = descriptor_pb2.FileDescriptorSet.FromString(theirs.data).file
    types = {message.name: message for file in files for message in file.message_type}

    def compare(properties, message) -> None:
        fields = {field.name: field for field in message.field}
        assert properties.keys() <= fields.keys()
        for key, described in properties.items():
            # A time is written otherwise in JSON: sec and nsec.
            if key != "timestamp" and described.get("type") == "object":
                compare(described["properties"], types[fields[key].type_name.rpartition(".")[2]])

    compare(json.loads(schema.text)["properties"], types[name])
    # What a message has is what its schema says.
    if name in {"CompressedImage", "CompressedVideo"}:
        said = json.loads(encode_picture(b"jpeg", camera="eye", time_us=1))
        assert said.keys() == json.loads(schema.text)["properties"].keys()


def test_device_with_one_position_is_a_frame_and_with_several_each_position_is() -> None:
    frames = {topic: one.child for topic, one in OFFER.signals.items() if one.child}
    assert frames == {
        "/base/pose/frame": "base",
        "/arm/hand/frame": "arm/hand",
        "/arm/goal/frame": "arm/goal",
    }


def samples(sub: int, *rows) -> Values:
    packed = pack_columns(
        Columns(
            np.array([row[0] for row in rows], np.uint16),
            np.array([row[1] for row in rows], np.int64),
            np.array([row[2] for row in rows]),
            {},
        )
    )
    return Values(sub=sub, **packed._asdict())


def test_position_comes_as_pose_and_as_frame_to_who_wants_them() -> None:
    wanted = set()
    channels = SignalChannels("agv", wants=wanted.__contains__)
    channels.update_offer(OFFER)
    parts = ["base/pose.x", "base/pose.y", "base/pose.yaw"]
    wanted.add("/base/pose/frame")
    (first,) = channels.add_topics(["/base/pose/frame"])
    assert (type(first), first.channels) == (Subscribe, parts)
    rows = [(0, 5, 1.0), (1, 5, 2.0), (2, 5, math.pi)]
    (frame,) = channels.read_messages(samples(first.sub, *rows))
    said = json.loads(frame.data)
    assert (frame.topic, said["parent_frame_id"], said["child_frame_id"]) == (
        "/base/pose/frame", "local", "base",
    )  # fmt: skip
    assert said["translation"] == {"x": 1.0, "y": 2.0, "z": 0.0}
    assert said["rotation"]["z"] == pytest.approx(1)
    assert said.keys() == json.loads(FRAME_SCHEMA.text)["properties"].keys()

    # The newest values come once more, for the pose has had none.
    wanted.add("/base/pose")
    ended, second = channels.add_topics(["/base/pose"])
    assert (type(ended), ended.sub, second.channels) == (Unsubscribe, first.sub, parts)
    both = channels.read_messages(samples(second.sub, *rows))
    assert {message.topic for message in both} == {"/base/pose", "/base/pose/frame"}
    # One of the two ends, and the other one goes on.
    wanted.remove("/base/pose/frame")
    assert channels.remove_topics(["/base/pose/frame"]) == []
    (message,) = channels.read_messages(samples(second.sub, *((at, 6, 0.5) for at in range(3))))
    assert message.topic == "/base/pose"
    wanted.clear()
    assert channels.remove_topics(["/base/pose"]) == [Unsubscribe(sub=second.sub)]
