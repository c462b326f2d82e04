"""Signals of what a robot publishes, by the device they belong to. Pure.

Holds for whoever reads them: words are unique within a device, no field is given twice (once alone
and once within a position), and after `choose_primary` at most `MAX_PRIMARY` are primary.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import RosSource, source_as
from talaia.model.connections.ros import DIAGNOSTICS
from talaia.model.discovery.ros_units import readable_name, unit_in_name, word_of
from talaia.model.discovery.rules.field_names import (
    FORM_PARTS,
    JOINTS,
    joint_title,
    name_of_field,
    plain_name,
)
from talaia.model.discovery.rules.unwanted_fields import wanted_fields
from talaia.model.discovery.rules.whole_topics import LEVELS
from talaia.model.discovery.topic_words import free_word, last_part
from talaia.model.roles import StateMeaning
from talaia.model.site import PositionFrame, Signal, SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from talaia.model.discovery.device_places import DevicePlace
    from talaia.model.discovery.probe_report import FieldFound, JointFound, TopicFound

__all__ = ["MAX_PRIMARY", "ProposedSignals"]

# More tiles than that do not fit on a first page.
MAX_PRIMARY = 12
# What people look at first, by type and path; the first in the list first.
_FIRST: tuple[tuple[str, str], ...] = (
    ("sensor_msgs/msg/BatteryState", "percentage"),
    ("sensor_msgs/msg/BatteryState", "voltage"),
    ("nav_msgs/msg/Odometry", "twist.twist.linear.x"),
    ("nav_msgs/msg/Odometry", "twist.twist.angular.z"),
    ("sensor_msgs/msg/Temperature", "temperature"),
    ("sensor_msgs/msg/RelativeHumidity", "relative_humidity"),
    ("sensor_msgs/msg/FluidPressure", "fluid_pressure"),
    ("sensor_msgs/msg/Range", "range"),
    ("sensor_msgs/msg/Illuminance", "illuminance"),
    ("sensor_msgs/msg/Imu", "linear_acceleration.x"),
)
_RANGES = {"%": (0.0, 100.0)}
# By type: the path of the pose in it.
_POSES = {
    "nav_msgs/msg/Odometry": "pose.pose",
    "geometry_msgs/msg/PoseStamped": "pose",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose",
    "geometry_msgs/msg/Pose": "",
}
# Of the levels of diagnostics, in their order.
_MEANINGS = (
    StateMeaning.NORMAL,
    StateMeaning.WARNING,
    StateMeaning.ERROR,
    StateMeaning.UNKNOWN,
)
_MEASURED = ("number", "integer")
# A topic whose spacing is not known: it speaks now and then.
_RARE_S = 3600.0
# Delays within it are one: a page shows no difference, and a day of them takes no room.
_DELAY_DEADBAND_S = 0.02
# Last parts that say how a position was made, and not whose it is.
_TURNED = ("filtered", "pose", "current_pose")
# Joints that slide, by what they are called.
_SLIDES = re.compile(r"finger|gripper|lift|prismatic|slide|linear|rail|torso")
_GEOGRAPHIC = "sensor_msgs/msg/NavSatFix"


class ProposedSignals:
    """The signals of all devices, as topics are added."""

    def __init__(
        self,
        topics: tuple[TopicFound, ...],
        joints: tuple[JointFound, ...] = (),
        is_level: Callable[[str], bool] = lambda _: True,
    ) -> None:
        """Start with none.

        Args:
            topics: all of the robot's, for names that must differ.
            joints: what its model says of them.
            is_level: tells whether what a topic belongs to moves on level ground.

        """
        self._topics = topics
        self._is_level = is_level
        self._joints = {joint.joint: joint for joint in joints}
        # In words: fields that are no signals, and why.
        self.left_out: list[str] = []
        # By device and word, in the order in which topics came: the page keeps it.
        self._signals: dict[DevicePlace, dict[str, Signal]] = {}

    @property
    def by_place(self) -> Mapping[DevicePlace, Mapping[str, Signal]]:
        """The signals by device and word."""
        return self._signals

    def at_place(self, place: DevicePlace) -> dict[str, Signal]:
        """Give a device's signals by word; none is an empty map."""
        return self._signals.get(place, {})

    def add_topic(self, place: DevicePlace, topic: TopicFound) -> bool:
        """Add the signals of a topic to a device; tell whether that has any signal now."""
        signals = self._signals.setdefault(place, {})
        if topic.names:
            for sensor in topic.names:
                signals[free_word(word_of(sensor), signals)] = _sensor_of(topic, sensor)
            self._add_delay(signals, topic)
            return True
        before = len(signals)
        for word, signal in _positions_of(topic):
            signals[free_word(word, signals)] = signal
        wanted = wanted_fields(topic, level=self._is_level(topic.topic))
        self.left_out += wanted.left_out
        for field in wanted.fields:
            if _is_in_position(topic.type, field.path):
                continue
            name = name_of_field(topic, field, self._topics)
            signals[free_word(word_of(name), signals)] = self._signal_of(topic, field, name)
        if len(signals) > before:
            self._add_delay(signals, topic)
        if not signals:
            # A device without anything on it would be an empty page.
            del self._signals[place]
        return bool(signals)

    def _add_delay(self, signals: dict[str, Signal], topic: TopicFound) -> None:
        """Keep by how much messages come after their stamps, so that no arrival is lost."""
        if not topic.stamped or topic.latched:
            # What is latched is as old as it likes when somebody comes to hear it.
            return
        name = f"{plain_name(last_part(topic.topic, FORM_PARTS))} delay"
        signals[free_word(word_of(name), signals)] = Signal(
            name=name,
            unit="s",
            deadband=_DELAY_DEADBAND_S,
            # Repeated twice in it, where nothing changes.
            max_age=_RARE_S,
            primary=False,
            source=RosSource(topic=topic.topic, type=topic.type, delay=True),
        )

    def add_signal(self, place: DevicePlace, word: str, signal: Signal) -> None:
        """Add a signal that is no topic's."""
        signals = self._signals.setdefault(place, {})
        signals[free_word(word, signals)] = signal

    def choose_primary(self) -> None:
        """Leave at most a dozen primary: those people know first, then numbers with a unit."""
        ranked: list[tuple[int, int, DevicePlace, str]] = []
        order = 0
        for place, signals in self._signals.items():
            for word, signal in signals.items():
                # The order breaks ties, so that the same robot always gets the same page.
                order += 1
                rank = _rank_of(signal)
                if rank is not None:
                    ranked.append((rank, order, place, word))
        chosen = {(place, word) for _, _, place, word in sorted(ranked)[:MAX_PRIMARY]}
        for place, signals in self._signals.items():
            for word, signal in signals.items():
                wanted = (place, word) in chosen
                if signal.primary is not wanted:
                    signals[word] = msgspec.structs.replace(signal, primary=wanted)

    def _is_of_the_sky(self, topic: str) -> bool:
        """Tell whether an altitude is an angle, of whose unit its name says nothing.

        It is one of the Sun or the Moon, or stands beside an azimuth.
        """
        above, _, last = topic.rpartition("/")
        words = last.lower().split("_")
        if not {"altitude", "alt"} & {*words}:
            return False
        beside = {f"{above}/azimuth", f"{above}/az"}
        return bool({"sun", "moon"} & {*words}) or any(one.topic in beside for one in self._topics)

    def _signal_of(self, topic: TopicFound, field: FieldFound, name: str) -> Signal:
        if topic.type == JOINTS:
            return _joint_signal(topic, field, self._joints.get(field.name), modelled=self._joints)
        if field.path.startswith("data") and not field.unit and field.type in _MEASURED:
            # Of std_msgs only the topic's name tells what the number is.
            said = unit_in_name(last_part(topic.topic, ("data",)))
            if said is not None and not self._is_of_the_sky(topic.topic):
                field = msgspec.structs.replace(field, unit=said.unit, scale=said.scale)
        return _signal_of(topic, field, name)


