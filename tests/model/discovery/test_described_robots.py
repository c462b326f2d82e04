"""Robots that nobody here described: what a description makes of each, and that nothing is lost."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from described_robot import found_of, read_robot, robots_in

from talaia.model.checks.site_checks import check_site
from talaia.model.connection import RosSource, source_as
from talaia.model.discovery.generate_description import DescriptionProposal, propose_description
from talaia.model.discovery.probe_report import Found
from talaia.model.discovery.rules.stop_choice import StopAnswers
from talaia.model.site import DeviceKind, Signal, SignalType
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

pytestmark = pytest.mark.pure
CHOSEN = [("chosen", name) for name in robots_in("chosen")]
# Described after the rules were chosen, and nothing was changed for them.
JUDGES = [("judges", name) for name in robots_in("judges")]
TABLE = Path(__file__).parents[3] / "docs" / "robots-table.md"


def described(folder: str, name: str) -> tuple[Found, DescriptionProposal]:
    found = found_of(read_robot(folder, name))
    return found, propose_description(found, "robot", "Robot", "UTC")


def signals_of(made: DescriptionProposal) -> list[Signal]:
    return [one for device in made.site.devices.values() for one in device.signals.values()]


def commands_of(made: DescriptionProposal) -> set[str]:
    return {one.target for device in made.site.devices.values() for one in device.commands.values()}


def drives_of(made: DescriptionProposal) -> list[str]:
    return [device.drive.topic for device in made.site.devices.values() if device.drive]


def silent_omissions(found: Found, made: DescriptionProposal) -> list[str]:
    """Name what is neither in a description nor in what it says it leaves out."""
    said = {line.split(" ", 1)[0].rstrip(":") for line in made.left_out}
    told = "\n".join(made.left_out)
    sources = [source_as(signal.source, RosSource) for signal in signals_of(made)]
    fields = {(source.topic, source.field) for source in sources}
    positions = {
        (source.topic, source.field)
        for source, signal in zip(sources, signals_of(made), strict=True)
        if signal.type is SignalType.POSITION
    }
    pictures = {
        source_as(stream.source, RosSource).topic
        for device in made.site.devices.values()
        for stream in device.streams.values()
    }
    commands, drives = commands_of(made), set(drives_of(made))
    lost: list[str] = []
    for topic in found.topics:
        name = topic.topic
        whole = rf"^{re.escape(name)}: "
        if name in pictures | drives or re.search(whole, told, re.MULTILINE) or topic.names:
            continue
        if not topic.publishers:
            lost += [] if name in commands else [name]
            continue
        for field in topic.fields:
            inside = any(
                at == name and (not base or field.path.startswith(f"{base}."))
                for at, base in positions
            )
            above = re.split(r"[.[][^.[]*$", field.path)[0]
            words = rf"^{re.escape(name)} .*(?<![\w.]){re.escape(field.path)}(?![\w.\[])"
            parent = rf"^{re.escape(name)} .*\b{re.escape(above)}: an or"
            if (name, field.path) in fields or inside:
                continue
            if not re.search(words, told, re.MULTILINE) and not re.search(
                parent, told, re.MULTILINE
            ):
                lost.append(f"{name} {field.path}")
    asked = [one.service for one in found.services] + [one.action for one in found.actions]
    lost += [name for name in asked if name not in commands and name not in said]
    parameters = {source.parameter for source in sources}
    for node in found.nodes:
        for one in node.parameters:
            if f"{node.node}/{one.parameter}" not in parameters:
                lost.append(f"{node.node} {one.parameter}")
        lost += [one for one in node.left_out if one not in told]
    return lost


@pytest.mark.parametrize(("folder", "name"), [*CHOSEN, *JUDGES])
def test_a_robots_description_passes_the_check_and_reads_back(folder: str, name: str) -> None:
    _, made = described(folder, name)
    assert check_site(made.site) == []
    assert load_site(write_description(made.site, made.left_out)) == made.site


@pytest.mark.parametrize(("folder", "name"), [*CHOSEN, *JUDGES])
def test_nothing_of_a_robot_is_left_out_in_silence(folder: str, name: str) -> None:
    found, made = described(folder, name)
    assert silent_omissions(found, made) == []


def test_what_is_lost_is_counted_where_a_line_is_missing() -> None:
    found, made = described("chosen", "turtlebot4")
    short = made._replace(left_out=())
    lost = silent_omissions(found, short)
    assert "/scan range_min" in lost
    assert "/imu orientation.x" in lost


@pytest.mark.parametrize(("folder", "name"), [*CHOSEN, *JUDGES])
def test_no_signal_is_a_quaternion_a_name_a_scan_or_a_hidden_topic(folder: str, name: str) -> None:
    _, made = described(folder, name)
    for signal in signals_of(made):
        source = source_as(signal.source, RosSource)
        quaternion = re.search(r"orientation\.[xyzw]\Z", source.field)
        assert not quaternion or signal.type is SignalType.POSITION
        assert not source.field.startswith(("name[", "layout.", "header."))
        assert "/_" not in source.topic
        assert source.type not in (
            "sensor_msgs/msg/CameraInfo",
            "sensor_msgs/msg/LaserScan",
            "sensor_msgs/msg/PointCloud2",
        )
        assert not source.topic.endswith(("cmd_vel", "robot_description"))


def test_joints_have_units_of_their_kind_and_the_ends_of_the_model() -> None:
    _, made = described("chosen", "two_arms")
    joints = made.site.devices["joints"].signals
    assert len(joints) == 3 * 19 + 1
    lift, pan = joints["torso_lift_position"], joints["head_pan_position"]
    assert (lift.unit, lift.minimum, lift.maximum) == ("m", 0.0, 0.4)
    assert (pan.unit, pan.minimum, pan.maximum) == ("rad", -2.9, 2.9)
    assert (joints["torso_lift_effort"].unit, joints["head_pan_effort"].unit) == ("N", "N·m")


def test_names_are_plain_and_no_two_signals_of_a_device_have_one() -> None:
    # All of it is in the namespace of the robot, whose name stands above all of its devices.
    _, made = described("chosen", "husky")
    names = [device.name for device in made.site.devices.values()]
    assert "Vehicle base" in names
    assert not [name for name in names if name.startswith("A 200")]
    assert len(set(names)) == len(names)
    speeds = made.site.devices["a_200_0001_base"].signals
    assert speeds["platform_speed"].name == "Platform speed (odom)"
    assert speeds["platform_speed_2"].name == "Platform speed (filtered)"


@pytest.mark.parametrize(("folder", "name"), [*CHOSEN, *JUDGES])
def test_nothing_of_a_robot_is_called_as_something_else_beside_it(folder: str, name: str) -> None:
    _, made = described(folder, name)
    devices = [device.name for device in made.site.devices.values()]
    assert len(set(devices)) == len(devices)
    for device in made.site.devices.values():
        for part in (device.signals, device.streams, device.commands):
            names = [one.name for one in part.values()]
            assert sorted(set(names)) == sorted(names), device.name


def test_what_stops_a_robot_has_no_second_button_that_lets_go_of_it() -> None:
    found = found_of(read_robot("chosen", "two_arms"))
    answers = StopAnswers(topic="/emergency_stop")
    made = propose_description(found, "duo", "Duo", "UTC", answers=answers)
    assert "/emergency_stop" not in commands_of(made)
    assert any(line.startswith("/emergency_stop: STOP of Vehicle base") for line in made.left_out)
    assert silent_omissions(found, made) == []
    # Nobody said that it is STOP.
    assert "/emergency_stop" in commands_of(propose_description(found, "duo", "Duo", "UTC"))


def test_two_arms_are_told_apart_by_their_buttons() -> None:
    _, made = described("chosen", "two_arms")
    jogs = {word: one.name for word, one in made.site.devices["joints"].commands.items()}
    assert (jogs["jog_left"], jogs["jog_right"]) == ("Jog left", "Jog right")
    _, made = described("chosen", "mobile_manipulator")
    names = {one.name for one in made.site.devices["joints"].commands.values()}
    assert "Move arm torso to home (torso controller)" in names


def test_a_robots_own_parts_are_no_second_vehicle() -> None:
    _, made = described("chosen", "husky")
    vehicles = [one for one in made.site.devices.values() if one.kind is DeviceKind.VEHICLE]
    (base,) = vehicles
    assert base.drive is not None
    assert base.signals["emergency_stop"].name == "Emergency stop"
    # What drives is in a namespace, its odometry in none: its commands are on its page.
    _, made = described("judges", "stretch")
    (base,) = [one for one in made.site.devices.values() if one.kind is DeviceKind.VEHICLE]
    assert base.drive is not None
    assert "Stow the robot" in {one.name for one in base.commands.values()}


def test_what_flies_is_not_driven_and_says_why() -> None:
    for name in ("mavros", "crazyflie", "px4"):
        found, made = described("chosen", name)
        assert drives_of(made) == [], name
        twists = [one.topic for one in found.topics if "Twist" in one.type and one.subscribers]
        for topic in twists:
            assert any(
                line.startswith(f"{topic}: by its other topics the robot flies")
                for line in made.left_out
            )


def test_what_flies_is_known_where_its_own_packages_are_not() -> None:
    # As a laptop without them sees it: only what is of common types.
    found, _ = described("chosen", "mavros")
    common = tuple(one for one in found.topics if "mavros_msgs" not in one.type)
    bare = msgspec.structs.replace(found, topics=common, services=(), actions=())
    made = propose_description(bare, "robot", "Robot", "UTC")
    assert drives_of(made) == []
    # A boat's or a rover's autopilot, by another namespace: its attitude is no driving either.
    renamed = tuple(
        msgspec.structs.replace(one, topic=one.topic.replace("/mavros/", "/boat/"))
        for one in common
    )
    made = propose_description(
        msgspec.structs.replace(bare, topics=renamed), "robot", "Robot", "UTC"
    )
    assert drives_of(made) == ["/boat/setpoint_velocity/cmd_vel"]
    told = "/boat/setpoint_attitude/cmd_vel: by its name how it rolls"
    assert any(line.startswith(told) for line in made.left_out)


@pytest.mark.parametrize(
    ("name", "topic"),
    [
        ("turtlebot4", "/cmd_vel"),
        ("husky", "/a200_0001/cmd_vel"),
        ("jackal", "/cmd_vel"),
        ("nav2", "/cmd_vel"),
        ("usv", "/wamv/command/twist"),
        ("rover", "/commands/velocity"),
        ("two_arms", "/base/cmd_vel"),
        ("racer", "/drive"),
        ("mecanum", "/cmd_vel"),
        ("ur5e", "/servo_node/delta_joint_cmds"),
        ("kobuki", "/commands/velocity"),
        ("mower", "/cmd_vel"),
        ("panther", "/panther/cmd_vel"),
        # Not the multiplexer's own output, which the robot's programs publish.
        ("street_car", "/vesc/low_level/ackermann_cmd_mux/input/teleop"),
    ],
)
def test_a_robot_is_driven_by_one_topic_and_its_stop_is_not_assumed(name: str, topic: str) -> None:
    _, made = described("chosen", name)
    assert drives_of(made) == [topic]
    (drive,) = [device.drive for device in made.site.devices.values() if device.drive]
    assert (drive.stop.topic, drive.stop.confirmed_by) == ("", ())


def test_a_multiplexer_is_driven_by_its_input_for_people_on_the_page_of_the_odometry() -> None:
    for name, topic, device in (
        ("mobile_manipulator", "/key_vel", "base"),
        ("street_car", "/vesc/low_level/ackermann_cmd_mux/input/teleop", "vesc_base"),
        ("kobuki", "/commands/velocity", "base"),
    ):
        _, made = described("chosen", name)
        drive = made.site.devices[device].drive
        assert drive is not None
        assert drive.topic == topic
        # What may confirm STOP stands beside it.
        assert {f"{device}/speed", f"{device}/turn_rate"} <= set(made.stops[0].signals)


@pytest.mark.parametrize(
    ("name", "topic"),
    [
        ("girona", "/girona500/controller/body_velocity_req"),
        ("street_car", "/vesc/commands/motor/speed"),
        ("usv", "/wamv/thrusters/left/thrust"),
        ("crazyflie", "/cf1/cmd_full_state"),
    ],
)
def test_what_moves_until_another_value_comes_is_no_form(name: str, topic: str) -> None:
    _, made = described("chosen", name)
    assert topic not in commands_of(made)
    assert any(
        line.startswith(f"{topic}: it moves something until another") for line in made.left_out
    )


def test_parts_with_names_of_their_own_are_called_by_them() -> None:
    _, made = described("chosen", "panther")
    shown = {one.name: one.unit for one in made.site.devices["panther_hardware"].signals.values()}
    assert shown["Front voltage"] == "V"
    assert shown["Rear heatsink temperature"] == "°C"
    assert not any("driver states 0" in name for name in shown)
    battery = made.site.devices["panther_battery"]
    # What the charge stands in, and all else that is below that name.
    assert (battery.name, battery.kind) == ("Battery", DeviceKind.POWER)
    assert {"charge_level", "charging_status_current"} <= set(battery.signals)


def test_whole_numbers_have_the_unit_of_a_topics_name_and_none_that_is_guessed() -> None:
    _, made = described("chosen", "mower")
    assert made.site.devices["isobus_implement"].signals["rear_pto_speed"].unit == "rpm"
    _, made = described("chosen", "kobuki")
    # A byte of a board's own scale: nobody knows how many amperes.
    assert made.site.devices["sensors"].signals["core_current_0"].unit == ""


def test_an_arm_has_a_jog_and_its_named_poses() -> None:
    _, made = described("chosen", "ur5e")
    commands = {
        word: one for device in made.site.devices.values() for word, one in device.commands.items()
    }
    jog = commands["jog"]
    assert jog.target == "/servo_node/delta_twist_cmds"
    assert max(one.maximum or 0.0 for one in jog.arguments.values()) <= 0.2
    home = commands["to_ur_manipulator_home"]
    assert home.fixed["trajectory.joint_names[1]"] == "shoulder_lift_joint"
    assert home.fixed["trajectory.points[0].positions[1]"] == -1.57
    assert home.confirm


def test_an_arms_joints_are_driven_between_their_ends_by_where_they_stand() -> None:
    _, made = described("chosen", "ur5e")
    device = made.site.devices["joints"]
    assert device.drive is not None
    elbow = device.drive.joints["elbow_joint"]
    assert (elbow.name, elbow.max_speed, elbow.minimum, elbow.maximum) == (
        "Elbow",
        0.1,
        -3.142,
        3.142,
    )
    assert made.site.signal(elbow.position) == device.signals["elbow_position"]
    # Beside them, on the same page, their named poses and the tool's steps.
    assert {"jog", "to_ur_manipulator_home"} <= set(device.commands)
    (choice,) = made.stops
    assert all(address.endswith("velocity") for address in choice.signals)


def test_what_steers_is_driven_by_an_angle_and_a_twist_alone_goes_nowhere_sideways() -> None:
    drives = {
        name: device.drive
        for name in ("racer", "mecanum", "turtlebot4")
        for device in described("chosen", name)[1].site.devices.values()
        if device.drive
    }
    assert (drives["racer"].max_steering, drives["racer"].max_turn) == (0.3, 0.0)
    assert drives["mecanum"].max_sideways == 0.2
    assert drives["turtlebot4"].max_sideways == 0.0


def test_a_share_and_a_percentage_are_both_shown_in_percent() -> None:
    shown = {}
    for name in ("turtlebot3", "turtlebot4"):
        _, made = described("chosen", name)
        shown[name] = made.site.devices["power"].signals["charge_level"]
    # 82.5 of a driver that says percent, and 0.83 of one that keeps to the definition.
    assert (shown["turtlebot3"].unit, shown["turtlebot3"].scale) == ("%", 1.0)
    assert (shown["turtlebot4"].unit, shown["turtlebot4"].scale) == ("%", 100.0)


def test_names_are_those_that_people_use_and_units_come_from_names() -> None:
    _, made = described("chosen", "rover")
    shown = {
        source_as(one.source, RosSource).topic + " " + source_as(one.source, RosSource).field: (
            one.name,
            one.unit,
        )
        for one in signals_of(made)
    }
    assert shown["/co2_ppm data"] == ("CO₂", "ppm")
    assert shown["/env temp_c"] == ("Env temperature", "°C")
    assert shown["/env pressure_bar"] == ("Env pressure", "bar")
    assert shown["/env motor_rpm"] == ("Env motor speed", "rpm")
    assert shown["/odom twist.twist.linear.y"] == ("Sideways speed", "m/s")


def test_scans_maps_diagnostics_and_logs_stand_on_a_board() -> None:
    _, made = described("chosen", "turtlebot4")
    tiles = {tile.type: tile.settings for tile in made.site.boards["robot"].tiles}
    assert set(tiles) == {"scene", "cameras", "diagnostics", "parameters", "log"}
    assert tiles["diagnostics"] == {"topic": "/diagnostics"}


def row_of(folder: str, name: str) -> str:
    found, made = described(folder, name)
    numbers = [one for one in signals_of(made) if one.type is SignalType.NUMBER]
    # Of readings alone: parameters have no unit, and delays of stamps are always in seconds.
    sources = [(one, source_as(one.source, RosSource)) for one in numbers]
    measured = [one for one, source in sources if not source.parameter and not source.delay]
    share = 100 * sum(bool(one.unit) for one in measured) / len(measured)
    cells = (
        read_robot(folder, name).name,
        len(found.topics),
        len(signals_of(made)),
        f"{share:.0f} %",
        sum(len(device.commands) for device in made.site.devices.values()),
        ", ".join(f"`{one}`" for one in drives_of(made)) or "—",
        len(made.left_out),
        len(silent_omissions(found, made)),
    )
    return f"| {' | '.join(map(str, cells))} |"


@pytest.mark.parametrize(("folder", "name"), [*CHOSEN, *JUDGES])
def test_the_table_in_the_docs_says_what_is_so(folder: str, name: str) -> None:
    assert row_of(folder, name) in TABLE.read_text()
