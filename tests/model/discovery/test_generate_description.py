"""From what a probe found to a description: it runs as it is, whatever the robot calls things."""

from __future__ import annotations

import msgspec
from hypothesis import given, settings, strategies as st
from many_examples import examples

from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import (
    ActionFound,
    FieldFound,
    Found,
    ServiceFound,
    TopicFound,
)
from talaia.model.discovery.proposed_signals import MAX_PRIMARY
from talaia.model.discovery.ros_units import (
    readable_name,
    unit_in_comment,
    unit_in_name,
    unit_said,
    word_of,
)
from talaia.model.discovery.rules.stop_choice import StopAnswers, StopChoice
from talaia.model.site import Signal, SignalType
from talaia.model.topics import TopicRight
from talaia.model.units.unit import UNITS
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.write import write_description

ODOMETRY = TopicFound(
    topic="/odom",
    type="nav_msgs/msg/Odometry",
    publishers=1,
    rate=50.0,
    fields=tuple(
        FieldFound(path, "number", unit)
        for path, unit in (
            ("pose.pose.position.x", "m"),
            ("pose.pose.position.y", "m"),
            ("pose.pose.position.z", "m"),
            ("twist.twist.linear.x", "m/s"),
            ("twist.twist.angular.z", "rad/s"),
        )
    ),
)
CMD_VEL = TopicFound(topic="/cmd_vel", type="geometry_msgs/msg/Twist", subscribers=1)
STOP = TopicFound(topic="/e_stop", type="std_msgs/msg/Bool", subscribers=1)
IMAGE = TopicFound(
    topic="/front/image_raw/compressed", type="sensor_msgs/msg/CompressedImage", publishers=1
)


def found(*topics: TopicFound, **more: object) -> Found:
    base = Found(talaia_probe=1, protocol="ros2", where="here", seconds=1.0, domain=0)
    return msgspec.structs.replace(base, topics=topics, **more)


def test_of_stamped_topics_the_arrival_is_kept_beside_the_stamp() -> None:
    imu = TopicFound(
        topic="/imu",
        type="sensor_msgs/msg/Imu",
        publishers=1,
        rate=100.0,
        stamped=True,
        fields=(FieldFound("angular_velocity.z", "number", "rad/s"),),
    )
    latched = msgspec.structs.replace(imu, topic="/kept", latched=True)
    plain = msgspec.structs.replace(imu, topic="/plain", stamped=False)
    # Of a topic without a signal nobody asks when it came.
    empty = msgspec.structs.replace(imu, topic="/empty", fields=())
    site = propose_description(found(imu, latched, plain, empty), "robot", "Robot", "UTC").site
    assert not check_site(site)
    signals = {
        word: each for device in site.devices.values() for word, each in device.signals.items()
    }
    delays = {word: each for word, each in signals.items() if each.source.delay}
    assert {word: each.source.topic for word, each in delays.items()} == {"imu_delay": "/imu"}
    delay = delays["imu_delay"]
    # No tile of the first page, and a sample only when it changes, or twice an hour.
    assert (delay.unit, delay.primary, delay.deadband, delay.max_age) == ("s", False, 0.02, 3600)


def test_transforms_scans_maps_paths_clouds_and_diagnostics_are_open_to_those_who_view() -> None:
    kinds = ("nav_msgs/msg/Path", "sensor_msgs/msg/LaserScan", "std_msgs/msg/String")
    topics = [TopicFound(topic=f"/t{n}", type=kind) for n, kind in enumerate(kinds)]
    site = propose_description(found(*topics), "robot", "Robot", "UTC").site
    patterns = [rule.pattern for rule in site.topics]
    assert patterns == ["/tf", "/tf_static", "/diagnostics", "/robot_description", "/t0", "/t1"]
    assert {rule.right for rule in site.topics} == {TopicRight.VIEW}
    assert load_site(write_description(site)) == site
    older = propose_description(found(*topics, protocol="ros1"), "robot", "Robot", "UTC").site
    assert older.topics == site.topics
    other = propose_description(found(*topics, protocol="mqtt"), "robot", "Robot", "UTC").site
    assert other.topics == ()


def signals(*topics: TopicFound) -> dict[str, Signal]:
    site = propose_description(found(*topics), "robot", "Robot", "UTC").site
    return {
        f"{device}/{word}": signal
        for device, each in site.devices.items()
        for word, signal in each.signals.items()
    }


