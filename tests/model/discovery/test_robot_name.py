"""A robot is called by what tells it from others that are found from the same machine."""

from __future__ import annotations

import pytest

from talaia.model.discovery.probe_report import Found, TopicFound
from talaia.model.discovery.robot_name import name_robot


def found(*robots: str, protocol: str = "ros2", **more: object) -> Found:
    topics = tuple(
        TopicFound(topic=f"{robot}/cmd_vel", type="geometry_msgs/msg/Twist", subscribers=1)
        for robot in robots
    )
    return Found(1, protocol, "here", 1.0, topics=topics, **more)  # type: ignore[arg-type]


ARMS = Found(
    1,
    "ros2",
    "here",
    1.0,
    topics=(
        TopicFound(topic="/base/cmd_vel", type="geometry_msgs/msg/Twist", subscribers=1),
        *(
            TopicFound(topic=f"/{part}/state", type="std_msgs/msg/String", publishers=1)
            for part in ("left", "right", "head")
        ),
    ),
)


@pytest.mark.parametrize(
    ("robot", "name"),
    [
        (found("/rover", domain=7), "rover"),
        (found("/rover/base", domain=0), "rover"),
        # What drives is a part of it, beside arms and a head.
        (ARMS, "lab"),
        # Several are one site, of the machine that they are seen from.
        (found("/rover", "/scout", domain=0), "lab"),
        (found("", domain=0), "lab"),
        (found("", domain=7), "lab-domain-7"),
        (found("", protocol="ros1", master="http://scout.local:11311"), "scout"),
        (found("", protocol="ros1", master="http://10.0.0.7:11311"), "10.0.0.7"),
        (found("", protocol="ros1", master="http://localhost:11311"), "lab"),
        (found("", protocol="ros1", master="http://127.0.1.1:11311"), "lab"),
        (found(protocol="indi", host="dome", port=7624), "dome"),
        (found(protocol="indi", host="localhost", port=7624), "lab"),
    ],
)
def test_robots_that_are_found_from_one_machine_have_names_of_their_own(
    robot: Found, name: str
) -> None:
    assert name_robot(robot, "lab") == name
