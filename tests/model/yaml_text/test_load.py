"""What a person reads when a description is wrong, and that a right one survives a round trip."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import msgspec
import pytest
from hypothesis import assume, given, strategies as st

from talaia.model.checks.site_checks import check_site, raise_first
from talaia.model.connection import RosSource, VideoSource
from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.site import Device, Ros2Settings, Signal, SignalType, Site
from talaia.model.units.time_zones import known_zones
from talaia.model.yaml_text.load import dump_site, load_site, read_site

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/site.yaml"))
AGV = (Path(__file__).parents[3] / "examples/agv/site.yaml").read_text()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_every_example_is_right_and_survives_a_round_trip(path: Path) -> None:
    site = read_site(path)
    assert check_site(site) == []
    assert load_site(dump_site(site)) == site


MISTAKES = [
    # (what is written, instead of what, the place it is told, a word of the problem, of the remedy)
    (
        "unit: metres in one second of time\n",
        "unit: m/s\n",
        "$.devices.base.signals.speed.unit",
        "at most 24 characters",
        "like m/s",
    ),
    ("feild: range", "field: range", ".signals.ultrasonic1.source.feild", "'feild'", "'field'"),
    ("kind: pwer", "kind: power", "$.devices.power.kind", "'pwer'", "'power'"),
    (
        "minimum: nine",
        "minimum: 9",
        "$.devices.power.signals.voltage.minimum",
        "expected a number, found the text 'nine'",
        "",
    ),
    ("minimum: 14", "minimum: 9", ".voltage.minimum", "not below the maximum", ""),
    ("talaia: 2", "talaia: 1", "$.talaia", "version 2, and this Talaia knows 1", "newer Talaia"),
    ("talaia: two", "talaia: 1", "$.talaia", "found 'two'", "talaia: 1"),
    ("talaia: 0", "talaia: 1", "$.talaia", "never was a format version 0", "talaia: 1"),
    ("Europe/Madird", "Europe/Madrid", "$.zone", "Europe/Madird", "Europe/Madrid"),
    ("max_spede: 0.22", "max_speed: 0.22", "$.devices.base.drive", "max_spede", "max_speed"),
    ("max_turn: -1", "max_turn: 2.84", "$.devices.base.drive.max_turn", "above 0", ""),
    ("max_turn: .nan", "max_turn: 2.84", "$.devices.base.drive.max_turn", "above 0", ""),
    ("max_turn: 1\n      ttl: 2", "max_turn: 2.84", "$.devices.base.drive.ttl", "0.5", "safety"),
    ("max_turn: 1\n      lease: 60", "max_turn: 2.84", "drive.lease", "1 to 10", "safety"),
    ("picture: camera/frnt", "picture: camera/front", "drive.picture", "frnt", "camera/front"),
    ("position: base/speed", "position: base/pose", "drive.position", "base/speed", "base/pose"),
    ("[base/spee, base/turn_rate]", "[base/speed, base/turn_rate]", "confirmed_by[0]", "spee", ""),
    ("topic: odom,", "topic: /odom,", "speed.source.topic", "absolute", "/odom"),
    ("type: nav_msgs/Odometry", "type: nav_msgs/msg/Odometry", "source.type", "ROS type", "msg"),
    ("type: std_srvs/msg/SetBool", "type: std_srvs/srv/SetBool", "wander.type", "a message", "srv"),
    (
        'states: "off"',
        'states: ["off", "on"]',
        "wandering.states",
        "expected a list, found the text 'off'",
        "",
    ),
    ("unit: m", 'states: ["off", "on"]', "wandering", "states", "states"),
    ("type: bolean", "type: boolean", "arguments.active.type", "bolean", "boolean"),
    ("default: 3", "default: true", "arguments.active.default", "expected true or false", ""),
    ("quality: 0", "quality: 70", "streams.front.quality", "1 to 95", ""),
    ("max_rate: 0", "max_rate: 30", "streams.front.max_rate", "above 0", ""),
    ("Power:", "power:", "$.devices.Power", "cannot be a name", "small letter"),
    ("'; rm -rf':", "power:", "$.devices.; rm -rf", "cannot be a name", "small letter"),
    ("name: ''", "name: Battery", "$.devices.power.name", "1 to 100", ""),
    ("field: a..b", "field: range", "source.field", "path of a field", "pose.x"),
    ("ros2: {domain: 400}", "ros2: {}", "$.ros2.domain", "0 to 232", ""),
    ("base:\n    name: A\n  base:", "base:", "line ", "written twice", ""),
    ("ros2: !!python/object:os.system {}", "ros2: {}", "line ", "has no meaning here", ""),
    ("ros2: {", "ros2: {}", "line ", "", ""),
    ("scale: 0", "scale: 100", "power.signals.charge.scale", "other than 0", ""),
    ("unit: V\n        decimals: 12", "unit: V", "voltage.decimals", "0 to 9", ""),
    ("max_rate: -1", "max_rate: 50", "acceleration.max_rate", "0 or more", ""),
    ("unit: V\n        deadband: -1", "unit: V", "voltage.deadband", "0 or more", ""),
    ("unit: V\n        keep: -2", "unit: V", "voltage.keep", "0 or more", ""),
    ("max_age: -1", "max_age: 10", "wandering.max_age", "0 or more", ""),
    ("visibility: pubic", "visibility: public", "$.devices.base.visibility", "pubic", "public"),
    ("frame: wsg84", "frame: wgs84", "fix.frame", "wsg84", "wgs84"),
    (
        "message: geometry_msgs/msg/Twst",
        "message: geometry_msgs/msg/Twist",
        "drive.message",
        "Twst",
        "Twist",
    ),
    ("site: A B", "site: agv", "$.site", "cannot be a name", "small letter"),
    ("max_acceleration: 0", "max_acceleration: 1.0", "drive.max_acceleration", "above 0", ""),
    ("topic: stop it", "topic: /stop", "drive.stop.topic", "absolute", "/stop_it"),
    ("below: -1", "below: 0.02", "drive.stop.below", "above 0", ""),
    ("maximum: .inf", "maximum: 13", "voltage.maximum", "finite", ""),
    ('name: "Bat\\u202Etery"', "name: Battery", "$.devices.power.name", "all be seen", "anew"),
]


@pytest.mark.parametrize(
    ("wrong", "right", "where", "problem", "remedy"), MISTAKES, ids=lambda each: str(each)[:30]
)
def test_a_mistake_is_told_with_its_place_and_the_remedy(
    wrong: str, right: str, where: str, problem: str, remedy: str
) -> None:
    assert right in AGV
    with pytest.raises(DescriptionError) as caught:
        raise_first(load_site(AGV.replace(right, wrong, 1)))
    assert where in caught.value.where
    assert problem in caught.value.problem
    assert remedy in caught.value.remedy


def test_a_file_that_is_not_there_says_so(tmp_path: Path) -> None:
    with pytest.raises(NotReadable, match="there is no such file"):
        read_site(tmp_path / "site.yaml")


def test_a_file_that_is_not_text_says_so(tmp_path: Path) -> None:
    path = tmp_path / "site.yaml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(NotReadable, match="UTF-8"):
        read_site(path)


def test_a_file_that_is_too_long_is_refused_and_not_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "site.yaml"
    with path.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(NotReadable, match="longer than 4 MiB"):
        read_site(path)


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir])
def test_what_is_no_file_is_refused_as_a_description_and_beside_one(make, tmp_path: Path) -> None:
    path = tmp_path / "site.yaml"
    path.write_text(
        "talaia: 1\nsite: a\nname: A\n"
        "connections: {old: {kind: process, file: commands.json}}\ndevices: {}\n"
    )
    make(tmp_path / "commands.json")
    make(tmp_path / "other.yaml")
    for tried in (path, tmp_path / "other.yaml"):
        with pytest.raises(NotReadable, match="is not a file"):
            read_site(tried)


@pytest.mark.parametrize("text", ["", "[]", "3", "just words", "a: &a [*a]", "? {a: 1}\n: 2"])
def test_yaml_that_is_no_description_is_refused_with_a_sentence(text: str) -> None:
    with pytest.raises(DescriptionError):
        load_site(text)


@given(st.text(max_size=300))
def test_any_text_is_a_description_or_a_description_error(text: str) -> None:
    with suppress(DescriptionError):
        load_site(text)


# What `check` refuses would be thrown away: of every letter, six examples of seven.
seen = st.text(
    st.characters(exclude_categories=["Cc", "Cf", "Cs", "Zl", "Zp"]), min_size=1, max_size=40
).filter(str.strip)


@given(
    st.dictionaries(
        st.from_regex(r"[a-z][a-z0-9_]{0,20}", fullmatch=True),
        st.tuples(seen, st.floats(allow_nan=False, allow_infinity=False)),
        max_size=6,
    )
)
def test_what_is_right_and_dumped_is_loaded_back_equal(
    signals: dict[str, tuple[str, float]],
) -> None:
    source = RosSource(topic="/a", type="std_msgs/msg/Float64", field="data")
    site = Site(
        talaia=1,
        site="s",
        name="S",
        ros2=Ros2Settings(),
        devices={
            "d": Device(
                name="D",
                signals={
                    key: Signal(name=name, source=source, minimum=low)
                    for key, (name, low) in signals.items()
                },
            )
        },
    )
    assume(not check_site(site))
    assert load_site(dump_site(site)) == site


@pytest.mark.parametrize("letter", ["\n", "\x85", "\u202e", "\u2028", "\x00"])
def test_a_name_with_letters_that_cannot_be_seen_is_refused(letter: str) -> None:
    site = msgspec.structs.replace(load_site(AGV), name=f"House{letter}vehicle")
    assert [each.where for each in check_site(site)] == ["$.name"]


def test_a_position_has_a_channel_for_each_of_its_numbers() -> None:
    addresses = [each.address for each in load_site(AGV).channels()]
    assert {"base/pose.x", "base/pose.y", "base/pose.yaw"} <= set(addresses)
    assert {"sensors/fix.lat", "sensors/fix.lon", "sensors/fix.alt"} <= set(addresses)
    assert len(addresses) == len(set(addresses))


def test_ten_thousand_signals_are_read_and_checked() -> None:
    source = RosSource(topic="/a", type="std_msgs/msg/Float64", field="data")
    signals = {f"s{each}": Signal(name="S", source=source) for each in range(10_000)}
    site = Site(
        talaia=1, site="s", name="S", ros2=load_site(AGV).ros2,
        devices={"d": Device(name="D", signals=signals)},
    )  # fmt: skip
    again = load_site(dump_site(site))
    assert check_site(again) == []
    assert len(again.channels()) == 10_000


def test_text_has_no_unit_and_no_list_of_states() -> None:
    source = RosSource(topic="/a", type="std_msgs/msg/String", field="data")
    signal = Signal(name="T", source=source, type=SignalType.TEXT, unit="m", states=("a",))
    site = Site(
        talaia=1, site="s", name="S", ros2=load_site(AGV).ros2,
        devices={"d": Device(name="D", signals={"t": signal})},
    )  # fmt: skip
    assert [each.where for each in check_site(site)] == [
        "$.devices.d.signals.t.states",
        "$.devices.d.signals.t.unit",
    ]


GUARDED = """
talaia: 1
site: s
name: S
ros2: {}
devices:
  weather:
    name: Weather
    signals:
      wind: {name: Wind, unit: m/s, source: {topic: /w, type: std_msgs/msg/Float64, field: data}}
      rain:
        name: Rain
        type: state
        states: [dry, raining]
        source: {topic: /r, type: std_msgs/msg/Int8, field: data}
  dome:
    name: Dome
    commands:
      close: {name: Close, target: /close, type: std_srvs/srv/Trigger}
    link_loss: {after: 60, run: [{command: dome/close}]}
  base:
    name: Base
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
interlocks:
  rain:
    name: Rain
    when: [{signal: weather/rain, is: [raining]}, {signal: weather/wind, above: 12}]
    refuse: [dome/*]
    slow: {base/drive: 0.5}
    run: [{command: dome/close, within: 60, required: false}]
"""


WIND = "{signal: weather/wind, above: 12}"
TOGETHER = f"{{all: [{WIND}, {{signal: weather/rain, is_not: [dry]}}, {{link_lost: 9}}]}}"


@pytest.mark.parametrize("text", [GUARDED, GUARDED.replace(WIND, TOGETHER)], ids=["any", "all"])
def test_interlocks_are_read_and_written_back_equal(text: str) -> None:
    site = load_site(text)
    assert check_site(site) == []
    assert load_site(dump_site(site)) == site
    assert site.interlocks["rain"].when[0].is_one_of == ("raining",)
    assert site.safety_signals() == {"weather/rain", "weather/wind"}


@pytest.mark.parametrize(
    ("good", "bad", "where", "word"),
    [
        ("is: [raining]", "is: [rainig]", "$.interlocks.rain.when[0].is[0]", "raining"),
        ("weather/wind, above", "weather/win, above", ".when[1].signal", "weather/wind"),
        ("weather/rain, is: [raining]", "weather/rain, above: 1", ".when[0]", "write is"),
        ("above: 12", "above: .nan", ".when[1].above", "finite"),
        ("refuse: [dome/*]", "refuse: [dome/open]", ".refuse[0]", "dome/close"),
        ("slow: {base/drive", "slow: {base/driv", ".slow.base/driv", "base/drive"),
        ("drive: 0.5", "drive: 1", ".slow.base/drive", "below 1"),
        ("drive: 0.5", "drive: 0", ".slow.base/drive", "refuse it"),
        ("drive: 0.5", "drive: .nan", ".slow.base/drive", "below 1"),
        ("command: dome/close, within", "command: dome/clos, within", ".run[0].command", "close"),
        ("within: 60", "within: 0", ".run[0].within", "above 0"),
        ("required: false", "args: {speed: 1}", ".run[0].args", "speed"),
        ("after: 60", "after: -1", "$.devices.dome.link_loss.after", "0 or more"),
        ("name: Rain\n    when", "name: Rain\n    dwell: 100000.0\n    when", ".dwell", "86400"),
        ("{signal: weather/wind, above: 12}", "{}", ".when[1].signal", "number or state"),
        (
            WIND,
            f"{{all: [{WIND}, {{signal: weather/win}}]}}",
            ".when[1].all[1].signal",
            "weather/wind",
        ),
        (WIND, f"{{all: [{WIND}]}}", ".when[1]", "without all"),
        (WIND, f"{{all: [{WIND}, {WIND}], link_lost: 5}}", ".when[1]", "two conditions"),
        (WIND, f"{{all: [{WIND}, {{all: [{WIND}, {WIND}]}}]}}", ".when[1].all[1]", "outer"),
        (WIND, "{all: []}", ".when[1].signal", "number or state"),
    ],
)
def test_what_does_not_fit_in_an_interlock_is_told_with_its_place(
    good: str, bad: str, where: str, word: str
) -> None:
    assert GUARDED.count(good) >= 1
    findings = check_site(load_site(GUARDED.replace(good, bad, 1)))
    assert len(findings) == 1, findings
    assert where in findings[0].where
    assert word in str(findings[0])


SEVERAL = """
talaia: 1
site: obs
name: Observatory
connections:
  new: {kind: ros2}
  old: {kind: ros1, master: "http://127.0.0.1:11311"}
  far: {kind: rosbridge, url: "ws://robot:9090"}
  sky: {kind: indi}
  shell: {kind: process, prefix: ros2 run}
devices:
  dome:
    name: Dome
    connection: shell
    signals:
      status: {name: Status, type: text, source: {run: dome_servcli client status}}
    commands:
      turn:
        name: Turn
        kind: process
        target: dome_servcli client turn {az}
        arguments: {azimuth: {type: number, field: az, unit: °}}
  mount:
    name: Mount
    connection: sky
    indi: Telescope Simulator
    signals:
      ra: {name: RA, source: {property: EQUATORIAL_EOD_COORD, element: RA}}
    commands:
      park: {name: Park, kind: indi, target: TELESCOPE_PARK, fixed: {PARK: true}}
  rover:
    name: Rover
    connection: old
    signals:
      speed: {name: Speed, source: {topic: /odom, type: nav_msgs/msg/Odometry, field: "a.b[0]"}}
      gain: {name: Gain, source: {parameter: /rover/gain}}
    drive: {topic: /cmd_vel, max_speed: 1, max_turn: 1}
  chip:
    name: Chip
    kind: camera
    connection: old
    frames: {topic: /fits, type: std_msgs/msg/UInt8MultiArray}
"""

OF_CONNECTIONS = [
    ("connection: far", "connection: old", "gain.source.parameter", "no parameters", "topic"),
    ("kind: indie", "kind: indi", "$.connections.sky.kind", "'indie'", "'indi'"),
    ("{kind: indi, prot: 1}", "{kind: indi}", "$.connections.sky.prot", "'prot'", "'port'"),
    ("{port: 7624}", "{kind: indi}", "$.connections.sky", "kind", ""),
    ("{kind: indi, port: 0}", "{kind: indi}", "$.connections.sky.port", "1 to 65535", ""),
    ("ws://me:secret@robot:9090", "ws://robot:9090", "$.connections.far.url", "password", "token"),
    ("http://robot:9090", "ws://robot:9090", "$.connections.far.url", "ws or wss", "ws://"),
    ("ftp://127.0.0.1", "http://127.0.0.1:11311", "$.connections.old.master", "http", "http://"),
    ("kind: ros2, domain: 300", "kind: ros2", "$.connections.new.domain", "0 to 232", ""),
    ("prefix: 'ros2 \"run'", "prefix: ros2 run", "$.connections.shell.prefix", "cut", "quote"),
    ("connection: shel", "connection: shell", "$.devices.dome.connection", "'shel'", "'shell'"),
    ("kind: other", "connection: shell", "$.devices.dome.connection", "several", "far, new, old"),
    ("kind: other", "indi: Telescope Simulator", "$.devices.mount.indi", "missing", "indi:"),
    ("connection: sky", "connection: old", "$.devices.rover.drive", "cannot drive", "ROS"),
    ("topic: /dome", "run: dome_servcli client status", ".source.topic", "knows no topic", "run:"),
    ("run: 'dome \"x'", "run: dome_servcli client status", ".source.run", "cut", "quote"),
    ("property: X", "property: EQUATORIAL_EOD_COORD, element: RA", ".element", "which", "RA"),
    (
        "kind: service\n        target: d",
        "kind: process\n        target: d",
        "turn.kind",
        "not for a connection",
        "process",
    ),
    ("turn --az={az}", "turn {az}", "turn.arguments.azimuth.field", "{az}", "own word"),
    ("turn {az} {alt}", "turn {az}", "turn.target", "{alt}", "argument"),
    ("kind: other", "kind: camera", "$.devices.chip.frames", "only a camera", "kind: camera"),
    ("{topic: fits, ", "{topic: /fits, ", "$.devices.chip.frames.topic", "'fits'", ""),
    ("{topic: /fits, field: data, ", "{topic: /fits, ", "frames.field", "whole message", "out"),
    ("msg/Image", "msg/UInt8MultiArray", "chip.frames.type", "msg/Image", "type: std_msgs/msg/UI"),
    (
        "connection: sky\n    frames",
        "connection: old\n    frames",
        "$.devices.chip.frames",
        "by themselves",
        "out",
    ),
    (
        "connection: far\n    frames",
        "connection: old\n    frames",
        "$.devices.chip.frames",
        "rosbridge gives no FITS",
        "ros2, ros1 or indi",
    ),
    ("parameter: rover", "parameter: /rover/gain", "gain.source.parameter", "'rover'", "/node/"),
]


def test_a_site_of_several_protocols_is_right_and_survives_a_round_trip() -> None:
    site = load_site(SEVERAL)
    assert check_site(site) == []
    assert load_site(dump_site(site)) == site
    assert msgspec.json.decode(msgspec.json.encode(site), type=Site) == site
    assert site.connection_of("mount") == "sky"


@pytest.mark.parametrize("mistake", OF_CONNECTIONS, ids=lambda each: f"{each[0]} for {each[1]}")
def test_a_mistake_about_connections_is_told_with_place_and_remedy(
    mistake: tuple[str, str, str, str, str],
) -> None:
    written, instead, where, problem, remedy = mistake
    assert instead in SEVERAL
    with pytest.raises(DescriptionError) as told:
        raise_first(load_site(SEVERAL.replace(instead, written)))
    assert where in told.value.where
    assert problem in told.value.problem
    assert remedy in told.value.remedy


def test_the_only_connection_need_not_be_named() -> None:
    site = load_site(AGV)
    assert site.connection_of("base") == "ros2"
    assert {*site.links()} == {"ros2"}


def test_the_zones_are_listed_once_for_all_descriptions() -> None:
    known_zones.cache_clear()
    for zone in ("Europe/Madrid", "Asia/Tokyo", "Mars/Olympus"):
        check_site(msgspec.structs.replace(load_site(AGV), zone=zone))
    assert known_zones.cache_info().misses == 1


def test_frames_of_a_ros_camera_that_name_no_topic_are_refused_whatever_their_protocol() -> None:
    site = read_site(next(path for path in EXAMPLES if path.parent.name == "observatory"))
    for source in (RosSource(), VideoSource()):
        camera = msgspec.structs.replace(site.devices["camera"], frames=source)
        devices = {**site.devices, "camera": camera}
        found = check_site(msgspec.structs.replace(site, devices=devices))
        assert "$.devices.camera.frames.topic" in [finding.where for finding in found]
