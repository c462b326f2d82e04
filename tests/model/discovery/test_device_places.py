"""Which device a topic or service is put on: by its type, then by its namespace."""

from __future__ import annotations

import pytest

from talaia.model.closed_lists import DeviceKind
from talaia.model.discovery.device_places import place_of, place_order
from talaia.model.discovery.probe_report import TopicFound
from talaia.model.discovery.topic_words import free_word, path_in_words

BASE = TopicFound(topic="/rover/cmd_vel", type="geometry_msgs/msg/Twist", subscribers=1)


@pytest.mark.parametrize(
    ("topic", "type_name", "word"),
    [
        ("/front/image_raw", "sensor_msgs/msg/Image", "camera"),
        ("/rover/front/image_raw", "sensor_msgs/msg/Image", "rover_camera"),
        ("/battery", "sensor_msgs/msg/BatteryState", "power"),
        ("/rover/odom", "nav_msgs/msg/Odometry", "rover_base"),
        ("/arm/joint_states", "sensor_msgs/msg/JointState", "arm"),
        ("/joint_states", "sensor_msgs/msg/JointState", "joints"),
        ("/temperature", "sensor_msgs/msg/Temperature", "sensors"),
        ("/state", "gripper_msgs/msg/State", "gripper"),
    ],
)
def test_a_topic_is_put_on_the_device_of_its_type_or_else_of_its_namespace(
    topic: str, type_name: str, word: str
) -> None:
    assert place_of(topic, type_name, ()).word == word


@pytest.mark.parametrize(
    ("topic", "type_name", "word", "kind"),
    [
        # A dome that nobody took for one closes in no rain, and nobody would say so.
        ("/dome/closed", "std_msgs/msg/Bool", "dome", DeviceKind.DOME),
        ("/site/telescope/park", "std_srvs/srv/Trigger", "site_telescope", DeviceKind.TELESCOPE),
        ("/weather/rain", "std_msgs/msg/Float64", "weather", DeviceKind.WEATHER),
        ("/cctv/image", "sensor_msgs/msg/Image", "cctv", DeviceKind.CAMERA),
        ("/cctv/status", "std_msgs/msg/String", "cctv", DeviceKind.CAMERA),
        ("/pdu/on1", "std_msgs/msg/Bool", "pdu", DeviceKind.POWER),
        ("/domestic/closed", "std_msgs/msg/Bool", "domestic", DeviceKind.OTHER),
    ],
)
def test_a_namespace_that_says_what_is_in_it_makes_a_device_of_that_kind(
    topic: str, type_name: str, word: str, kind: DeviceKind
) -> None:
    place = place_of(topic, type_name, ())
    assert (place.word, place.kind) == (word, kind)


def test_names_are_said_in_small_letters_but_for_abbreviations() -> None:
    names = [
        place_of(topic, "std_msgs/msg/Bool", ()).name
        for topic in ("/platform/mcu/status/x", "/sensors/gps/gps/x", "/imu/x", "/cctv/x")
    ]
    assert names == ["Platform MCU status", "Sensors GPS", "IMU", "CCTV"]


def test_a_service_without_a_namespace_belongs_to_what_is_driven() -> None:
    assert place_of("/reset", "std_srvs/srv/Trigger", (BASE,)).word == "rover_base"
    assert place_of("/reset", "std_srvs/srv/Trigger", ()).word == "robot"


ODOMETRY = TopicFound(topic="/rover/odom", type="nav_msgs/msg/Odometry", publishers=1)


@pytest.mark.parametrize("robot", [BASE, ODOMETRY])
def test_what_shares_the_namespace_of_a_robot_is_a_part_of_it(robot: TopicFound) -> None:
    place = place_of("/rover/imu", "sensor_msgs/msg/Imu", (robot,))
    assert place == place_of("/rover/odom", "nav_msgs/msg/Odometry", (robot,))
    assert place == place_of("/rover/reset", "std_srvs/srv/Trigger", (robot,))
    assert place_of("/rover/arm/state", "own_msgs/msg/State", (robot,)).word == "rover_arm"


def test_vehicles_come_before_cameras_and_those_before_all_others() -> None:
    camera = place_of("/front/image_raw", "sensor_msgs/msg/Image", ())
    base = place_of("/odom", "nav_msgs/msg/Odometry", ())
    arm = place_of("/arm/state", "own_msgs/msg/State", ())
    assert sorted([arm, camera, base], key=place_order) == [base, camera, arm]


def test_a_word_that_is_taken_gets_a_number_within_the_length_of_an_address() -> None:
    assert free_word("speed", {"speed", "speed_2"}) == "speed_3"
    long = "a" * 63
    assert free_word(long, {long}) == "a" * 61 + "_2"


def test_a_path_is_said_without_words_twice() -> None:
    assert path_in_words("pose.pose.position.x") == "Pose position x"