names = st.text(max_size=30)
parts = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,20}", fullmatch=True)
topic_names = st.lists(parts, min_size=1, max_size=4).map(lambda each: "/" + "/".join(each))
types = st.sampled_from(
    [
        "std_msgs/msg/String",
        "std_msgs/msg/Float64",
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/BatteryState",
        "sensor_msgs/msg/NavSatFix",
        "nav_msgs/msg/Odometry",
        "geometry_msgs/msg/Twist",
        "geometry_msgs/msg/PoseStamped",
        "own_msgs/msg/Thing",
    ]
)
fields = st.builds(
    FieldFound,
    path=st.lists(parts.filter(lambda each: each[0] != "_"), min_size=1, max_size=3).map(".".join),
    type=st.sampled_from(["number", "integer", "boolean", "text"]),
    unit=st.sampled_from(sorted(UNITS)),
    scale=st.sampled_from([1.0, 100.0]),
    name=names,
    empty=st.booleans(),
).map(lambda each: msgspec.structs.replace(each, unit="" if each.type == "text" else each.unit))
topics = st.builds(
    TopicFound,
    topic=topic_names,
    type=types,
    publishers=st.integers(0, 2),
    subscribers=st.integers(0, 2),
    rate=st.floats(0, 1000),
    fields=st.lists(fields, max_size=6).map(tuple),
    names=st.lists(names.filter(str.strip), max_size=3).map(tuple),
    left_out=st.lists(names, max_size=2).map(tuple),
)
asked = st.tuples(topic_names, st.lists(fields, max_size=4).map(tuple))


@settings(deadline=None, max_examples=examples(15, many=600))
@given(
    st.lists(topics, max_size=12, unique_by=lambda each: each.topic),
    st.lists(asked, max_size=3),
    st.lists(asked, max_size=2),
)
def test_whatever_was_found_the_description_is_right_and_reads_back_as_written(
    published: list[TopicFound], services: list[tuple], actions: list[tuple]
) -> None:
    made = propose_description(
        found(
            *published,
            services=tuple(ServiceFound(name, "own_msgs/srv/Do", of) for name, of in services),
            actions=tuple(ActionFound(name, "own_msgs/action/Go", of) for name, of in actions),
        ),
        "robot",
        "Robot",
        "UTC",
    )
    if made.site.devices:
        assert check_site(made.site) == []
    read = load_site(write_description(made.site, made.left_out))
    assert msgspec.to_builtins(read) == msgspec.to_builtins(made.site)


def test_a_robot_that_listens_to_velocities_can_be_driven_carefully() -> None:
    site = propose_description(found(ODOMETRY, CMD_VEL, STOP, IMAGE), "robot", "Robot", "UTC").site
    drive = site.devices["base"].drive
    assert drive is not None
    assert drive.topic == "/cmd_vel"
    assert drive.max_speed <= 0.2
    assert drive.picture == "front_camera/front" or drive.picture.endswith("/front")
    assert drive.position == "base/pose"


def test_what_stop_goes_by_is_asked_and_an_answer_beside_the_choices_is_none() -> None:
    robot = found(ODOMETRY, CMD_VEL, STOP, IMAGE)
    made = propose_description(robot, "robot", "Robot", "UTC")
    assert made.stops == (StopChoice("base", ("/e_stop",), ("base/speed", "base/turn_rate")),)
    unsaid = made.site.devices["base"].drive
    assert (unsaid.stop.topic, unsaid.stop.confirmed_by) == ("", ())
    answers = StopAnswers("/e_stop", ("base/speed", "base/elsewhere"))
    site = propose_description(robot, "robot", "Robot", "UTC", answers=answers).site
    said = site.devices["base"].drive
    assert (said.stop.topic, said.stop.confirmed_by) == ("/e_stop", ("base/speed",))
    assert check_site(site) == []
    wrong = propose_description(robot, "robot", "Robot", "UTC", answers=StopAnswers("/horn"))
    assert wrong.site.devices["base"].drive.stop.topic == ""


def test_a_position_is_one_signal_and_its_height_another_where_there_is_one() -> None:
    drone = TopicFound(topic="/takeoff", type="std_msgs/msg/Empty", subscribers=1)
    assert not any("position.z" in each.source.field for each in signals(ODOMETRY).values())
    made = signals(ODOMETRY, drone)
    assert made["base/pose"].type is SignalType.POSITION
    heights = [each for each in made.values() if each.source.field == "pose.pose.position.z"]
    assert [each.unit for each in heights] == ["m"]
    assert not any(each.source.field == "pose.pose.position.x" for each in made.values())