def _joint_signal(
    topic: TopicFound,
    field: FieldFound,
    joint: JointFound | None,
    *,
    modelled: Mapping[str, JointFound],
) -> Signal:
    """Give one number of a joint: turning in rad, sliding in m, with the ends of its model."""
    part = field.path.split("[", 1)[0]
    if joint is not None:
        slides = joint.type == "prismatic"
    else:
        # Without a model, by what such joints are called; where there is one, nobody knows.
        slides = bool(_SLIDES.search(field.name)) or (bool(modelled) and not field.name)
    units = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N·m")
    unit = dict(zip(("position", "velocity", "effort"), units, strict=True)).get(part, "")
    position = joint is not None and part == "position"
    return Signal(
        name=f"{joint_title(field.name)} {part}" if field.name else f"Joint {part}",
        unit=unit,
        minimum=joint.lower if joint is not None and position else None,
        maximum=joint.upper if joint is not None and position else None,
        max_age=_age_of(topic),
        # Wheels turn without end: where one stands nobody asks.
        primary=part == "position" and joint is not None and joint.lower is not None,
        source=RosSource(topic=topic.topic, type=topic.type, field=field.path),
    )


def _sensor_of(topic: TopicFound, sensor: str) -> Signal:
    """Give the signal of one sensor of a topic that carries many of them by name."""
    source = RosSource(topic=topic.topic, type=topic.type, name=sensor)
    if topic.type == DIAGNOSTICS:
        return Signal(
            # As the robot writes it: `lidar: scan rate` is a path for people.
            name=sensor[:100] or "Unnamed",
            type=SignalType.STATE,
            states=LEVELS,
            meanings=_MEANINGS,
            source=source,
            max_age=_age_of(topic),
        )
    return Signal(name=readable_name(sensor) or sensor, source=source, max_age=_age_of(topic))


