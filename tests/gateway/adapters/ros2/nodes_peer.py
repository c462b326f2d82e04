"""A robot of a life-cycle node with parameters, and of one that talks much: JSON lines in and out.

Started as a script. What it is told to do, it says when it has done it.
"""

from __future__ import annotations

import json
import pathlib
import sys
from array import array
from collections.abc import Callable
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

# A script finds what lies beside it; this lies two folders above.
sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))

from executor_thread import run_in_thread

# Each in a line of its own: rclpy lets no line of code change its level.
LEVELS: dict[str, Callable[[Any, str], None]] = {
    "info": lambda logger, text: logger.info(text),
    "warning": lambda logger, text: logger.warning(text),
    "error": lambda logger, text: logger.error(text),
}


def say(**row: object) -> None:
    sys.stdout.write(json.dumps(row) + "\n")
    sys.stdout.flush()


def plain(value: Any) -> Any:
    """Give a parameter's value as JSON has it; a byte as a number."""
    if isinstance(value, (list, tuple, array)):
        return [each[0] if isinstance(each, bytes) else each for each in value]
    return value


class Lidar(LifecycleNode):
    """Does what it is asked for, but fails to be activated when it was told so."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__("lidar", namespace="/front")
        self.fails = False
        within = ParameterDescriptor(
            description="Turns a second",
            floating_point_range=[FloatingPointRange(from_value=1.0, to_value=20.0)],
        )
        self.declare_parameter("motor.rate", 10.0, within)
        self.declare_parameter("model", "A1", ParameterDescriptor(read_only=True))
        self.declare_parameter("echoes", 2)
        self.declare_parameter("wifi_password", "hunter2")
        self.declare_parameter("angles", [1.0, 2.0])
        self.declare_parameter("beams", [1, -2])
        self.declare_parameter("mirrors", [True, False])
        self.declare_parameter("frames", ["a, b", "c"])
        self.declare_parameter("key_code", [1])
        self.declare_parameter("serial", [b"\x01", b"\xff"])
        self.declare_parameter("mask", list(range(200)))
        self.add_on_set_parameters_callback(self.judge)

    def judge(self, parameters: list[Parameter]) -> SetParametersResult:
        if any(each.name == "echoes" and each.value > 3 for each in parameters):
            return SetParametersResult(successful=False, reason="at most three echoes")
        say(set={each.name: plain(each.value) for each in parameters})
        return SetParametersResult(successful=True)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        say(activating=not self.fails)
        if self.fails:
            return TransitionCallbackReturn.FAILURE
        return super().on_activate(state)


def main() -> None:
    rclpy.init()
    lidar, talker = Lidar(), Node("talker")
    clock = talker.create_publisher(Clock, "/clock", 10)
    heat = talker.create_publisher(Temperature, "/tank/heat", 10)
    level = talker.create_publisher(Float64, "/tank/level", 10)
    executor = SingleThreadedExecutor()
    executor.add_node(lidar)
    executor.add_node(talker)
    with run_in_thread(executor):
        say(ready=True)
        for line in sys.stdin:
            order = json.loads(line)
            match order["do"]:
                case "fail":
                    lidar.fails = order["fails"]
                case "log":
                    logger = (lidar if order.get("node") == "lidar" else talker).get_logger()
                    for number in range(order["count"]):
                        LEVELS[order["level"]](logger, order["text"].format(number))
                case "clock":
                    clock.publish(Clock(clock=Time(sec=order["sec"])))
                case "heat":
                    message = Temperature(temperature=order["value"])
                    message.header.stamp.sec = order["sec"]
                    heat.publish(message)
                case "level":
                    level.publish(Float64(data=order["value"]))
            say(did=order["do"])
    rclpy.try_shutdown()


main()
