"""A robot with topics, as a process of its own: JSON lines in and out, like `robot_peer`."""

from __future__ import annotations

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String, UInt8MultiArray


def say(**row: object) -> None:
    sys.stdout.write(json.dumps({"at": time.monotonic_ns(), **row}) + "\n")
    sys.stdout.flush()


class TopicsPeer:
    """The node and what it can be told."""

    def __init__(self) -> None:  # noqa: D107
        self.node = Node("topics_peer", enable_rosout=False)
        self.publishers = {}

    def obey(self, order: dict[str, object]) -> None:
        topic = str(order.get("topic", ""))
        match order["do"]:
            case "open":
                kind = UInt8MultiArray if order.get("bytes") else String
                durability = (
                    DurabilityPolicy.TRANSIENT_LOCAL
                    if order.get("latched")
                    else DurabilityPolicy.VOLATILE
                )
                quality = QoSProfile(
                    depth=20, reliability=ReliabilityPolicy.RELIABLE, durability=durability
                )
                self.publishers[topic] = self.node.create_publisher(kind, topic, quality)
            case "publish":
                self.publish(order)
            case "shut":
                self.node.destroy_publisher(self.publishers.pop(topic))
            case "listeners":
                heard = self.node.get_subscriptions_info_by_topic(topic)
                say(listeners=[info.node_name for info in heard])

    def publish(self, order: dict[str, object]) -> None:
        topics = order.get("topics") or [order["topic"]]
        texts = order.get("texts") or [""] * int(order["count"])
        size, period = int(order.get("bytes", 0)), 1 / float(order.get("hz", 1000))
        began = time.monotonic()
        for number, text in enumerate(texts):
            for topic in topics:
                message = String(data=text)
                if size:
                    message = UInt8MultiArray()
                    message.data.frombytes(bytes([number % 256]) * size)
                self.publishers[topic].publish(message)
            wait = began + (number + 1) * period - time.monotonic()
            if wait > 0:
                time.sleep(wait)
        say(published=len(texts))


def main() -> None:
    rclpy.init()
    peer = TopicsPeer()
    say(ready=True)
    for line in sys.stdin:
        peer.obey(json.loads(line))
    peer.node.destroy_node()
    rclpy.try_shutdown()


main()
