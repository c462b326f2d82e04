"""A ROS 2 peer with cameras of many kinds, good and bad; see `test_cameras`."""

from __future__ import annotations

import array
import sys
import time
from pathlib import Path

import numpy as np
import rclpy
import simplejpeg
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CompressedImage, Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "gateway" / "video"))
from scenes import packed, scene

ENCODINGS = ("rgb8", "yuyv", "bayer_rggb8", "mono16")
WIDTH, HEIGHT = 320, 240


def message_of(encoding: str, picture: np.ndarray | None = None) -> Image:
    fields = vars(packed(scene(WIDTH, HEIGHT) if picture is None else picture, encoding))
    data = array.array("B", fields.pop("data").tobytes())
    message = Image(**fields)
    message.data = data
    return message


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("cameras")
    quality = QoSProfile(depth=1)
    said = [(f"/cam/{name}", message_of(name)) for name in ENCODINGS]
    unknown = message_of("rgb8")
    unknown.encoding = "yuv9"
    short = message_of("rgb8")
    short.height = 900
    said += [("/cam/unknown", unknown), ("/cam/short", short)]
    whole = simplejpeg.encode_jpeg(scene(WIDTH, HEIGHT), 95)
    for name, data in (("jpeg", whole), ("cut", whole[:-200])):
        message = CompressedImage(format="jpeg")
        message.data = array.array("B", data)
        said.append((f"/cam/{name}", message))
    publishers = [(node.create_publisher(type(each), topic, quality), each) for topic, each in said]
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while True:
        for publisher, message in publishers:
            publisher.publish(message)
        time.sleep(0.1)


if __name__ == "__main__":
    main()
