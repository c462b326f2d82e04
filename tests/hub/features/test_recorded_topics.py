"""Messages of a recording are read at a moment: whose topics they are, and what lies beyond."""

from __future__ import annotations

import json
import struct

import msgspec
import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from talaia.wire.browser import SiteUpdate

from ..conftest import DESCRIPTION
from .test_recordings import files

SECOND_US = 1_000_000
BEGIN_US = 1_767_268_800_000_000
RULES = """
recording: {}
topics:
  - {pattern: /odom, right: view}
  - {pattern: /secret, right: admin}
"""
AT = "/api/sites/agv/recorded-topics"
STORE = get_typestore(Stores.ROS2_HUMBLE)
ODOM = "nav_msgs/msg/Odometry"
CALIBRATION = "/front/camera_info"


def odometry(x):
    """Give an odometry as rosbags serializes it: another's code."""
    types = STORE.types
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    zero = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    made = types[ODOM](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="odom"),
        child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](
            pose=types["geometry_msgs/msg/Pose"](
                position=types["geometry_msgs/msg/Point"](x=x, y=0.0, z=0.0),
                orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            ),
            covariance=np.zeros(36),
        ),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            twist=types["geometry_msgs/msg/Twist"](linear=zero, angular=zero),
            covariance=np.zeros(36),
        ),
    )
    return bytes(STORE.serialize_cdr(made, ODOM))


def foreign_bag(tmp_path, seconds=30):
    """Record odometry at 5 Hz and a secret as rosbags does: another's writer of MCAP."""
    folder = tmp_path / "bag"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        odom = bag.add_connection("/odom", ODOM, typestore=STORE)
        secret = bag.add_connection("/secret", "std_msgs/msg/String", typestore=STORE)
        for n in range(5 * seconds):
            bag.write(odom, (BEGIN_US + n * 200_000) * 1000, odometry(n / 5))
        bag.write(secret, BEGIN_US * 1000, b"\0\1\0\0" + struct.pack("<I", 3) + b"ha\0")
        kind = "sensor_msgs/msg/CameraInfo"
        calibration = bag.add_connection(CALIBRATION, kind, typestore=STORE)
        bag.write(calibration, BEGIN_US * 1000, b"\0\1\0\0")
    return next(folder.glob("*.mcap")).read_bytes()


@pytest.fixture
async def looked_back(hub, tmp_path):
    """Give a hub with one recording of half a minute, and a gateway that is there."""
    gateway = await hub.gateway()
    # Beside the calibration in its namespace.
    await gateway.hello(DESCRIPTION.replace("topic: /images", "topic: /front/images") + RULES)
    hub.linked = gateway
    bag = foreign_bag(tmp_path)
    link = await files(hub)
    done = await link.bring(bag, begin_us=BEGIN_US, end_us=BEGIN_US + 30 * SECOND_US)
    assert done.done, done
    return hub


async def asked(hub, path, who="operator", **query):
    answer = await (await hub.client(who)).get(AT + path, params=query)
    assert answer.status_code == 200, answer.text
    return answer.json()


async def test_messages_of_a_foreign_recording_are_trees_at_their_own_moment(looked_back) -> None:
    found = await asked(
        looked_back,
        "/messages",
        topic="/odom",
        from_us=BEGIN_US + 10 * SECOND_US,
        to_us=BEGIN_US + 11 * SECOND_US,
    )
    trees = [json.loads(message["tree"]) for message in found["messages"]]
    # The last one before the stretch, and the five of its second.
    assert [tree["pose"]["pose"]["position"]["x"] for tree in trees] == [
        9.8, 10.0, 10.2, 10.4, 10.6, 10.8,
    ]  # fmt: skip
    assert found["messages"][1]["time_us"] == BEGIN_US + 10 * SECOND_US
    assert found["until_us"] == BEGIN_US + 11 * SECOND_US
    assert [(topic["topic"], topic["type"]) for topic in found["topics"]] == [("/odom", ODOM)]


