"""A robot with topics, as a process of its own: JSON lines in and out, like `robot_peer`."""

from __future__ import annotations

import json
import sys
import time
from hashlib import sha256

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rclpy.signals import SignalHandlerOptions
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
            case "count":
                say(count=self.publishers[topic].get_subscription_count(), topic=topic)

    def publish(self, order: dict[str, object]) -> None:
        topics = order.get("topics") or [order["topic"]]
        texts = order.get("texts") or [""] * int(order["count"])
        size, period = int(order.get("bytes", 0)), 1 / float(order.get("hz", 1000))
        # What ROS writes of each message: so it is to reach whoever takes it.
        written = []
        began = time.monotonic()
        for number, text in enumerate(texts):
            message = String(data=text)
            if size:
                message = UInt8MultiArray()
                message.data.frombytes(bytes([number % 256]) * size)
            data = serialize_message(message)
            # On its way a message is filled up to four bytes.
            written.append(sha256(data + bytes(-len(data) % 4)).hexdigest())
            for topic in topics:
                self.publishers[topic].publish(message)
            wait = began + (number + 1) * period - time.monotonic()
            if wait > 0:
                time.sleep(wait)
        say(published=len(texts), written=written)


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    peer = TopicsPeer()
    say(ready=True)
    for line in sys.stdin:
        peer.obey(json.loads(line))
    peer.node.destroy_node()
    rclpy.try_shutdown()


main()
