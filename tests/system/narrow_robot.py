"""A ROS 2 peer whose camera shows a busy scene that moves; see `test_narrow_line`."""

from __future__ import annotations

import sys
import time

import numpy as np
import rclpy
from camera_robot import message_of
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Image

WIDTH, HEIGHT, PICTURES, HZ = 320, 240, 40, 30


def busy(turn: int) -> np.ndarray:
    """Coarse blocks that pass by, under a camera's noise: RGB."""
    coarse = np.random.default_rng(7).integers(0, 255, (HEIGHT // 4, WIDTH // 4, 3))
    wide = np.kron(coarse.astype(float), np.ones((8, 8, 1)))
    x, y = turn * 7 % WIDTH, turn * 3 % HEIGHT
    noise = np.random.default_rng(turn).normal(0, 8, (HEIGHT, WIDTH, 1))
    return np.clip(wide[y : y + HEIGHT, x : x + WIDTH] + noise, 0, 255).astype(np.uint8)


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("busy_camera")
    publisher = node.create_publisher(Image, "/cam/busy", QoSProfile(depth=1))
    messages = [message_of("rgb8", busy(turn)) for turn in range(PICTURES)]
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    turn = 0
    while True:
        publisher.publish(messages[turn % PICTURES])
        turn += 1
        time.sleep(1 / HZ)


if __name__ == "__main__":
    main()
