"""A sensor that no signal is of is told once, so that a person may add it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from talaia.gateway.adapters.connection_scope import scopes_of
from talaia.gateway.adapters.topic_readers import (
    MOST_ANNOUNCED,
    SampleBuffer,
    TopicPlan,
    plans_of,
)
from talaia.gateway.ports import ChannelReading
from talaia.model.connections.ros import DIAGNOSTICS
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

METRIC = "std_msgs/msg/String"
SITE = """
talaia: 1
site: s
name: S
ros2: {}
devices:
  base:
    name: Base
    signals:
      wheel1: {name: Wheel, source: {topic: /said, type: TYPE, name: wheel1}}
"""


def plan_of(announced: list[tuple[str, str, str]], type_name: str = METRIC) -> TopicPlan:
    (scope,) = scopes_of(load_site(SITE.replace("TYPE", type_name)))
    (plan,) = plans_of(scope, {}, lambda *_: None, announce=lambda *about: announced.append(about))
    return plan


def say(plan: TopicPlan, *names: str) -> None:
    for name in names:
        message = SimpleNamespace(data=f"{{'name': {name!r}, 'magnitude': 1}}")
        plan.read_message(message, 1, 1, SampleBuffer())


def test_a_sensor_of_no_signal_is_told_once_also_after_a_change_of_the_description() -> None:
    announced: list[tuple[str, str, str]] = []
    plan = plan_of(announced)
    say(plan, "wheel1", "wheel2", "wheel2")
    assert announced == [("base", "/said", "wheel2")]
    changed = plan_of(announced)
    changed.take_over(plan)
    say(changed, "wheel2", "wheel3")
    assert announced == [("base", "/said", "wheel2"), ("base", "/said", "wheel3")]


def test_a_robot_that_counts_in_names_is_told_of_no_more_than_some() -> None:
    announced: list[tuple[str, str, str]] = []
    say(plan_of(announced), *(f"run{number}" for number in range(10 * MOST_ANNOUNCED)))
    assert len(announced) == MOST_ANNOUNCED


def test_of_diagnostics_nobody_is_told_for_people_choose_some_of_them() -> None:
    announced: list[tuple[str, str, str]] = []
    plan = plan_of(announced, DIAGNOSTICS)
    status = SimpleNamespace(level=b"\x00", name="lidar: rate", message="ok")
    plan.read_message(SimpleNamespace(status=[status]), 1, 1, SampleBuffer())
    assert announced == []


FENCED = """
talaia: 1
site: s
name: S
ros2: {}
map:
  origin: {latitude: 41, longitude: 2}
  zones:
    yard:
      name: Yard
      geometry:
        {type: Polygon, coordinates: [[[2, 41], [2.01, 41], [2.01, 41.01], [2, 41]]]}
devices:
  base:
    name: Base
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
    signals:
      pose:
        {name: Pose, type: position, max_rate: 1,
         source: {topic: /odom, type: nav_msgs/msg/Odometry, field: pose.position, stamp: stamp}}
interlocks:
  fence: {name: Fence, when: [{signal: base/pose, outside: yard}], refuse: [base/drive]}
"""


def test_a_position_that_safety_goes_by_is_one_reading_of_one_message_with_its_stamp() -> None:
    (scope,) = scopes_of(load_site(FENCED))
    latest: dict[str, ChannelReading] = {}
    (plan,) = plans_of(scope, latest, lambda *_: None)
    for second in (1, 2, 2):
        place = SimpleNamespace(x=float(second), y=5.0, z=0.0)
        pose = SimpleNamespace(position=place)
        stamp = SimpleNamespace(sec=second, nanosec=0)
        said = SimpleNamespace(pose=pose, stamp=stamp)
        plan.read_message(said, second, second * 10 + len(latest), SampleBuffer())
    reading = latest["base/pose"]
    # All of it, before any thinning, since the moment at which the stamp went on.
    assert reading.numbers[:2] == (2.0, 5.0)
    assert (reading.stamp_ns, reading.mono_ns < reading.arrived_ns) == (2_000_000_000, True)