def _positions_of(topic: TopicFound) -> Iterator[tuple[str, Signal]]:
    """Give a topic's positions, each with its word."""
    last = plain_name(last_part(topic.topic, _TURNED))
    if topic.type == _GEOGRAPHIC:
        yield (
            "position",
            Signal(
                # Drivers call it `/fix`, which no person says.
                name="Geographic position"
                if last in ("Position", "Global")
                else f"{last} position",
                type=SignalType.POSITION,
                frame=PositionFrame.WGS84,
                max_age=_age_of(topic),
                primary=False,
                source=RosSource(topic=topic.topic, type=topic.type),
            ),
        )
    base = _POSES.get(topic.type)
    if base is not None:
        inside = f"{base}." if base else ""
        yield (
            "pose",
            Signal(
                name=_position_name(last),
                type=SignalType.POSITION,
                frame=PositionFrame.LOCAL,
                yaw_from=f"{inside}orientation",
                # A map shows no more; odometry comes at 50 Hz and above.
                max_rate=10.0,
                max_age=_age_of(topic),
                primary=False,
                source=RosSource(topic=topic.topic, type=topic.type, field=f"{inside}position"),
            ),
        )


def _position_name(last: str) -> str:
    if last.lower() in ("pose", "position"):
        return "Position"
    return last if last.lower().endswith("position") else f"{last} position"


def _is_in_position(type_name: str, path: str) -> bool:
    """Tell whether a field is part of the position signal that its topic gives already."""
    if type_name == _GEOGRAPHIC:
        return path in ("latitude", "longitude", "altitude")
    base = _POSES.get(type_name)
    if base is None:
        return False
    # Height stays a signal of its own: a local position is shown on a plane.
    at = f"{base}.position" if base else "position"
    return path in (f"{at}.x", f"{at}.y")


def _signal_of(topic: TopicFound, field: FieldFound, name: str) -> Signal:
    source = RosSource(topic=topic.topic, type=topic.type, field=field.path)
    low, high = _RANGES.get(field.unit, (None, None))
    age = _age_of(topic)
    if field.type == "text":
        return Signal(name=name, type=SignalType.TEXT, source=source, max_age=age)
    if field.type == "boolean":
        return Signal(
            name=name, type=SignalType.STATE, states=("off", "on"), source=source, max_age=age
        )
    if field.words:
        # Constants of the definition, in the order of their numbers.
        return Signal(
            name=name, type=SignalType.STATE, states=field.words, source=source, max_age=age
        )
    whole = field.type == "integer" and field.scale == 1.0 and not field.unit
    signal = Signal(
        name=name,
        unit=field.unit,
        minimum=low,
        maximum=high,
        max_age=age,
        source=source,
        # Every value that the probe saw was NaN: there is probably no such sensor.
        primary=not field.empty,
    )
    # Only what differs is set: the description that is written stays short.
    changes: dict[str, object] = {} if field.scale == 1.0 else {"scale": field.scale}
    if whole:
        changes["decimals"] = 0
    return msgspec.structs.replace(signal, **changes) if changes else signal


def _rank_of(signal: Signal) -> int | None:
    """Give the place in the queue for the first page; none for what is never on it."""
    if signal.type in (SignalType.TEXT, SignalType.POSITION) or not signal.primary:
        return None
    source = source_as(signal.source, RosSource)
    key = (source.type, source.field)
    if key in _FIRST:
        return _FIRST.index(key)
    # Somebody gave it a topic or a name of its own, so it matters to them.
    if source.lifecycle or source.name or source.field == "data":
        return len(_FIRST)
    # Where an arm is, before what its controllers say of themselves.
    if source.type == JOINTS:
        return len(_FIRST)
    if signal.type is SignalType.STATE:
        return len(_FIRST) + 3
    return len(_FIRST) + (1 if signal.unit else 2)


def _age_of(topic: TopicFound) -> float:
    """Give how old a topic's value may be before it is stale (s): five times its usual spacing.

    A latched one holds until another comes: 0, for never.
    """
    if topic.latched:
        return 0.0
    if topic.rate <= 0:
        return _RARE_S
    return min(max(round(5.0 / topic.rate, 1), 2.0), _RARE_S)
