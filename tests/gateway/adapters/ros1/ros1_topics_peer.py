"""A ROS 1 robot with topics, as a process of the machine's own Python: JSON lines in and out."""

from __future__ import annotations

import io
import json
import sys
import time

import rospy
from genpy.dynamic import generate_dynamic
from nav_msgs.msg import Odometry
from std_msgs.msg import String, UInt8MultiArray

KINDS = {"text": String, "bytes": UInt8MultiArray, "odometry": Odometry}


def say(**row: object) -> None:
    sys.stdout.write(json.dumps({"at": time.monotonic_ns(), **row}) + "\n")
    sys.stdout.flush()


class TopicsPeer:
    """The node and what it can be told."""

    def __init__(self) -> None:  # noqa: D107
        self.publishers = {}

    def do_open(self, asked: dict) -> None:
        kind = asked.get("kind", "text")
        if "definition" in asked:
            kind = generate_dynamic(asked["type"], asked["definition"])[asked["type"]]
        self.publishers[asked["topic"]] = rospy.Publisher(
            asked["topic"],
            KINDS.get(kind, kind),
            queue_size=1000,
            latch=asked.get("latched", False),
        )
        say(opened=asked["topic"])

    def do_shut(self, asked: dict) -> None:
        self.publishers.pop(asked["topic"]).unregister()
        say(shut=asked["topic"])

    def do_publish(self, asked: dict) -> None:
        """Say what ROS writes of each message: so it is to reach whoever takes it."""
        publisher, written = self.publishers[asked["topic"]], []
        period, began = 1 / asked.get("hz", 1000), time.monotonic()
        for number, value in enumerate(asked["values"]):
            message = publisher.data_class()
            if isinstance(message, Odometry):
                message.header.stamp = rospy.Time(12, 34)
                message.header.frame_id = "odom"
                message.pose.pose.position.x = value
            elif isinstance(message, UInt8MultiArray):
                message.data = bytes([number % 256]) * value
            else:
                message.data = value
            publisher.publish(message)
            # Only now: rospy has counted its header.
            into = io.BytesIO()
            message.serialize(into)
            written.append(into.getvalue().hex() if into.tell() < 10_000 else into.tell())
            time.sleep(max(0.0, began + (number + 1) * period - time.monotonic()))
        say(written=written)

    def do_count(self, asked: dict) -> None:
        """Say who is connected, but for who asked for the definition and has hung up."""
        found = self.publishers[asked["topic"]].impl.connections
        say(count=len([one for one in found if one.endpoint_id != "/talaia"]))


def main() -> None:
    rospy.init_node(sys.argv[1], disable_signals=True)
    peer = TopicsPeer()
    say(ready=True)
    for line in sys.stdin:
        asked = json.loads(line)
        getattr(peer, "do_" + asked["do"])(asked)


if __name__ == "__main__":
    main()
