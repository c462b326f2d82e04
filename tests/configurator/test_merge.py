"""What a probe found comes into the open description, once, and beside what a person wrote."""

from __future__ import annotations

import msgspec

from talaia.configurator import edits
from talaia.configurator.description_paths import with_value
from talaia.configurator.merge import merge_findings
from talaia.configurator.presets import SENSORS
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.probe_report import FieldFound, Found, ServiceFound, TopicFound
from talaia.model.discovery.rules.stop_choice import StopAnswers

DATA = (FieldFound("data", "number"),)
FOUND = Found(
    1,
    "ros2",
    "ROS 2, domain 7",
    5.0,
    domain=7,
    topics=(
        TopicFound("/metric", "std_msgs/msg/String", 1, rate=10, names=("speed1", "light2")),
        TopicFound("/rover/odom", "nav_msgs/msg/Odometry", 1, rate=20, fields=(
            FieldFound("twist.twist.linear.x", "number", "m/s"),
        )),
        TopicFound("/images", "sensor_msgs/msg/Image", 1, rate=15),
        TopicFound("/cmd_vel", "geometry_msgs/msg/Twist", 0, 1),
        TopicFound("/odd", "odd_msgs/msg/Odd", 1, problem="the type is not known here"),
    ),
    services=(ServiceFound("/rover/home", "std_srvs/srv/Trigger"),),
)  # fmt: skip
EMPTY = edits.new_site("robot", "Robot", "UTC")


def test_everything_found_fills_a_new_description_that_then_runs() -> None:
    result = merge_findings(EMPTY, FOUND)
    assert check_site(result.site) == []
    assert result.site.ros2 is not None
    assert result.site.ros2.domain == 7
    assert (result.count("signals"), result.count("streams"), result.count("commands")) == (4, 1, 1)
    assert edits.driven_devices(result.site)
    assert result.known == 0
    assert any("/odd" in each for each in result.left_out)


def test_finding_the_same_again_changes_nothing() -> None:
    once = merge_findings(EMPTY, FOUND)
    again = merge_findings(once.site, FOUND)
    assert again.site == once.site
    assert again.added == ()
    assert again.known == 6


def test_what_a_person_named_and_moved_stays_as_it_is() -> None:
    site = edits.with_sensor(EMPTY, edits.NewSensor(SENSORS[8], 1))
    path = ("devices", "sensors", "signals", "speed1")
    site = with_value(site, (*path, "name"), "Speed over ground")
    result = merge_findings(site, FOUND)
    assert result.site.devices["sensors"].signals["speed1"].name == "Speed over ground"
    metric = [
        signal.source.name
        for device in result.site.devices.values()
        for signal in device.signals.values()
        if signal.source.topic == "/metric"
    ]
    assert sorted(metric) == ["light2", "speed1"]
    assert check_site(result.site) == []


def test_a_device_of_that_name_at_another_protocol_is_left_alone() -> None:
    found = msgspec.structs.replace(FOUND, domain=None)
    mixed = msgspec.convert(
        {
            "talaia": 1, "site": "a", "name": "A",
            "connections": {"robot": {"kind": "ros2"}, "mount": {"kind": "indi"}},
            "devices": {"camera": {"name": "CCD", "connection": "mount", "indi": "CCD"}},
        },
        type(EMPTY),
    )  # fmt: skip
    result = merge_findings(mixed, found)
    assert result.site.devices["camera"] == mixed.devices["camera"]
    assert result.site.devices["camera_2"].connection == "robot"
    assert check_site(result.site) == []


def test_a_sensor_that_was_found_is_not_added_a_second_time_by_its_number() -> None:
    site = merge_findings(EMPTY, FOUND).site
    speed = next(each for each in SENSORS if each.word == "speed")
    assert edits.free_number(site, speed) == 2


def test_what_stop_goes_by_is_asked_of_what_is_newly_driven_and_is_what_was_said() -> None:
    asked = msgspec.structs.replace(
        FOUND, topics=(*FOUND.topics, TopicFound("/e_stop", "std_msgs/msg/Bool", 0, 1))
    )
    first = merge_findings(EMPTY, asked)
    (choice,) = first.stops
    assert choice.topics == ("/e_stop",)
    drive = first.site.devices[choice.device].drive
    assert drive is not None
    assert drive.stop.topic == ""
    said = merge_findings(EMPTY, asked, StopAnswers("/e_stop", choice.signals))
    drive = said.site.devices[choice.device].drive
    assert drive is not None
    assert (drive.stop.topic, bool(drive.stop.confirmed_by)) == ("/e_stop", bool(choice.signals))
    # What is driven already is not asked about again.
    assert merge_findings(said.site, asked).stops == ()
