"""A robot that is driven by three messages, and says what it heard: JSON lines out.

It listens with rclpy itself. Of Ackermann's message nothing is installed: its bytes are read here
by their places, and not by Talaia's definitions. The type's hash is the first argument.
"""

from __future__ import annotations

import json
import struct
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class


def say(**row: object) -> None:
    sys.stdout.write(json.dumps({"at": time.monotonic_ns(), **row}) + "\n")
    sys.stdout.flush()


def hear_twist(message: Twist) -> None:
    linear, angular = message.linear, message.angular
    say(twist=[linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])


def hear_steering(raw: bytes) -> None:
    # After the encapsulation: a stamp, an empty frame's name (its length and a zero), and then, at
    # the next multiple of four, five numbers.
    seconds, nanoseconds, length = struct.unpack_from("<iII", raw, 4)
    begin = 4 + (12 + length + 3) // 4 * 4
    say(steered=[*struct.unpack_from("<5f", raw, begin), seconds, nanoseconds])


def main() -> None:
    """Listen until nobody reads any more."""
    rclpy.init()
    node = Node("drive_peer", enable_rosout=False)
    node.create_subscription(Twist, "/cmd_vel", hear_twist, 10)
    node.create_subscription(
        Float64MultiArray, "/jog", lambda message: say(joints=list(message.data)), 10
    )
    kind = made_class("ackermann_msgs/msg/AckermannDriveStamped", sys.argv[1])
    node.create_subscription(kind, "/steer", hear_steering, 10, raw=True)
    forget_error()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    say(ready=True)
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    try:
        executor.spin()
    except ExternalShutdownException:
        return


if __name__ == "__main__":
    main()
