"""Recordings of a small robot as its owners would have them: one story, in each format."""

from __future__ import annotations

import functools
import json
import math
from typing import NamedTuple

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START_NS = 1_700_000_000_000_000_000
STEP_NS = 20_000_001
STEPS = 100
SITE = """
talaia: 1
site: rover
name: Rover
zone: Europe/Madrid
ros2: {}
devices:
  base:
    name: Base
    signals:
      speed:
        name: Speed
        unit: km/h
        scale: 3.6
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x}
      pose:
        name: Position
        type: position
        yaw_from: pose.pose.orientation
        source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.pose.position}
      mode:
        name: Mode
        type: state
        states: ["off", "on"]
        source: {topic: /wandering, type: std_msgs/msg/Bool, field: data}
      said:
        name: Said
        type: text
        source: {topic: /said, type: std_msgs/msg/String, field: data}
      speed1:
        name: Speed (CloudConnect)
        unit: m/s
        source: {topic: /metric, type: std_msgs/msg/String, name: speed1}
  mast:
    name: Mast
    signals:
      wind:
        name: Wind
        unit: m/s
        source: {topic: /weather, type: acme_msgs/msg/Weather, field: wind.gust}
      absent:
        name: Absent
        source: {topic: /nowhere, type: std_msgs/msg/Float64, field: data}
"""
WIND = "float32 mean\nfloat32 gust\n"
WEATHER = "string station\nacme_msgs/Wind wind\n"
RULE = "=" * 80 + "\n"


class Message(NamedTuple):
    topic: str
    kind: str
    time_ns: int
    value: float


def story(count=STEPS):
    """Give what the robot said, in order: one message of each topic at each step."""
    kinds = {
        "/odom": "nav_msgs/msg/Odometry",
        "/wandering": "std_msgs/msg/Bool",
        "/said": "std_msgs/msg/String",
        "/metric": "std_msgs/msg/String",
        "/weather": "acme_msgs/msg/Weather",
        "/unread": "std_msgs/msg/String",
    }
    for step in range(count):
        for at, (topic, kind) in enumerate(kinds.items()):
            if topic == "/said" and step % 10:
                continue
            yield Message(topic, kind, START_NS + step * STEP_NS + at * 1_000, step / 7)


def expected(address, count=STEPS):
    """Give times (µs) and values of an address, as the story tells them."""
    topic = {
        "base/speed": "/odom", "base/pose.x": "/odom", "base/pose.yaw": "/odom",
        "base/mode": "/wandering", "base/said": "/said", "base/speed1": "/metric",
        "mast/wind": "/weather",
    }[address]  # fmt: skip
    said = [each for each in story(count) if each.topic == topic]
    times = [each.time_ns // 1000 for each in said]
    values = [each.value for each in said]
    of = {
        "base/speed": lambda v: v * 3.6,
        "base/pose.x": lambda v: v + 1,
        "base/pose.yaw": lambda v: math.atan2(math.sin(v), math.cos(v)),
        "base/mode": lambda v: float(int(v * 7) % 2),
        "base/said": lambda v: f"step {v:.3f}",
        "base/speed1": lambda v: -v,
        "mast/wind": lambda v: float(np.float32(v * 2)),
    }[address]
    return times, [of(value) for value in values]


@functools.cache
def store_of(*, ros1=False):
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
    types = get_types_from_msg(WEATHER, "acme_msgs/msg/Weather")
    types.update(get_types_from_msg(WIND, "acme_msgs/msg/Wind"))
    store.register(types)
    return store


def built(store, message, *, ros1=False):
    """Give a message as the object that rosbags writes."""
    kind, value = store.types, message.value
    match message.topic:
        case "/wandering":
            return kind["std_msgs/msg/Bool"](data=bool(int(value * 7) % 2))
        case "/said":
            return kind["std_msgs/msg/String"](data=f"step {value:.3f}")
        case "/metric":
            return kind["std_msgs/msg/String"](data=str({"name": "speed1", "magnitude": -value}))
        case "/unread":
            return kind["std_msgs/msg/String"](data="nobody reads this")
        case "/weather":
            wind = kind["acme_msgs/msg/Wind"](mean=value, gust=value * 2)
            return kind["acme_msgs/msg/Weather"](station="mast", wind=wind)
    stamp = kind["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    first = {"seq": 0} if ros1 else {}
    turn = kind["geometry_msgs/msg/Quaternion"](
        x=0.0, y=0.0, z=math.sin(value / 2), w=math.cos(value / 2)
    )
    vector, zero = kind["geometry_msgs/msg/Vector3"], np.zeros(36)
    return kind["nav_msgs/msg/Odometry"](
        header=kind["std_msgs/msg/Header"](stamp=stamp, frame_id="odom", **first),
        child_frame_id="base",
        pose=kind["geometry_msgs/msg/PoseWithCovariance"](
            pose=kind["geometry_msgs/msg/Pose"](
                position=kind["geometry_msgs/msg/Point"](x=value + 1, y=0.0, z=0.0),
                orientation=turn,
            ),
            covariance=zero,
        ),
        twist=kind["geometry_msgs/msg/TwistWithCovariance"](
            twist=kind["geometry_msgs/msg/Twist"](
                linear=vector(x=value, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)
            ),
            covariance=zero,
        ),
    )


def write_rosbag1(folder, count=STEPS):
    store = store_of(ros1=True)
    path = folder / "robot.bag"
    with Writer1(path) as writer:
        connections = {}
        for message in story(count):
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic, message.kind, typestore=store
                )
            data = store.serialize_ros1(built(store, message, ros1=True), message.kind)
            writer.write(connections[message.topic], message.time_ns, data)
    return path


def _write_rosbag2(path, plugin, count):
    store = store_of()
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for message in story(count):
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic, message.kind, typestore=store
                )
            data = store.serialize_cdr(built(store, message), message.kind)
            writer.write(connections[message.topic], message.time_ns, bytes(data))
    return path


