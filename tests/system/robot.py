"""A ROS 2 robot for the fault tests: tells what it hears, and keeps a ledger of what it says.

    python robot.py HEARD LEDGER

HEARD gets one JSON object a line for each message: ``t`` (monotonic, ns), ``topic``, ``v``.
LEDGER gets one line for each value published on ``/count``: value, moment (monotonic, ns), and
how many subscriptions had ever been known just before. Words on stdin: ``count RATE``, ``quiet``,
``metric TEXT``, ``door VALUE`` (said once), ``hang`` and ``answer`` (for what its service does).
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any, TextIO

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import Trigger


def twist(message: Any) -> list[float]:
    return [message.linear.x, message.angular.z]


def stamped(message: Any) -> list[float]:
    stamp = message.header.stamp
    return [*twist(message.twist), stamp.sec + stamp.nanosec / 1e9]


def listen(node: rclpy.node.Node, heard: TextIO) -> None:
    def to(topic: str, kind: Any, value: Any, **quality: Any) -> None:
        def write(message: Any) -> None:
            line = {"t": time.monotonic_ns(), "topic": topic, "v": value(message)}
            heard.write(json.dumps(line) + "\n")

        node.create_subscription(kind, topic, write, QoSProfile(depth=100, **quality))

    to("/cmd_vel", Twist, twist)
    to("/cmd_stamped", TwistStamped, stamped)
    to("/control", String, lambda message: message.data)
    to("/mark", Float64, lambda message: message.data)
    latched = DurabilityPolicy.TRANSIENT_LOCAL
    to("/stop", Bool, lambda message: message.data, durability=latched)


class Worker:
    """A service that answers at once, or not before it is let."""

    def __init__(self, node: rclpy.node.Node, heard: TextIO) -> None:
        """Answer."""
        self.free = threading.Event()
        self.free.set()
        self._heard = heard
        # A thread of its own: a driver that hangs in one call still hears the others.
        group = MutuallyExclusiveCallbackGroup()
        node.create_service(Trigger, "/work", self._work, callback_group=group)

    def _work(self, _: Trigger.Request, answer: Trigger.Response) -> Trigger.Response:
        self.free.wait()
        line = {"t": time.monotonic_ns(), "topic": "/work", "v": "done"}
        self._heard.write(json.dumps(line) + "\n")
        answer.success = True
        return answer


class Counter:
    """Publishes 0, 1, 2, … and writes down each."""

    def __init__(self, node: rclpy.node.Node, ledger: TextIO) -> None:
        """Begin quietly."""
        self._publisher = node.create_publisher(Float64, "/count", QoSProfile(depth=2000))
        self._open = node.create_publisher(Float64, "/open", QoSProfile(depth=10))
        self._still = node.create_publisher(Float64, "/still", QoSProfile(depth=10))
        self._node = node
        self._ledger = ledger
        self._known: set[tuple[int, ...]] = set()
        self._next = 0
        self.rate = 0.0
        self.pause = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def _subscriptions(self) -> int:
        """Tell how many subscriptions there have ever been.

        Their number now may stay as it is when one goes and another comes.
        """
        for each in self._node.get_subscriptions_info_by_topic("/count"):
            self._known.add(tuple(each.endpoint_gid))
        return len(self._known)

    def _run(self) -> None:
        due = turn = 0.0
        message = Float64()
        while True:
            due = max(due, time.monotonic() - 0.5) + 1 / (self.rate or 20.0)
            time.sleep(max(0.0, due - time.monotonic()))
            if self.rate:
                known = self._subscriptions()
                self._ledger.write(f"{self._next} {time.monotonic_ns()} {known}\n")
                message.data = float(self._next)
                self._publisher.publish(message)
                self._next += 1
            else:
                self.pause.set()
            if time.monotonic() - turn > 0.05:
                turn = time.monotonic()
                self._open.publish(Float64(data=turn))
                self._still.publish(Float64(data=0.0))


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("robot")
    with (
        Path(sys.argv[1]).open("w", buffering=1) as heard,
        Path(sys.argv[2]).open("w", buffering=1) as ledger,
    ):
        run(node, heard, ledger)
    # The threads of ROS have nothing left to say, and no need to be waited for.
    os._exit(0)


def run(node: rclpy.node.Node, heard: TextIO, ledger: TextIO) -> None:
    listen(node, heard)
    counter = Counter(node, ledger)
    worker = Worker(node, heard)
    metric = node.create_publisher(String, "/metric", QoSProfile(depth=100))
    door = node.create_publisher(Float64, "/door", QoSProfile(depth=10))
    executor = MultiThreadedExecutor(2)
    executor.add_node(node)

    def spin() -> None:
        while True:
            executor.spin_once(timeout_sec=1.0)

    threading.Thread(target=spin, daemon=True).start()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        word, _, rest = line.strip().partition(" ")
        if word == "count":
            counter.pause.clear()
            counter.rate = float(rest)
        elif word == "quiet":
            counter.rate = 0.0
            counter.pause.wait(5)
            sys.stdout.write("quiet\n")
            sys.stdout.flush()
        elif word == "hang":
            worker.free.clear()
        elif word == "answer":
            worker.free.set()
        elif word == "door":
            door.publish(Float64(data=float(rest)))
            sys.stdout.write(f"door is {rest}\n")
            sys.stdout.flush()
        elif word == "metric":
            metric.publish(String(data=rest))


if __name__ == "__main__":
    main()
