"""A small robot of the founding design: sensors by name, pictures, a position, driving keys."""

from __future__ import annotations

import contextlib
import json
import math
import sys
import time

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import Image, NavSatFix
from std_msgs.msg import String


class Founding(Node):
    """Says everything ten times a second."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__("founding")
        self.metric = self.create_publisher(String, "/metric", 10)
        self.images = self.create_publisher(Image, "/images", 2)
        self.fix = self.create_publisher(NavSatFix, "/fix", 10)
        self.create_subscription(String, "/control", lambda _: None, 10)
        self.create_timer(0.1, self.publish)

    def publish(self) -> None:
        turn = math.sin(time.monotonic())
        for name, value in (
            ("temperature1", 21 + turn),
            ("voltage1", 12 + turn / 10),
            ("Radiation1", 0.1),
        ):
            text = json.dumps({"name": name, "magnitude": round(value, 3)})
            self.metric.publish(String(data=text))
        self.images.publish(
            Image(height=24, width=32, encoding="rgb8", step=96, data=bytes(range(96)) * 24)
        )
        self.fix.publish(NavSatFix(latitude=41.4, longitude=2.2, altitude=90.0))


def main() -> None:
    rclpy.init()
    node = Founding()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    import ros_wheels_bootstrapper  # noqa: F401

    main()
