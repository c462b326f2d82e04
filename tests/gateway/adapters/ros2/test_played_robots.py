"""Described robots played over ROS 2: a real probe finds of them what their description says."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from described_robot import class_of, found_of, read_robot
from patience import PATIENCE_S

from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.sim.ros_domain import domain_environment

pytestmark = pytest.mark.robot
TESTS = Path(__file__).parents[3]


@pytest.mark.parametrize("name", ["ur5e", "turtlebot3"])
def test_a_probe_finds_of_a_played_robot_what_its_description_says(
    name: str, ros_domain: int
) -> None:
    # Not before there is a ROS: it prepares this process for it.
    from talaia.gateway.adapters.ros2.probe import probe_graph

    robot = read_robot("chosen", name)
    described = found_of(robot)
    # Of packages that are installed here; of the others nothing can be played.
    wanted = {topic.topic: topic for topic in described.topics if class_of(topic.type) is not None}
    environment = {
        **os.environ,
        **domain_environment(ros_domain),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    with subprocess.Popen(
        [sys.executable, str(TESTS / "played_robot.py"), "chosen", name],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        text=True,
    ) as played:
        try:
            assert played.stdout.readline() == "playing\n"
            ends = time.monotonic() + PATIENCE_S
            while True:
                found = probe_graph(ros_domain, 3.0)
                got = {topic.topic: topic for topic in found.topics}
                # On a busy machine a robot is not heard of in so short a time.
                if set(wanted) <= set(got) or time.monotonic() > ends:
                    break
        finally:
            played.stdin.close()
            played.wait(20)
    assert set(wanted) <= set(got)
    for topic, each in wanted.items():
        assert bool(got[topic].publishers) == bool(each.publishers), topic
        assert bool(got[topic].subscribers) == bool(each.subscribers), topic
        if topic.endswith(("robot_description", "robot_description_semantic")):
            continue
        fields = {field.path: (field.type, field.unit) for field in each.fields}
        seen = {field.path: (field.type, field.unit) for field in got[topic].fields}
        assert seen == fields, topic
    if described.joints and "/robot_description" in got:
        assert {joint.joint: joint for joint in found.joints} == {
            joint.joint: joint for joint in described.joints
        }
    assert {pose.pose: pose for pose in found.poses} == {
        pose.pose: pose for pose in described.poses
    }
    made = propose_description(found, "robot", "Robot", "UTC")
    assert check_site(made.site) == []
