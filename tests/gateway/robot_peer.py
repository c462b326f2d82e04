"""A robot for the tests, as a process of its own: JSON lines in, JSON lines out.

Started as a script. It publishes what it is told and reports what it hears, each with its own
monotonic time (the same clock as the test's, on one machine).
"""

from __future__ import annotations

import array
import json
import sys
import time
from pathlib import Path

import rclpy
from executor_thread import run_in_thread
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import SetBool, Trigger
from test_msgs.action import Fibonacci


def say(**row: object) -> None:
    sys.stdout.write(json.dumps({"at": time.monotonic_ns(), **row}) + "\n")
    sys.stdout.flush()


class Peer:
    """The node and what it can be told."""

    def __init__(self) -> None:  # noqa: D107
        self.node = Node("robot_peer", enable_rosout=False)
        self.node.declare_parameter("gain", 1.5)
        best_effort = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        make = self.node.create_publisher
        self.number = make(Float64, "/number", 1000)
        self.odom = make(Odometry, "/odom", best_effort)
        self.metric = make(String, "/metric", 10)
        self.mode = make(String, "/mode", latched)
        self.image = make(Image, "/images", 2)
        self.node.create_subscription(
            Twist, "/cmd_vel", lambda m: say(cmd=[m.linear.x, m.angular.z]), 100
        )
        self.node.create_subscription(Bool, "/stop", lambda m: say(stop=m.data), latched)
        self.node.create_subscription(String, "/horn", lambda m: say(horn=m.data), 10)
        self.node.create_service(SetBool, "/wander", self.wander)
        self.node.create_service(Trigger, "/fail", self.fail)
        self.action = ActionServer(
            self.node,
            Fibonacci,
            "/count",
            self.run_goal,
            goal_callback=lambda goal: (
                GoalResponse.REJECT if goal.order == 0 else GoalResponse.ACCEPT
            ),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def run_goal(self, goal: object) -> Fibonacci.Result:
        """Count to 100 in ``order`` tenths of a second; give up at 13."""
        order = goal.request.order
        say(goal=order)
        for share in range(0, 101, 10):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[share]))
            if goal.is_cancel_requested:
                say(cancelled=order)
                goal.canceled()
                return Fibonacci.Result()
            if order == 13 and share >= 50:
                goal.abort()
                return Fibonacci.Result()
            time.sleep(order / 100)
        goal.succeed()
        return Fibonacci.Result(sequence=[100])

    def wander(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        say(wander=request.data)
        response.success, response.message = True, "wandering"
        return response

    def fail(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        say(failed=True)
        response.success, response.message = False, "the wheel is off"
        return response

    def obey(self, order: dict[str, object]) -> None:
        match order["do"]:
            case "count":
                self.count(int(order["from"]), int(order["to"]), float(order["hz"]))
            case "odom":
                message = Odometry()
                message.header.stamp.sec = int(order.get("stamp", 0))
                message.twist.twist.linear.x = float(order["speed"])
                message.pose.pose.position.x = 1.5
                message.pose.pose.orientation.w = 1.0
                self.odom.publish(message)
            case "metric":
                self.metric.publish(String(data=str(order["text"])))
            case "mode":
                self.mode.publish(String(data=str(order["text"])))
            case "image":
                self.picture(str(order["encoding"]))
            case "show":
                self.show(order)
            case "listeners":
                publisher = getattr(self, str(order.get("of", "number")))
                say(listeners=publisher.get_subscription_count())

    def count(self, first: int, last: int, hz: float) -> None:
        began = time.monotonic()
        for number in range(first, last):
            self.number.publish(Float64(data=float(number)))
            wait = began + (number - first + 1) / hz - time.monotonic()
            if wait > 0:
                time.sleep(wait)
        say(counted=last)

    def show(self, order: dict[str, object]) -> None:
        """Publish the picture in a file of bytes (RGB) for so long, so often."""
        height, width = order["height"], order["width"]
        message = Image(height=height, width=width, encoding="rgb8", step=width * 3)
        message.data = array.array("B", Path(str(order["file"])).read_bytes())
        until = time.monotonic() + float(order["seconds"])
        while time.monotonic() < until:
            self.image.publish(message)
            time.sleep(1 / float(order["hz"]))
        say(shown=order["file"])

    def picture(self, encoding: str) -> None:
        depth = 1 if encoding == "mono8" else 3
        message = Image(height=48, width=64, encoding=encoding, step=64 * depth)
        message.data = bytes([255, 0, 0] * (48 * 64)) if depth == 3 else bytes(48 * 64)
        self.image.publish(message)


def main() -> None:
    rclpy.init()
    peer = Peer()
    executor = MultiThreadedExecutor(2)
    executor.add_node(peer.node)
    with run_in_thread(executor):
        say(ready=True)
        for line in sys.stdin:
            peer.obey(json.loads(line))
    peer.node.destroy_node()
    rclpy.try_shutdown()


main()
