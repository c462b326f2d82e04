"""Requests that were written for the robot, and the commands that make them. Nothing is started."""

from __future__ import annotations

import pytest

from talaia.hub.auth.permissions import Grants, Permission, Right
from talaia.hub.clients.account_offer import make_account_offer
from talaia.hub.clients.robot_names import RobotCall, full_type, make_robot_names
from talaia.model.site import CommandKind
from talaia.model.yaml_text.load import load_site

pytestmark = pytest.mark.pure

SITE = load_site(
    """
talaia: 1
site: agv
name: Vehicle
connections:
  robot: {kind: ros2}
  second: {kind: ros1}
  station: {kind: rosbridge, url: "ws://station:9090"}
  tools: {kind: process}
devices:
  base:
    name: Base
    connection: robot
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
    commands:
      light: {name: Light, target: /light, type: std_srvs/srv/SetBool, fixed: {data: true}}
      dark: {name: Dark, target: /light, type: std_srvs/srv/SetBool, fixed: {data: false}}
      add:
        name: Add
        target: /add_two_ints
        type: example_interfaces/srv/AddTwoInts
        arguments:
          first: {type: integer, field: a, minimum: -10, maximum: 10}
          second: {type: integer, field: b, default: 4}
      place:
        name: Place
        kind: topic
        target: /initialpose
        type: geometry_msgs/msg/PoseWithCovarianceStamped
        fixed: {header.frame_id: map}
        arguments:
          x: {type: number, field: pose.pose.position.x}
          spread: {type: number, field: "pose.covariance[0]", default: 0.25}
      values:
        name: Values
        kind: topic
        target: /values
        type: std_msgs/msg/Float64MultiArray
        arguments: {all: {type: numbers, field: data}}
      raw:
        name: Raw
        kind: topic
        target: /raw
        type: std_msgs/msg/UInt8MultiArray
        arguments: {all: {type: bytes, field: data}}
      crawl: {name: Crawl, kind: topic, target: /cmd_vel, type: geometry_msgs/msg/Twist}
      count:
        name: Count
        kind: action
        target: /count
        type: test_msgs/action/Fibonacci
        arguments: {order: {type: integer, field: order}}
      gain:
        name: Gain
        kind: parameter
        target: /node
        arguments: {gain: {type: number, field: gain}}
      reset: {name: Reset, target: /reset, type: std_srvs/srv/Trigger}
  arm:
    name: Arm
    connection: second
    commands:
      reset: {name: Reset, target: /reset, type: std_srvs/srv/Trigger}
      say:
        name: Say
        kind: topic
        target: /say
        type: std_msgs/msg/String
        arguments: {words: {type: text, field: data, max_length: 5}}
  dome:
    name: Dome
    connection: station
    commands:
      open: {name: Open, target: /open, type: std_srvs/srv/Trigger}
  shell:
    name: Shell
    connection: tools
    commands: {tidy: {name: Tidy, target: "/tidy"}}
"""
)


def names_of(*permissions):
    return make_robot_names(SITE, make_account_offer(SITE, Grants(frozenset(permissions))).commands)


ALL = names_of(Permission(Right.USE))


def test_names_are_those_of_what_the_account_may_call_by_ros() -> None:
    assert set(ALL.services) == {"/light", "/add_two_ints", "/reset", "/open"}
    assert set(ALL.topics) == {"/initialpose", "/values", "/raw", "/say"}
    assert set(ALL.actions) == {"/count"}
    assert ALL.actions["/count"].kind is CommandKind.ACTION
    arm = names_of(Permission(Right.USE, "agv", "arm"), Permission(Right.VIEW))
    assert (set(arm.services), set(arm.topics), arm.actions) == ({"/reset"}, {"/say"}, {})


def test_topic_by_which_somebody_drives_is_none_of_a_command_whoever_may_see_the_device() -> None:
    assert "/cmd_vel" not in ALL.topics
    for right in (Right.VIEW, Right.USE):
        assert "/cmd_vel" not in names_of(Permission(right, "agv", "base")).topics


