"""What a signal of a topic is called: by what a person would say of it. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.discovery.ros_units import readable_name, without_unit
from talaia.model.discovery.topic_words import last_part, path_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.discovery.probe_report import FieldFound, TopicFound

__all__ = ["FORM_PARTS", "JOINTS", "joint_title", "name_of_field", "plain_name"]

JOINTS = "sensor_msgs/msg/JointState"
_TWIST = {
    "linear.x": "Speed",
    "linear.y": "Sideways speed",
    "linear.z": "Climb rate",
    "angular.x": "Roll rate",
    "angular.y": "Pitch rate",
    "angular.z": "Turn rate",
}
_IMU = {
    "linear_acceleration.x": "Forward acceleration",
    "linear_acceleration.y": "Sideways acceleration",
    "linear_acceleration.z": "Upward acceleration",
    "angular_velocity.x": "Roll rate",
    "angular_velocity.y": "Pitch rate",
    "angular_velocity.z": "Turn rate",
}
# Names that people use, where a path in words would puzzle them.
_NAMES: dict[str, dict[str, str]] = {
    "nav_msgs/msg/Odometry": {
        **{f"twist.twist.{path}": name for path, name in _TWIST.items()},
        "pose.pose.position.z": "Height",
    },
    "geometry_msgs/msg/Twist": _TWIST,
    "geometry_msgs/msg/TwistStamped": {f"twist.{path}": name for path, name in _TWIST.items()},
    "geometry_msgs/msg/TwistWithCovarianceStamped": {
        f"twist.twist.{path}": name for path, name in _TWIST.items()
    },
    "sensor_msgs/msg/Imu": _IMU,
    "sensor_msgs/msg/BatteryState": {"percentage": "Charge level"},
    "geometry_msgs/msg/PoseStamped": {"pose.position.z": "Height"},
    "geometry_msgs/msg/PoseWithCovarianceStamped": {"pose.pose.position.z": "Height"},
    "sensor_msgs/msg/NavSatFix": {"status.status": "Fix status"},
    "sensor_msgs/msg/Range": {"range": "Distance"},
}
_ODOMETRY = "nav_msgs/msg/Odometry"
_TWISTS = tuple(name for name in _NAMES if "/Twist" in name)
# Of what is one of a robot, its topic's name says no more: `/odom`, `/imu/data`.
_NO_NAME = {"odom", "odometry", "data", "data_raw", "state", "status", "filtered", "out", "raw"}
# These say it of a single number or text, too, whose `state` is what it is.
FORM_PARTS = ("data", "data_raw", "raw", "out")
# Names that drivers give, and what people say.
_SPOKEN = {
    "odom": "Odometry",
    "imu": "IMU",
    "gps": "GPS",
    "fix": "Position",
    "mag": "Magnetic field",
    "hdg": "Heading",
    "compass hdg": "Compass heading",
    "rel alt": "Height above start",
    "vfr hud": "Flight",
    "lat": "Latitude",
    "lon": "Longitude",
    "alt": "Altitude",
    "amsl": "Above sea level",
    "temp": "Temperature",
    "rpm": "Speed of rotation",
    "co2": "CO₂",
    "vel": "Velocity",
}
_QUANTITIES = ("temperature", "voltage", "pressure", "humidity", "torque")
_SHORT = re.compile(r"\btemp\b")
_FORMULA = re.compile(r"\b(co|no|so|o|h|ch|nh|pm) ?(\d(?:\.\d|\d)?)\b", re.IGNORECASE)
_SUBSCRIPT = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_GASES = {"co", "no", "so", "o", "h", "ch", "nh"}
_NO_WORD = re.compile(r"\b(?:cmd|is)\s+(?=\S)")
_JOINT = re.compile(r"\s*\bjoint\b(?!\s*\d)", re.IGNORECASE)


def plain_name(text: str) -> str:
    """Make a name of a field's own: ``co2_ppm`` gives CO₂, ``motor_temp_c`` Motor temperature."""
    words = readable_name(without_unit(text)).lower()
    if words in _SPOKEN:
        return _SPOKEN[words]
    words = _NO_WORD.sub("", _SHORT.sub("temperature", words))
    first, _, rest = words.partition(" ")
    if first in _QUANTITIES and rest and not rest[0].isdigit() and len(rest) > 1:
        words = f"{first} of {rest}"
    # After the units, for `co2_ppm` would not be a formula.
    words = _FORMULA.sub(_formula, words)
    # Abbreviations stay as the robot writes them: GPS, IMU.
    for big in re.findall(r"\b[A-Z]{2,}\b", readable_name(text)):
        words = re.sub(rf"\b{big.lower()}\b", big, words)
    return words[:1].upper() + words[1:]