async def test_the_same_messages_are_bytes_as_the_robot_serialized_them(looked_back) -> None:
    query = {"topic": "/odom", "from_us": BEGIN_US + SECOND_US, "to_us": BEGIN_US + SECOND_US + 1}
    answer = await (await looked_back.client("operator")).get(AT + "/bytes", params=query)
    assert answer.headers["content-type"] == "application/msgpack"
    found = msgspec.msgpack.decode(answer.content)
    assert [message["data"] for message in found["messages"]] == [odometry(0.8), odometry(1.0)]
    assert {message["encoding"] for message in found["messages"]} == {"cdr"}


async def test_topic_that_a_person_may_not_have_is_as_if_it_were_not_recorded(looked_back) -> None:
    moment = {"at_us": BEGIN_US + SECOND_US}
    stretch = {"topic": "/secret", "from_us": BEGIN_US, "to_us": BEGIN_US + SECOND_US}
    mine = await asked(looked_back, "", **moment)
    assert [topic["topic"] for topic in mine["topics"]] == ["/odom"]
    assert (await asked(looked_back, "/messages", **stretch))["messages"] == []
    theirs = await asked(looked_back, "", "admin", **moment)
    assert [topic["topic"] for topic in theirs["topics"]] == [CALIBRATION, "/odom", "/secret"]
    told = await asked(looked_back, "/messages", "admin", **stretch)
    assert [json.loads(message["tree"]) for message in told["messages"]] == [{"data": "ha"}]


async def test_calibration_names_its_camera_also_while_the_gateway_is_away(looked_back) -> None:
    await looked_back.linked.close()
    page = await looked_back.page("admin")
    await page.hear(SiteUpdate, lambda site: not site.online)
    moment = await asked(looked_back, "", "admin", at_us=BEGIN_US + SECOND_US)
    cameras = {topic["topic"]: topic["camera"] for topic in moment["topics"]}
    assert cameras == {CALIBRATION: "camera/front", "/odom": "", "/secret": ""}


async def test_beyond_what_was_recorded_the_nearest_recording_is_named(looked_back) -> None:
    end_us = BEGIN_US + 30 * SECOND_US
    after = await asked(looked_back, "", at_us=end_us + 60 * SECOND_US)
    assert after == {"topics": [], "earlier_us": end_us, "later_us": None, "problems": []}
    before = await asked(looked_back, "", at_us=BEGIN_US - 60 * SECOND_US)
    assert before == {"topics": [], "earlier_us": None, "later_us": BEGIN_US, "problems": []}
    span = {"from_us": end_us + SECOND_US, "to_us": end_us + 2 * SECOND_US}
    assert (await asked(looked_back, "/messages", topic="/odom", **span))["messages"] == []


async def test_file_that_cannot_be_read_is_named_with_the_reason(hub) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + RULES)
    link = await files(hub)
    await link.bring(b"no recording at all", begin_us=BEGIN_US, end_us=BEGIN_US + SECOND_US)
    found = await asked(hub, "", at_us=BEGIN_US)
    assert found["topics"] == []
    assert "no whole MCAP file" in found["problems"][0]


async def test_who_reads_a_recording_stands_in_the_audit_log_once(looked_back) -> None:
    for n in range(3):
        span = {"from_us": BEGIN_US + n * SECOND_US, "to_us": BEGIN_US + (n + 1) * SECOND_US}
        await asked(looked_back, "/messages", topic="/odom", **span)
    admin = await looked_back.client("admin")
    records = (await admin.get("/api/audit", params={"kind": "recording looked at"})).json()
    assert [(row["who"], row["site"]) for row in records["rows"]] == [("operator", "agv")]


@pytest.mark.parametrize(
    "query",
    [
        {"topic": "/odom", "from_us": 2, "to_us": 1},
        {"topic": "/odom", "from_us": 0, "to_us": 61 * SECOND_US},
        {"topic": ["/odom", "/scan"], "rate": [1.0], "from_us": 0, "to_us": 1},
        {"from_us": 0, "to_us": 1},
    ],
)
async def test_question_that_is_none_is_refused(looked_back, query) -> None:
    answer = await (await looked_back.client("operator")).get(AT + "/messages", params=query)
    assert answer.status_code == 422
