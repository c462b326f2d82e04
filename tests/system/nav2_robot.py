"""A robot that drives to a pose by ``nav2_msgs/action/NavigateToPose``, started as a script.

The package is not on this machine: its messages and hashes are made by `rosbags` of the texts in
Nav2's public repository, and the action is what ROS makes of one: two services, a cancel service
and a topic. It takes the way that is named in metres of x at one metre a second, and tells what is
left of it. A goal beyond 100 m is not accepted, and one of negative y is aborted with Nav2's error.
What it was asked stands on stdout.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import ros_wheels_bootstrapper  # noqa: F401 - sets the library path before rclpy is loaded

# isort: split
import rclpy
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from std_msgs.msg import Float64

from talaia.gateway.adapters.ros2.made_types.made_message_class import forget_error, made_class
from talaia.gateway.adapters.ros2.rclpy_bridge.made_service_class import MadeMessage, made_service

ACTION = "nav2_msgs/action/NavigateToPose"
# https://github.com/ros-navigation/navigation2, nav2_msgs/action/NavigateToPose.action
GOAL = "geometry_msgs/PoseStamped pose\nstring behavior_tree\n"
RESULT = "uint16 NONE=0\nuint16 UNKNOWN=9000\nuint16 error_code\nstring error_msg\n"
FEEDBACK = (
    "geometry_msgs/PoseStamped current_pose\nbuiltin_interfaces/Duration navigation_time\n"
    "builtin_interfaces/Duration estimated_time_remaining\nint16 number_of_recoveries\n"
    "float32 distance_remaining\n"
)
# What ROS makes of an action.
PARTS = {
    "Goal": GOAL,
    "Result": RESULT,
    "Feedback": FEEDBACK,
    "FeedbackMessage": "unique_identifier_msgs/UUID goal_id\nPART_Feedback feedback\n",
    "SendGoal_Request": "unique_identifier_msgs/UUID goal_id\nPART_Goal goal\n",
    "SendGoal_Response": "bool accepted\nbuiltin_interfaces/Time stamp\n",
    "GetResult_Request": "unique_identifier_msgs/UUID goal_id\n",
    "GetResult_Response": "int8 status\nPART_Result result\n",
}
# As ROS has it, but that `char` is what it is to ROS and not what it is to rosbags.
EVENT_INFO = "service_msgs/msg/ServiceEventInfo"
EVENT_INFO_TEXT = (
    "uint8 event_type\nbuiltin_interfaces/Time stamp\nuint8[16] client_gid\nint64 sequence_number\n"
)
BEAT_S = 0.1
FARTHEST_M = 100.0


def action_types() -> Any:
    """Register all that ROS makes of the action; services as messages of their three parts."""
    store = get_typestore(Stores.LATEST)
    store.fielddefs[EVENT_INFO] = get_types_from_msg(EVENT_INFO_TEXT, EVENT_INFO)[EVENT_INFO]
    for ending, text in PARTS.items():
        # rosbags takes each name for a message's.
        found = get_types_from_msg(
            text.replace("PART", "NavigateToPose"), f"nav2_msgs/msg/{ending}"
        )
        (shape,) = found.values()
        store.register({f"{ACTION}_{ending}": _within_the_action(shape)})
    for service in ("SendGoal", "GetResult"):
        name = f"{ACTION}_{service}"
        parts = {end: (Nodetype.NAME, f"{name}_{end}") for end in ("Request", "Response", "Event")}
        event = [
            ("info", (Nodetype.NAME, EVENT_INFO)),
            ("request", (Nodetype.SEQUENCE, (parts["Request"], 1))),
            ("response", (Nodetype.SEQUENCE, (parts["Response"], 1))),
        ]
        store.register({f"{name}_Event": ([], event)})
        whole = [(f"{ending.lower()}_message", part) for ending, part in parts.items()]
        store.register({name: ([], whole)})
    return store


def _within_the_action(shape: Any) -> Any:
    """Name the action's own parts as ROS does: in its folder, not among the messages."""
    constants, fields = shape
    own = "nav2_msgs/msg/NavigateToPose_"
    return constants, [
        (name, (kind, f"{ACTION}_{of.removeprefix(own)}"))
        if isinstance(of, str) and of.startswith(own)
        else (name, (kind, of))
        for name, (kind, of) in fields
    ]


def say(*words: object) -> None:
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