def name_of_field(topic: TopicFound, field: FieldFound, topics: Iterable[TopicFound]) -> str:
    """Name one field of a topic, among all topics of the robot."""
    # A twist and an odometry both tell a speed.
    alike = (topic.type, *((_ODOMETRY,) if topic.type in _TWISTS else ()))
    alone = sum(other.type in alike for other in topics if other.publishers) == 1
    title = _title_of(topic)
    known = _NAMES.get(topic.type, {}).get(field.path)
    if field.name and "]." in field.path:
        # Of a part with a name of its own: the front motor's voltage.
        inside = _path_words(field.path.rpartition("].")[2].removeprefix("state."))
        return _joined(plain_name(field.name), inside)
    if field.name:
        part = field.path.split("[", 1)[0]
        return f"{joint_title(field.name)} {readable_name(part).lower()}"
    if known is not None:
        if alone or not title:
            return known
        # `/range/left` is the range on the left, `/battery` its charge level.
        return _joined(title, known)
    numbers = [one for one in topic.fields if one.type != "text"]
    if field.path == "data" or (len(numbers) == 1 and field.type != "text"):
        # `data` of std_msgs says nothing; the topic does.
        return plain_name(last_part(topic.topic, FORM_PARTS))
    words = _axis_words(topic, field) or _path_words(field.path)
    if field.path.startswith("data["):
        # People count from 1.
        number = int(field.path[5:-1]) + 1 if field.path[5:-1].isdigit() else field.path[5:-1]
        return f"{plain_name(last_part(topic.topic, _NO_NAME))} {number}"
    if topic.type == "sensor_msgs/msg/BatteryState" and alone:
        return words
    first = words.split(" ", 1)[0].lower()
    if not title or (first and title.lower().startswith(first)):
        return words
    return _joined(title, words)


def joint_title(name: str) -> str:
    """Say a joint's name without what all joints have: ``shoulder_pan_joint``, Shoulder pan."""
    said = readable_name(name)
    short = _JOINT.sub("", said).strip()
    return (short or said)[:1].upper() + (short or said)[1:]


def _joined(title: str, words: str) -> str:
    # An abbreviation or a formula stays as it is.
    first = words.split(" ", 1)[0]
    lower = words if not first[1:].islower() else words[:1].lower() + words[1:]
    return f"{title} {lower}"


def _title_of(topic: TopicFound) -> str:
    title = plain_name(last_part(topic.topic, _NO_NAME))
    *spaces, _ = topic.topic.strip("/").split("/")
    # Of `/gps/vel` the receiver is what tells it from others.
    return plain_name(spaces[-1]) if title in ("Velocity", "Twist") and spaces else title


def _axis_words(topic: TopicFound, field: FieldFound) -> str:
    """Name one of three numbers that are a vector by their unit: ``gyro_rad[2]``, Gyro z."""
    base, _, index = field.path.partition("[")
    listed = [one for one in topic.fields if one.path.startswith(f"{base}[")]
    if len(listed) != 3 or not field.unit or not index[:-1].isdigit():
        return ""
    return f"{_path_words(base)} {'xyz'[int(index[:-1])]}"


def _path_words(path: str) -> str:
    before, _, last = path.rpartition(".")
    if "[" in last or last in ("x", "y", "z", "w"):
        return path_in_words(path)
    words = plain_name(last)
    if not before:
        return words
    above = path_in_words(before)
    # No word twice: `battery.battery_voltage`.
    return words if words.lower().startswith(above.lower()) else _joined(above, words)


def _formula(found: re.Match[str]) -> str:
    letters, digits = found[1].lower(), found[2]
    if letters == "pm":
        return f"PM{digits}"
    if letters not in _GASES:
        return found[0]
    return letters.upper() + digits.translate(_SUBSCRIPT)
