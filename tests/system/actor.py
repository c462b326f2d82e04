"""A robot that takes its time over a ROS 2 action; see ``test_by_hand.py``.

It counts to 100 and tells how far it is; who cancels it is obeyed at once.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from test_msgs.action import Fibonacci


def run(goal: Any) -> Any:
    """Count for ``order`` seconds."""
    for share in range(0, 101, 5):
        goal.publish_feedback(Fibonacci.Feedback(sequence=[share]))
        if goal.is_cancel_requested:
            goal.canceled()
            return Fibonacci.Result()
        time.sleep(goal.request.order / 20)
    goal.succeed()
    return Fibonacci.Result(sequence=[100])


def main() -> None:
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("actor")
    server = ActionServer(
        node, Fibonacci, "/survey", run,
        cancel_callback=lambda _: CancelResponse.ACCEPT,
        callback_group=ReentrantCallbackGroup(),
    )  # fmt: skip
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    executor.spin()
    server.destroy()
    os._exit(0)


if __name__ == "__main__":
    main()