def test_each_name_on_cloudconnects_metric_is_a_signal() -> None:
    metric = TopicFound(
        topic="/metric",
        type="std_msgs/msg/String",
        publishers=1,
        fields=(FieldFound("data", "text"),),
        names=("speed1", "ultrasonic2"),
    )
    made = signals(metric)
    assert {each.source.name for each in made.values()} == {"speed1", "ultrasonic2"}
    assert {each.name for each in made.values()} == {"Speed 1", "Ultrasonic 2"}


def test_a_robot_that_listens_to_cloudconnects_keys_is_driven_by_them() -> None:
    control = TopicFound(topic="/control", type="std_msgs/msg/String", subscribers=1)
    site = propose_description(found(ODOMETRY, control), "robot", "Robot", "UTC").site
    drive = site.devices["base"].drive
    assert drive is not None
    assert drive.message == "std_msgs/msg/String"


def test_at_most_a_dozen_are_on_the_first_page_and_the_telling_ones_come_first() -> None:
    many = TopicFound(
        topic="/plc",
        type="own_msgs/msg/Plc",
        publishers=1,
        fields=tuple(FieldFound(f"value{index}", "number") for index in range(40)),
    )
    battery = TopicFound(
        topic="/battery",
        type="sensor_msgs/msg/BatteryState",
        publishers=1,
        fields=(
            FieldFound("percentage", "number", "%", 100.0),
            FieldFound("temperature", "number", "°C", empty=True),
        ),
    )
    made = signals(many, battery)
    first = [address for address, each in made.items() if each.primary]
    assert len(first) == MAX_PRIMARY
    assert "power/charge_level" in first
    assert "power/temperature" not in first
    assert made["power/charge_level"].scale == 100.0


def test_a_name_with_a_line_end_stays_a_comment_and_a_value() -> None:
    evil = TopicFound(
        topic="/evil",
        type="own_msgs/msg/Evil",
        publishers=1,
        fields=(FieldFound("a", "number", name="x\ninterlocks: {}\n"),),
        left_out=("b\ntalaia: 2",),
    )
    made = propose_description(found(evil), "robot", "Robot", "UTC")
    text = write_description(made.site, made.left_out)
    assert load_site(text) == made.site
    assert "\ntalaia: 2" not in text


def test_units_are_read_from_names_and_comments() -> None:
    assert unit_in_name("wheel_speed_mps").unit == "m/s"
    assert unit_in_name("motorTemperature").unit == "°C"
    assert unit_in_name("m") is None
    assert unit_in_name("mode") is None
    assert unit_in_name("timeout_s").unit == "s"
    # A share is told as a part of one, too, but not in whole numbers.
    assert unit_in_name("percent", whole=True).unit == "%"
    assert unit_in_name("percent") is None
    assert unit_said("cmd_vel_timeout_sec").unit == "s"
    assert unit_said("full_voltage") is None
    assert unit_in_comment("speed over ground [m/s]").unit == "m/s"
    assert unit_in_comment("Temperature in Degrees Celsius").unit == "°C"
    assert unit_in_comment("as in the manual (see there)") is None


@given(st.text())
def test_any_text_becomes_a_word_of_an_address_and_a_name(text: str) -> None:
    word = word_of(text)
    assert word.isascii()
    assert word[0].isalpha()
    assert word == word.lower()
    assert len(word) <= 63
    assert "\n" not in readable_name(text)


def test_an_altitude_in_the_sky_is_no_height_in_metres() -> None:
    numbers = [
        TopicFound(
            topic=topic,
            type="std_msgs/msg/Float64",
            publishers=1,
            fields=(FieldFound(path="data", type="number"),),
        )
        for topic in ("/mast/altitude", "/mast/azimuth", "/sky/sun_altitude", "/drone/altitude")
    ]
    site = propose_description(found(*numbers), "robot", "Robot", "UTC").site
    assert site.devices["mast"].signals["altitude"].unit == ""
    assert site.devices["sky"].signals["sun_altitude"].unit == ""
    assert site.devices["drone"].signals["altitude"].unit == "m"
