"""A vehicle of the CloudConnect contract, as a script: ``ros1`` (Debian's rospy) or ``ros2``.

Three sensors by name on ``/metric``, in either kind of quotes; a picture on ``/images``; and
``/control`` is listened to.
"""

from __future__ import annotations

import itertools
import json
import sys
import time

SENSORS = {"speed1": 1.4, "ultrasonic2": 0.8, "temperature1": 21.5}
PERIOD_S = 0.05


def texts() -> itertools.cycle:
    rows = [{"name": name, "magnitude": value} for name, value in SENSORS.items()]
    return itertools.cycle([*map(str, rows), *map(json.dumps, rows)])


def ready() -> None:
    sys.stdout.write("ready\n")
    sys.stdout.flush()


def ros1() -> None:
    import rospy
    from sensor_msgs.msg import Image
    from std_msgs.msg import String

    rospy.init_node("cart")
    metric = rospy.Publisher("/metric", String, queue_size=10)
    images = rospy.Publisher("/images", Image, queue_size=1)
    rospy.Subscriber("/control", String, lambda _: None)
    ready()
    for text in texts():
        metric.publish(String(text))
        images.publish(Image(height=2, width=2, encoding="mono8", step=2, data=bytes(4)))
        time.sleep(PERIOD_S)


def ros2() -> None:
    import ros_wheels_bootstrapper  # noqa: F401 - before the first import of rclpy

    import rclpy  # isort: skip
    from sensor_msgs.msg import Image
    from std_msgs.msg import String

    rclpy.init()
    node = rclpy.create_node("cart")
    metric = node.create_publisher(String, "/metric", 10)
    images = node.create_publisher(Image, "/images", 1)
    node.create_subscription(String, "/control", lambda _: None, 10)
    ready()
    for text in texts():
        metric.publish(String(data=text))
        images.publish(Image(height=2, width=2, encoding="mono8", step=2, data=bytes(4)))
        rclpy.spin_once(node, timeout_sec=0)
        time.sleep(PERIOD_S)


if __name__ == "__main__":
    {"ros1": ros1, "ros2": ros2}[sys.argv[1]]()
