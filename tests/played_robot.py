"""Plays a described robot over ROS 2: its topics with their messages, services, actions, nodes.

``python tests/played_robot.py FOLDER ROBOT`` plays until its standard input ends. What is of a
package that no wheel brings is not played; its lines on standard output name what is.
"""

from __future__ import annotations

import sys
import threading
from typing import Any
from xml.sax.saxutils import quoteattr

import rclpy
from described_robot import DescribedRobot, class_of, read_robot
from rclpy.action import ActionServer
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile


def fill(message: Any, values: dict[str, Any]) -> Any:
    """Set a message's fields to a robot's values."""
    for name, value in values.items():
        now = getattr(message, name)
        if isinstance(value, dict):
            fill(now, value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            declared = message.get_fields_and_field_types()[name]
            package, _, short = declared.removeprefix("sequence<").rstrip(">").partition("/")
            kind = class_of(f"{package}/msg/{short}")
            setattr(message, name, [fill(kind(), each) for each in value])
        elif isinstance(value, list) and value and not isinstance(value[0], str):
            whole = "int" in message.get_fields_and_field_types()[name]
            setattr(message, name, [int(each) if whole else float(each) for each in value])
        else:
            setattr(message, name, type(now)(value))
    return message


def urdf_of(robot: DescribedRobot) -> str:
    """Write the robot's model: its joints with their limits."""
    joints = []
    for name, (kind, *limits) in robot.joints.items():
        said = zip(("lower", "upper", "velocity", "effort"), limits, strict=False)
        attributes = " ".join(f'{key}="{value}"' for key, value in said)
        limit = f"<limit {attributes}/>" if limits else ""
        place = f"<parent link='base_link'/><child link={quoteattr(f'{name}_link')}/>"
        joints.append(f"<link name={quoteattr(f'{name}_link')}/>")
        head = f"<joint name={quoteattr(name)} type={quoteattr(kind)}>"
        joints.append(f"{head}{place}<axis xyz='0 0 1'/>{limit}</joint>")
    return f"<robot name='played'><link name='base_link'/>{''.join(joints)}</robot>"


def srdf_of(robot: DescribedRobot) -> str:
    """Write the robot's named poses."""
    states = []
    for name, said in robot.poses.items():
        joints = "".join(
            f"<joint name={quoteattr(joint)} value='{place}'/>"
            for joint, place in said["joints"].items()
        )
        head = f"<group_state name={quoteattr(name)} group={quoteattr(said['group'])}>"
        states.append(f"{head}{joints}</group_state>")
    return f"<robot name='played'>{''.join(states)}</robot>"


class PlayedRobot:
    """The robot's nodes."""

    def __init__(self, robot: DescribedRobot) -> None:
        """Make all of it."""
        self.node = Node("played_robot")
        self.nodes = [self.node]
        self.kept: list[Any] = []
        for topic, (type_name, often, *values) in robot.published.items():
            said = values[0] if values else {}
            if topic.endswith("robot_description"):
                said = {"data": urdf_of(robot)}
            elif topic.endswith("robot_description_semantic"):
                said = {"data": srdf_of(robot)}
            self._publish(topic, type_name, often, said)
        for topic, type_name in robot.heard.items():
            if (kind := class_of(type_name)) is not None:
                self.node.create_subscription(kind, topic, lambda _: None, 10)
        for service, type_name in robot.services.items():
            if (kind := class_of(type_name)) is not None:
                self.node.create_service(kind, service, lambda _, answer: answer)
        for action, type_name in robot.actions.items():
            if (kind := class_of(type_name)) is not None:
                self.kept.append(ActionServer(self.node, kind, action, lambda _: None))
        for full, values in robot.parameters.items():
            space, _, name = full.rpartition("/")
            node = Node(name, namespace=space or "/")
            for parameter, value in values.items():
                node.declare_parameter(parameter, value)
            self.nodes.append(node)

    def _publish(self, topic: str, type_name: str, often: float | str, said: dict) -> None:
        kind = class_of(type_name)
        if kind is None:
            return
        latched = often == "latched"
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
        publisher = self.node.create_publisher(
            kind, topic, QoSProfile(depth=5, durability=durability)
        )
        if type_name == "sensor_msgs/msg/Image":
            grey = {"encoding": "mono8", "width": 8, "height": 6, "step": 8, "data": [90] * 48}
            said = {**grey, **said}
        message = fill(kind(), said)
        if latched:
            publisher.publish(message)
        elif often:
            # Two cores play all of it: nobody judges the rates.
            self.node.create_timer(1 / min(float(often), 10), lambda: publisher.publish(message))
        self.kept.append(publisher)


def main() -> None:
    """Play until nobody listens any more."""
    folder, name = sys.argv[1:]
    rclpy.init()
    robot = PlayedRobot(read_robot(folder, name))
    executor = SingleThreadedExecutor()
    for node in robot.nodes:
        executor.add_node(node)
    sys.stdout.write("playing\n")
    sys.stdout.flush()
    threading.Thread(target=lambda: (sys.stdin.read(), rclpy.try_shutdown()), daemon=True).start()
    try:
        executor.spin()
    except Exception:  # noqa: BLE001 - rclpy raises bare kinds when its context ends
        return


if __name__ == "__main__":
    main()
