"""A ROS 2 peer whose camera's pictures and whose signal say the same number; see `test_films`.

    python film_robot.py LEDGER

LEDGER gets a line for each number: number, and when it was published (wall, ns).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import rclpy

# It knows where the pictures are.
from camera_robot import message_of
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from scenes import numbered
from sensor_msgs.msg import Image
from std_msgs.msg import Float64

STEP_S = 0.1
NUMBERS = 400


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("film")
    images = node.create_publisher(Image, "/cam", QoSProfile(depth=1))
    numbers = node.create_publisher(Float64, "/number", QoSProfile(depth=10))
    said = [message_of("rgb8", numbered(number)) for number in range(NUMBERS)]
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    number = 0
    with Path(sys.argv[1]).open("a") as ledger:
        while True:
            ledger.write(f"{number % NUMBERS} {time.time_ns()}\n")
            ledger.flush()
            images.publish(said[number % NUMBERS])
            numbers.publish(Float64(data=float(number % NUMBERS)))
            number += 1
            time.sleep(STEP_S)


if __name__ == "__main__":
    main()