def write_rosbag2_sqlite(folder, count=STEPS):
    return _write_rosbag2(folder / "robot_db3", StoragePlugin.SQLITE3, count)


def write_rosbag2_mcap(folder, count=STEPS):
    return _write_rosbag2(folder / "robot_mcap", StoragePlugin.MCAP, count)


def write_db3(folder, count=STEPS):
    return next(write_rosbag2_sqlite(folder, count).glob("*.db3"))


def _write_mcap(path, encoding, schema_encoding, definition, encode, count, **options):
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=4096, **options)
        writer.start("", library="test")
        channels = {}
        for message in story(count):
            if message.topic not in channels:
                schema = writer.register_schema(
                    message.kind, schema_encoding, definition(message.kind).encode()
                )
                channels[message.topic] = writer.register_channel(message.topic, encoding, schema)
            writer.add_message(
                channels[message.topic], message.time_ns, encode(message), message.time_ns
            )
        writer.finish()
    return path


def write_mcap_ros1(folder, count=STEPS):
    store = store_of(ros1=True)
    return _write_mcap(
        folder / "ros1.mcap", "ros1", "ros1msg",
        lambda kind: store.generate_msgdef(kind, ros_version=1)[0],
        lambda m: bytes(store.serialize_ros1(built(store, m, ros1=True), m.kind)), count,
    )  # fmt: skip


def write_mcap_ros2(folder, count=STEPS, **options):
    store = store_of()
    return _write_mcap(
        folder / "ros2.mcap", "cdr", "ros2msg",
        lambda kind: store.generate_msgdef(kind, ros_version=2)[0],
        lambda m: bytes(store.serialize_cdr(built(store, m), m.kind)), count, **options,
    )  # fmt: skip


def write_mcap_json(folder, count=STEPS):
    store = store_of()

    def plain(value):
        if hasattr(value, "__dataclass_fields__"):
            return {
                name: plain(getattr(value, name))
                for name in value.__dataclass_fields__
                if name != "__msgtype__"
            }
        return value.tolist() if isinstance(value, np.ndarray) else value

    return _write_mcap(
        folder / "json.mcap", "json", "jsonschema", lambda _: '{"type": "object"}',
        lambda m: json.dumps(plain(built(store, m))).encode(), count,
    )  # fmt: skip


FORMATS = {
    "rosbag1": write_rosbag1,
    "rosbag2-sqlite3": write_rosbag2_sqlite,
    "rosbag2-mcap": write_rosbag2_mcap,
    "db3": write_db3,
    "mcap-ros1": write_mcap_ros1,
    "mcap-ros2": write_mcap_ros2,
    "mcap-json": write_mcap_json,
}