FITS = [
    ("/light", {"data": True}, ("light", {})),
    ("/light", {"data": False}, ("dark", {})),
    # What is left out is what ROS has where nothing was written.
    ("/light", {}, ("dark", {})),
    ("/add_two_ints", {"a": 1, "b": 2}, ("add", {"first": 1, "second": 2})),
    ("/add_two_ints", {"a": 3.0}, ("add", {"first": 3})),
    ("/count", {"order": 5}, ("count", {"order": 5})),
    ("/values", {"layout": {"dim": []}, "data": [1, 2.5]}, ("values", {"all": "[1, 2.5]"})),
    ("/raw", {"data": "AAH/"}, ("raw", {"all": "[0, 1, 255]"})),
    (
        "/initialpose",
        {
            "header": {"seq": 3, "stamp": {"sec": 9, "nanosec": 1}, "frame_id": "map"},
            "pose": {
                "pose": {
                    "position": {"x": 1.5, "y": 0, "z": 0.0},
                    "orientation": {"x": 0, "y": 0, "z": 0, "w": 1},
                },
                "covariance": [0.5] + [0.0] * 35,
            },
        },
        ("place", {"x": 1.5, "spread": 0.5}),
    ),
]


def find(name, request):
    named = {**ALL.services, **ALL.topics, **ALL.actions}
    return named[name].find_command(request)


@pytest.mark.parametrize(("name", "request_", "expected"), FITS)
def test_request_becomes_the_command_that_makes_this_very_request(name, request_, expected) -> None:
    assert find(name, request_) == RobotCall("base", *expected)


POSE = {"header": {"frame_id": "map"}, "pose": {"pose": {"position": {"x": 1}}}}
REFUSED = [
    ("/light", {"data": 1}, "data can only be true here, not 1"),
    ("/light", {"data": True, "more": 1}, "base/light: more cannot be set here; base/dark: more"),
    ("/add_two_ints", {"b": 2}, "the field a is missing"),
    ("/add_two_ints", {"a": 11}, "11 is above 10"),
    ("/add_two_ints", {"a": "1"}, "a: expected a whole number, found '1'"),
    ("/add_two_ints", {"a": True}, "a: expected a whole number, found true"),
    ("/add_two_ints", {"a": 1.5}, "a: expected a whole number, found 1.5"),
    ("/add_two_ints", {"a": 10**40}, "a: expected a whole number"),
    ("/add_two_ints", {"a": None}, "a: expected a whole number, found None"),
    ("/add_two_ints", {"a": 1, "c": 2}, "c cannot be set here"),
    ("/values", {"data": [[1]]}, "data: expected a list"),
    ("/values", {"data": "1, 2"}, "data: expected a list"),
    ("/values", {"data": [1], "layout": {"data_offset": 1}}, "layout cannot be set here"),
    ("/raw", {"data": "!"}, "data: expected a list"),
    ("/initialpose", {**POSE, "header": {"frame_id": "odom"}}, "header.frame_id can only be 'map'"),
    ("/initialpose", {**POSE, "header": 3}, "header has fields of its own"),
    ("/initialpose", {**POSE, "pose": {"pose": {"position": {"y": 1}}}}, "pose.pose.position.y"),
    ("/initialpose", {**POSE, "pose": {"covariance": [1, 2]}}, "pose.covariance[1] cannot be set"),
    ("/initialpose", {**POSE, "stamp": 1}, "stamp cannot be set here"),
    ("/say", {"data": "too long"}, "at most 5 characters"),
    ("/say", {"data": ["a"]}, "data: expected a text"),
]


@pytest.mark.parametrize(("name", "request_", "why"), REFUSED)
def test_request_that_no_command_makes_is_refused_in_words(name, request_, why) -> None:
    assert why in find(name, request_)


def test_name_that_several_robots_have_moves_none_of_them_unless_one_alone_is_meant() -> None:
    why = find("/reset", {})
    assert "several robots of this site have /reset; call a command: base/reset, arm/reset" in why
    arm = names_of(Permission(Right.USE, "agv", "arm")).services["/reset"]
    assert arm.find_command({}) == RobotCall("arm", "reset", {})


def test_types_of_ros_1_and_ros_2_are_one() -> None:
    assert full_type("std_msgs/String") == full_type("std_msgs/msg/String") == "std_msgs/msg/String"
    assert full_type("std_srvs/srv/Trigger") == "std_srvs/srv/Trigger"
