"""A robot with message packages that the gateway lacks: JSON lines in, JSON lines out.

Started as a script, with every package there; the test keeps some of them from the gateway.
"""

from __future__ import annotations

import json
import pathlib
import sys
import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from diagnostic_msgs.srv import AddDiagnostics
from nav_msgs.msg import Path
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import Temperature
from std_msgs.msg import String
from test_msgs.action import Fibonacci
from test_msgs.msg import BoundedSequences, MultiNested, WStrings
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class

# A script finds what lies beside it; this lies two folders above.
sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))

from executor_thread import run_in_thread

# Of no version of any type.
WRONG_HASH = "RIHS01_" + "ab" * 32


def say(**row: object) -> None:
    sys.stdout.write(json.dumps(row) + "\n")
    sys.stdout.flush()


class Peer:
    """Two nodes: one that describes its types, and one that does not."""

    def __init__(self) -> None:  # noqa: D107
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.node = Node("types_peer", enable_rosout=False)
        silent = Parameter("start_type_description_service", value=False)
        self.silent = Node("silent_peer", enable_rosout=False, parameter_overrides=[silent])
        make = self.node.create_publisher
        self.publishers = {
            "diagnostics": make(DiagnosticArray, "/diagnostics", 10),
            "trajectory": make(JointTrajectory, "/arm/trajectory", latched),
            "words": make(WStrings, "/own/words", latched),
            "nested": make(MultiNested, "/own/nested", latched),
            "temperature": make(Temperature, "/temperature", 10),
            "mode": make(String, "/mode", latched),
            "plan": make(Path, "/plan", latched),
            "undescribed": self.silent.create_publisher(
                BoundedSequences, "/own/undescribed", latched
            ),
        }
        self.node.create_subscription(
            MultiNested, "/own/orders", lambda got: say(order=self.words_of(got)), 10
        )
        self.node.create_subscription(
            WStrings,
            "/own/speech",
            lambda got: say(speech=[got.wstring_value, *got.array_of_wstrings]),
            10,
        )
        self.counting = ActionServer(
            self.node,
            Fibonacci,
            "/count",
            self.count,
            goal_callback=lambda goal: (
                GoalResponse.REJECT if goal.order == 0 else GoalResponse.ACCEPT
            ),
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        self.node.create_service(AddDiagnostics, "/add", self.add)
        self.silent.create_service(AddDiagnostics, "/silent/add", self.add)

    def count(self, goal: ServerGoalHandle) -> Fibonacci.Result:
        """Count until the order, or, of a great one, until it is cancelled."""
        say(goal=goal.request.order)
        for number in range(goal.request.order):
            goal.publish_feedback(Fibonacci.Feedback(sequence=[number + 1]))
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result()
            time.sleep(0.02)
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])

    @staticmethod
    def words_of(message: MultiNested) -> list[object]:
        """Give what an order says: of an array within an array, and what nobody set."""
        inner = message.array_of_arrays[1]
        return [inner.string_values[2], int(inner.int32_values[0]), inner.bool_values[1]]

    def add(
        self, request: AddDiagnostics.Request, response: AddDiagnostics.Response
    ) -> AddDiagnostics.Response:
        say(added=request.load_namespace)
        response.success = request.load_namespace.startswith("/")
        response.message = f"asked for {request.load_namespace[:20]}"
        return response

    def obey(self, order: dict[str, object]) -> None:
        match order["do"]:
            case "begin_other_version":
                self.begin_other_version(str(order["topic"]), str(order["type"]))
            case "end_other_version":
                self.node.destroy_publisher(self.publishers.pop(str(order["topic"])))
            case _:
                self.publish(order)

    def begin_other_version(self, topic: str, type_name: str) -> None:
        """Publish bytes as another version of a type, as its hash has it."""
        kind = made_class(type_name, WRONG_HASH)
        publisher = self.publishers[topic] = self.node.create_publisher(kind, topic, 10)
        forget_error()
        publisher.publish(b"\x00\x01\x00\x00" + bytes(64))

    def publish(self, order: dict[str, object]) -> None:
        message = getattr(self, str(order["do"]))(order)
        self.publishers[str(order["do"])].publish(message)
        say(did=order["do"])

    def diagnostics(self, order: dict[str, object]) -> DiagnosticArray:
        levels: dict[str, int] = order["levels"]
        return DiagnosticArray(
            status=[
                DiagnosticStatus(
                    level=bytes([level]),
                    name=name,
                    message=f"{name} is at {level}",
                    values=[KeyValue(key="temp", value="81.5")],
                )
                for name, level in levels.items()
            ]
        )

    def trajectory(self, order: dict[str, object]) -> JointTrajectory:
        points = [JointTrajectoryPoint(positions=place) for place in order["points"]]
        return JointTrajectory(joint_names=["shoulder", "elbow"], points=points)

    def words(self, order: dict[str, object]) -> WStrings:
        return WStrings(wstring_value=str(order["text"]), unbounded_sequence_of_wstrings=["a", "✓"])

    def nested(self, order: dict[str, object]) -> MultiNested:
        inner = BoundedSequences(string_values=["x", str(order["text"])], int16_values=[3, -4])
        return MultiNested(bounded_sequence_of_bounded_sequences=[inner])

    def undescribed(self, order: dict[str, object]) -> BoundedSequences:
        return BoundedSequences(alignment_check=int(order["check"]))

    def temperature(self, order: dict[str, object]) -> Temperature:
        """Publish a value with a stamp so many seconds before now."""
        message = Temperature(temperature=float(order["value"]))
        now = self.node.get_clock().now().nanoseconds - round(float(order["late"]) * 1e9)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        say(stamp=now)
        return message

    def mode(self, order: dict[str, object]) -> String:
        return String(data=str(order["text"]))

    def plan(self, order: dict[str, object]) -> Path:
        return Path()


def main() -> None:
    rclpy.init()
    peer = Peer()
    executor = MultiThreadedExecutor(2)
    executor.add_node(peer.node)
    executor.add_node(peer.silent)
    with run_in_thread(executor):
        say(ready=True)
        for line in sys.stdin:
            peer.obey(json.loads(line))
    rclpy.try_shutdown()


main()