class Navigator(Node):
    """One goal at a time, as Nav2's: a new one takes the place of the one before."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__("bt_navigator")
        self.types = action_types()
        self.goal: bytes | None = None
        self.left = 0.0
        self.aborts = False
        self.ends: dict[bytes, Future] = {}
        self.made = {
            ending: made_service(name, self.types.hash_rihs01(name))
            for ending in ("SendGoal", "GetResult")
            if (name := f"{ACTION}_{ending}")
        }
        at = "/navigate_to_pose/_action"
        self.create_service(self.made["SendGoal"], f"{at}/send_goal", self.take_goal)
        # It waits for an end that the others bring, so it must not keep them from their turn.
        apart = ReentrantCallbackGroup()
        self.create_service(
            self.made["GetResult"], f"{at}/get_result", self.give_result, callback_group=apart
        )
        self.create_service(CancelGoal, f"{at}/cancel_goal", self.cancel_goal)
        feedback = f"{ACTION}_FeedbackMessage"
        made = made_class(feedback, self.types.hash_rihs01(feedback))
        self.feedback = self.create_publisher(made, f"{at}/feedback", 10)
        forget_error()
        self.ready = self.create_publisher(Float64, "/ready", 10)
        self.create_timer(BEAT_S, self.drive)

    def part(self, ending: str, **fields: Any) -> Any:
        return self.types.types[f"{ACTION}_{ending}"](**fields)

    def answer(self, service: str, **fields: Any) -> Any:
        name = f"{ACTION}_{service}_Response"
        raw = self.types.serialize_cdr(self.types.types[name](**fields), name)
        return self.made[service].Response(bytes(raw))

    def take_goal(self, request: MadeMessage, _: MadeMessage) -> Any:
        asked = self.types.deserialize_cdr(request.raw, f"{ACTION}_SendGoal_Request")
        place, frame = asked.goal.pose.pose.position, asked.goal.pose.header.frame_id
        say("goal", frame, place.x, place.y)
        accepted = abs(place.x) <= FARTHEST_M
        if accepted:
            if self.goal is not None:
                self.end(GoalStatus.STATUS_ABORTED)
            self.goal, self.left = bytes(asked.goal_id.uuid), abs(place.x)
            self.aborts = place.y < 0
            self.ends[self.goal] = Future()
        stamp = self.types.types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
        return self.answer("SendGoal", accepted=accepted, stamp=stamp)

    async def give_result(self, request: MadeMessage, _: MadeMessage) -> Any:
        asked = self.types.deserialize_cdr(request.raw, f"{ACTION}_GetResult_Request")
        status = await self.ends.setdefault(bytes(asked.goal_id.uuid), Future())
        failed = status == GoalStatus.STATUS_ABORTED
        result = self.part(
            "Result", error_code=9000 if failed else 0, error_msg="no path" if failed else ""
        )
        return self.answer("GetResult", status=status, result=result)

    def cancel_goal(self, request: CancelGoal.Request, answer: CancelGoal.Response) -> Any:
        if bytes(request.goal_info.goal_id.uuid) == self.goal:
            say("cancelled with", f"{self.left:.1f}")
            answer.goals_canceling = [request.goal_info]
            self.end(GoalStatus.STATUS_CANCELED)
        else:
            answer.return_code = CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID
        return answer

    def end(self, status: int) -> None:
        if self.goal is not None:
            self.ends[self.goal].set_result(status)
            self.goal = None

    def drive(self) -> None:
        self.ready.publish(Float64(data=1.0))
        if self.goal is None:
            return
        self.left -= BEAT_S
        if self.aborts or self.left <= 0:
            self.end(GoalStatus.STATUS_ABORTED if self.aborts else GoalStatus.STATUS_SUCCEEDED)
            return
        types = self.types.types
        stamp = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
        none = types["builtin_interfaces/msg/Duration"](sec=0, nanosec=0)
        pose = types["geometry_msgs/msg/PoseStamped"](
            header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="map"),
            pose=types["geometry_msgs/msg/Pose"](
                position=types["geometry_msgs/msg/Point"](x=0.0, y=0.0, z=0.0),
                orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            ),
        )
        told = self.part(
            "Feedback", current_pose=pose, navigation_time=none, estimated_time_remaining=none,
            number_of_recoveries=0, distance_remaining=self.left,
        )  # fmt: skip
        uuid = types["unique_identifier_msgs/msg/UUID"](uuid=_bytes_of(self.goal))
        name = f"{ACTION}_FeedbackMessage"
        whole = self.part("FeedbackMessage", goal_id=uuid, feedback=told)
        self.feedback.publish(bytes(self.types.serialize_cdr(whole, name)))


def _bytes_of(goal: bytes) -> Any:
    import numpy as np

    return np.frombuffer(goal, np.uint8)


def main() -> None:
    rclpy.init()
    node = Navigator()
    # One thread: the answers of made classes are written by Python from within the middleware.
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    say("ready")
    executor.spin()
    os._exit(0)


if __name__ == "__main__":
    main()
