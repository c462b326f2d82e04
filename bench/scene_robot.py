"""A ROS 2 robot for scenes: links that move, a scan and a cloud, stamped when they are published.

    python bench/scene_robot.py SECONDS [--links N] [--scan HZ] [--cloud HZ]

Its form is described once, a chain of boxes; transforms of all of its links come at 50 Hz.
"""

from __future__ import annotations

import argparse
import array
import math
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import String

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class

STORE = get_typestore(Stores.LATEST)
TRANSFORMS = "tf2_msgs/msg/TFMessage"
POINTS, BEAMS = 100_000, 640
LINK_M = 0.12
FRAMES_HZ = 50
# Different ones in turn, so that nothing on the way may take one for the other.
CLOUDS = 4


def main() -> int:
    """Publish what is asked for until the time is up."""
    parser = argparse.ArgumentParser()
    parser.add_argument("seconds", type=float)
    parser.add_argument("--links", type=int, default=0)
    parser.add_argument("--scan", type=float, default=0)
    parser.add_argument("--cloud", type=float, default=0)
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("scene_robot", enable_rosout=False)
    parts: list[tuple[float, Callable[[], None]]] = []
    if options.links:
        publish_form(node, options.links)
        parts.append((FRAMES_HZ, links_publisher(node, options.links)))
    if options.scan:
        parts.append((options.scan, scan_publisher(node)))
    if options.cloud:
        parts.append((options.cloud, cloud_publisher(node)))
    for rate, publish in parts:
        threading.Thread(target=repeat, args=(rate, publish), daemon=True).start()
    # It answers who asks for its types: one that does not is waited for.
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    print("ready", flush=True)
    time.sleep(options.seconds)
    return 0


def repeat(rate: float, publish: Callable[[], None]) -> None:
    """Publish at a steady rate."""
    due = time.monotonic()
    while True:
        due += 1 / rate
        time.sleep(max(0.0, due - time.monotonic()))
        publish()


def stamp_now(message: LaserScan | PointCloud2) -> None:
    """Write the moment into a message's header."""
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(time.time_ns(), 10**9)


def publish_form(node: Node, links: int) -> None:
    """Describe a chain of boxes, as a robot's description is published: latched."""
    parts = ['<robot name="chain">']
    for link in range(links):
        size = f"{LINK_M} {LINK_M / 2} {LINK_M / 2}"
        parts.append(
            f'<link name="{link_name(link)}"><visual><geometry><box size="{size}"/></geometry>'
            "</visual></link>"
        )
        if link:
            parts.append(
                f'<joint name="joint{link}" type="continuous">'
                f'<parent link="{link_name(link - 1)}"/>'
                f'<child link="{link_name(link)}"/><origin xyz="{LINK_M} 0 0"/>'
                '<axis xyz="0 0 1"/></joint>'
            )
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(String, "/bench/robot_description", latched)
    publisher.publish(String(data="".join([*parts, "</robot>"])))


def link_name(link: int) -> str:
    """Name a link; the first one as every robot's is named."""
    return f"link{link}" if link else "base_link"


def transforms_class() -> Any:  # noqa: ANN401 - as rosidl's classes
    """Make the class of transforms, whose package need not be on this machine."""
    found = made_class(TRANSFORMS, STORE.hash_rihs01(TRANSFORMS))
    forget_error()
    return found


def links_publisher(node: Node, links: int) -> Callable[[], None]:
    """Give what publishes where all links are: a chain that swings."""
    publisher = node.create_publisher(transforms_class(), "/bench/tf", QoSProfile(depth=10))
    types = STORE.types
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    transform = types["geometry_msgs/msg/Transform"]
    stamped = types["geometry_msgs/msg/TransformStamped"]

    def publish() -> None:
        now = stamp(*divmod(time.time_ns(), 10**9))
        transforms = []
        for link in range(links):
            angle = 0.2 * math.sin(now.sec % 1000 + now.nanosec / 1e9 + 0.3 * link)
            place = transform(
                vector(LINK_M if link else 0.0, 0.0, 0.0),
                turn(0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)),
            )
            parent = link_name(link - 1) if link else "odom"
            transforms.append(stamped(header(now, parent), link_name(link), place))
        message = types[TRANSFORMS](transforms)
        publisher.publish(bytes(STORE.serialize_cdr(message, TRANSFORMS)))

    return publish


def scan_publisher(node: Node) -> Callable[[], None]:
    """Give what publishes a scan of a round room that breathes."""
    publisher = node.create_publisher(LaserScan, "/bench/scan", QoSProfile(depth=5))
    angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    message = LaserScan(range_min=0.1, range_max=30.0)
    message.header.frame_id = "base_link"
    message.angle_min, message.angle_max = float(angles[0]), float(angles[-1])
    message.angle_increment = float(angles[1] - angles[0])

    def publish() -> None:
        ranges = 4 + 0.5 * np.sin(6 * angles + time.time())
        message.ranges = array.array("f", ranges.astype(np.float32).tobytes())
        stamp_now(message)
        publisher.publish(message)

    return publish


def cloud_publisher(node: Node) -> Callable[[], None]:
    """Give what publishes a cloud: a hilly floor with noise; x, y, z and intensity as floats."""
    publisher = node.create_publisher(PointCloud2, "/bench/cloud", QoSProfile(depth=2))
    chance = np.random.default_rng(1)
    clouds = []
    for turn in range(CLOUDS):
        x, y = chance.uniform(-8, 8, (2, POINTS))
        z = 0.4 * np.sin(x + turn) + 0.4 * np.cos(y) + chance.normal(0, 0.02, POINTS) + 0.5
        points = np.stack([x, y, z, chance.uniform(0, 1, POINTS)], 1).astype(np.float32)
        message = PointCloud2(height=1, width=POINTS, point_step=16, is_dense=True)
        message.row_step = 16 * POINTS
        message.header.frame_id = "base_link"
        message.fields = [
            PointField(name=name, offset=4 * at, datatype=PointField.FLOAT32, count=1)
            for at, name in enumerate(("x", "y", "z", "intensity"))
        ]
        message.data = array.array("B", points.tobytes())
        clouds.append(message)
    turn = 0

    def publish() -> None:
        nonlocal turn
        turn += 1
        message = clouds[turn % CLOUDS]
        stamp_now(message)
        publisher.publish(message)

    return publish


if __name__ == "__main__":
    sys.exit(main())
