"""Raw topics as channels of a Foxglove client."""

from __future__ import annotations

import struct

from talaia.wire import frames

from ...everyone.world import DESCRIPTIONS, NOW
from .foxglove_peer import client_of, topics_of

TOPICS = "topics:\n  - {pattern: /scan, right: view, device: base}\n"
SCAN = frames.TopicEntry(number=1, topic="/scan", type="sensor_msgs/msg/LaserScan")
SECRET = frames.TopicEntry(number=2, topic="/secret", type="std_msgs/msg/String")


async def test_raw_topic_is_sent_as_cdr_with_its_schema_to_those_who_may_tap_it(world) -> None:
    taps = world.hub.hub.core.taps
    gateway = await world.connect("agv", DESCRIPTIONS["agv"] + TOPICS)
    taps.receive("agv", frames.TopicList(topics=[SCAN, SECRET]))
    guest, driver = await client_of(world, "guest"), await client_of(world, "driver")
    assert "/scan" not in await topics_of(driver)
    wanted = await gateway.hear(frames.TapSubscription, lambda asked: asked.types)
    assert (wanted.types, wanted.topics) == ([SCAN.type], {})
    schema = frames.TapSchema(
        type=SCAN.type, encoding="ros2msg", definition="float32 x", message_encoding="cdr"
    )
    taps.receive("agv", schema)
    said = await driver.hear("advertise")
    (channel,) = said["channels"]
    assert {**channel, "id": 0} == {
        "id": 0,
        "topic": "/scan",
        "encoding": "cdr",
        "schemaName": "sensor_msgs/msg/LaserScan",
        "schemaEncoding": "ros2msg",
        "schema": "float32 x",
    }
    await driver.say({"op": "subscribe", "subscriptions": [{"id": 9, "channelId": channel["id"]}]})
    asked = await gateway.hear(frames.TapSubscription, lambda asked: asked.topics)
    assert list(asked.topics) == ["/scan"]
    data = b"\0\1\0\0raw"
    message = frames.TapMessage(
        number=1, seq=1, log_us=NOW, kept=False, size=len(data), at=0, data=data
    )
    taps.receive("agv", message)
    frame = await driver.hear("data")
    assert frame == struct.pack("<BIQ", 1, 9, NOW * 1000) + data
    # Nobody takes it any more: it rests on the robot.
    await driver.close()
    await gateway.hear(frames.TapSubscription, lambda asked: not asked.topics)
    assert b"/scan" not in repr(guest.frames).encode()
    await guest.close()


async def test_topic_of_ros_1_is_offered_by_the_names_of_ros_1(world) -> None:
    taps = world.hub.hub.core.taps
    gateway = await world.connect("agv", DESCRIPTIONS["agv"] + TOPICS)
    taps.receive("agv", frames.TopicList(topics=[SCAN]))
    driver = await client_of(world, "driver")
    assert "/scan" not in await topics_of(driver)
    await gateway.hear(frames.TapSubscription, lambda asked: asked.types)
    schema = frames.TapSchema(
        type=SCAN.type, encoding="ros1msg", definition="float32 x", message_encoding="ros1"
    )
    taps.receive("agv", schema)
    said = await driver.hear("advertise")
    (channel,) = said["channels"]
    assert {**channel, "id": 0} == {
        "id": 0,
        "topic": "/scan",
        "encoding": "ros1",
        "schemaName": "sensor_msgs/LaserScan",
        "schemaEncoding": "ros1msg",
        "schema": "float32 x",
    }
    await driver.close()
