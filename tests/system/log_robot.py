"""A ROS 2 robot's `/rosout`, started as a script.

Each line on stdin is a JSON list: name of a node, level as ROS 2 counts them, and the text; it is
published once.
"""

from __future__ import annotations

import json
import sys

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("log_robot", enable_rosout=False)
    # As rcl's own publisher has it.
    quality = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(Log, "/rosout", quality)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        name, level, text = json.loads(line)
        message = Log(level=level, name=name, msg=text)
        message.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
