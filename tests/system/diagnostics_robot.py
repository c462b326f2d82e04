"""A ROS 2 robot's `/diagnostics`, started as a script.

Each line on stdin is a JSON list of statuses: name, level, message and values by key; it is
published once. How many hear the topic is written to stdout whenever that changes.
"""

from __future__ import annotations

import json
import os
import select
import sys

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


class Diagnostics(Node):
    """Publishes what it is told."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__("diagnostics")
        self.publisher = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.heard_by = -1

    def publish(self, line: bytes) -> None:
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for name, level, text, values in json.loads(line):
            status = DiagnosticStatus(name=name, level=bytes([level]), message=text)
            status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
            message.status.append(status)
        self.publisher.publish(message)

    def report_hearers(self) -> None:
        count = self.publisher.get_subscription_count()
        if count != self.heard_by:
            self.heard_by = count
            sys.stdout.write(f"heard by {count}\n")
            sys.stdout.flush()


def main() -> None:
    rclpy.init()
    node = Diagnostics()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    sys.stdout.write("ready\n")
    rest = b""
    while True:
        if select.select([0], [], [], 0)[0]:
            more = os.read(0, 65536)
            if not more:
                break
            *lines, rest = (rest + more).split(b"\n")
            for line in lines:
                node.publish(line)
        node.report_hearers()
        executor.spin_once(timeout_sec=0.02)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
