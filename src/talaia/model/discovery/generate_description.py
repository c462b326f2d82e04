"""From what a probe found to a site description that runs as it is. Pure.

Everything that can be read becomes a signal; what people look at first is *primary*, the rest is
one click away. Limits of driving are low on purpose: the robot's owner raises them.

Long, because each kind of thing a robot has is proposed here and nowhere else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeVar

import msgspec

from talaia.model.checks.site_checks import check
from talaia.model.connection import IndiConnection, Ros1Connection, RosSource, source_as
from talaia.model.discovery.ros_units import human, word_of
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    Device,
    DeviceKind,
    Drive,
    DriveMessage,
    PositionFrame,
    Ros2Settings,
    Signal,
    SignalType,
    Site,
    Stop,
    Stream,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from talaia.model.connection import Connection
    from talaia.model.discovery.probe_report import (
        ActionFound,
        FieldFound,
        Found,
        ServiceFound,
        TopicFound,
    )

__all__ = ["Proposal", "propose"]

_T = TypeVar("_T")

# Slow and gentle: about a walking child's speed, until the owner says what the robot can do.
CAREFUL_SPEED = 0.2
CAREFUL_TURN = 0.5
MAX_PRIMARY = 12
MAX_ROUNDS = 5
PICTURES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_TWISTS = {
    "geometry_msgs/msg/Twist": DriveMessage.TWIST,
    "geometry_msgs/msg/TwistStamped": DriveMessage.TWIST_STAMPED,
}
_TYPES = {
    "number": ArgumentType.NUMBER,
    "integer": ArgumentType.INTEGER,
    "boolean": ArgumentType.BOOLEAN,
    "text": ArgumentType.TEXT,
}
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
_NAMES = {
    ("nav_msgs/msg/Odometry", "twist.twist.linear.x"): "Speed",
    ("nav_msgs/msg/Odometry", "twist.twist.angular.z"): "Turn rate",
    ("sensor_msgs/msg/BatteryState", "percentage"): "Charge level",
}
_RANGES = {"%": (0.0, 100.0)}
_SMALL = {"x", "y", "z", "w"}


class Proposal(NamedTuple):
    """A description, and in words what of the robot is not in it and why."""

    site: Site
    left_out: tuple[str, ...]


class _Place(NamedTuple):
    """Which device a topic belongs to: its word in addresses, its name, its kind."""

    word: str
    name: str
    kind: DeviceKind


def propose(found: Found, site: str, name: str, zone: str) -> Proposal:
    """Make a description of what was found.

    Args:
        found: what a probe saw.
        site: short name of the site, a word of an address.
        name: what people call it.
        zone: its IANA time zone.

    """
    made = _Made(found)
    proposed = Site(
        talaia=1,
        site=site,
        name=name,
        zone=zone,
        ros2=Ros2Settings(domain=found.domain) if found.protocol == "ros2" else None,
        connections=_connections(found),
        devices={**made.devices(), **_described(found)},
    )
    left_out = [*made.left_out, *_not_there(found)]
    for _ in range(MAX_ROUNDS):
        # What the checks refuse is left out, with their words: the rest runs. Leaving something
        # out can make a reference to it wrong, hence the rounds.
        wrong = [finding for finding in check(proposed) if finding.where.startswith("$.devices.")]
        if not wrong:
            break
        left_out += [str(finding) for finding in wrong]
        proposed = _without(proposed, [finding.where.split(".") for finding in wrong])
    return Proposal(proposed, tuple(left_out))


def _connections(found: Found) -> dict[str, Connection]:
    """Name how the robot is reached; ROS 2 has a key of its own."""
    match found.protocol:
        case "ros1":
            return {"ros1": Ros1Connection(master=found.master)}
        case "indi":
            return {"indi": IndiConnection(host=found.host, port=found.port)}
        case _:
            return {}


def _described(found: Found) -> dict[str, Device]:
    """Take over the devices that say themselves what they are."""
    return {
        device.word: device.described for device in found.devices if device.described is not None
    }


def _not_there(found: Found) -> list[str]:
    away = [device.device for device in found.devices if device.described is None]
    if not away:
        return []
    return [
        f"{', '.join(away)}: not connected to the hardware yet; the gateway connects these drivers "
        "and then describes them by itself (to have them here, run: talaia init --connect)"
    ]


def _without(site: Site, wrong: Iterable[list[str]]) -> Site:
    """Leave out what the findings' paths (``$.devices.base.signals.speed.unit``) are about."""
    devices = dict(site.devices)
    for path in wrong:
        word, part = path[2], path[3] if len(path) > 3 else ""
        device = devices.get(word)
        if device is None:
            continue
        kept = getattr(device, part, None)
        if isinstance(kept, dict) and len(path) > 4:
            rest = {key: child for key, child in kept.items() if key != path[4]}
            devices[word] = msgspec.structs.replace(device, **{part: rest})
        elif part == "drive":
            devices[word] = msgspec.structs.replace(device, drive=None)
        else:
            del devices[word]
    return msgspec.structs.replace(site, devices=devices)


class _Made:
    """The devices, as they grow."""

    def __init__(self, found: Found) -> None:
        self._found = found
        self.left_out: list[str] = []
        self._signals: dict[_Place, dict[str, Signal]] = {}
        self._streams: dict[_Place, dict[str, Stream]] = {}
        self._commands: dict[_Place, dict[str, Command]] = {}
        self._drives: dict[_Place, Drive] = {}
        self._words: dict[str, str] = {}

    def devices(self) -> dict[str, Device]:
        published = [topic for topic in self._found.topics if topic.publishers]
        for topic in published:
            self._topic(topic)
        for service in self._found.services:
            self._service(service)
        for action in self._found.actions:
            self._action(action)
        for topic in self._found.topics:
            if topic.subscribers and not topic.publishers:
                self._listener(topic)
        self._choose_primary()
        places = sorted(
            {*self._signals, *self._streams, *self._commands, *self._drives}, key=_order
        )
        return {
            place.word: Device(
                name=place.name,
                kind=place.kind,
                signals=self._signals.get(place, {}),
                streams=self._streams.get(place, {}),
                commands=self._commands.get(place, {}),
                drive=self._drives.get(place),
            )
            for place in places
        }

    # ── published topics ──

    def _topic(self, topic: TopicFound) -> None:
        if topic.problem:
            self.left_out.append(f"{topic.topic}: {topic.problem}")
            return
        self.left_out += [f"{topic.topic} {field}" for field in topic.left_out]
        place = self._place(topic.topic, topic.type)
        if topic.type in PICTURES:
            streams = self._streams.setdefault(place, {})
            last = _last(topic.topic, ("image_raw", "image", "images", "compressed", "image_color"))
            word = _free(word_of(last), streams)
            source = RosSource(topic=topic.topic, type=topic.type)
            streams[word] = Stream(name=human(last) or "Camera", source=source)
            return
        signals = self._signals.setdefault(place, {})
        if topic.names:
            for sensor in topic.names:
                source = RosSource(topic=topic.topic, type=topic.type, name=sensor)
                signals[_free(word_of(sensor), signals)] = Signal(
                    name=human(sensor) or sensor, source=source, max_age=_age(topic.rate)
                )
            return
        for word, signal in self._positions(topic):
            signals[_free(word, signals)] = signal
        for field in topic.fields:
            if _in_position(topic.type, field.path):
                continue
            name = self._name(topic, field)
            signals[_free(word_of(name), signals)] = _signal(topic, field, name)
        if not signals:
            del self._signals[place]
            if not topic.left_out:
                self.left_out.append(f"{topic.topic}: a {topic.type} holds no number or text")

    def _positions(self, topic: TopicFound) -> Iterator[tuple[str, Signal]]:
        last = human(_last(topic.topic, ()))
        if topic.type == "sensor_msgs/msg/NavSatFix":
            yield (
                "position",
                Signal(
                    name=f"{last} position" if last != "Fix" else "Geographic position",
                    type=SignalType.POSITION,
                    frame=PositionFrame.WGS84,
                    max_age=_age(topic.rate),
                    primary=False,
                    source=RosSource(topic=topic.topic, type=topic.type),
                ),
            )
        base = _POSES.get(topic.type)
        if base is not None:
            at, turn = (f"{base}.position", f"{base}.orientation") if base else (
                "position", "orientation",
            )  # fmt: skip
            yield (
                "pose",
                Signal(
                    name=f"{last} position",
                    type=SignalType.POSITION,
                    frame=PositionFrame.LOCAL,
                    yaw_from=turn,
                    max_rate=10.0,
                    max_age=_age(topic.rate),
                    primary=False,
                    source=RosSource(topic=topic.topic, type=topic.type, field=at),
                ),
            )

    def _name(self, topic: TopicFound, field: FieldFound) -> str:
        known = _NAMES.get((topic.type, field.path))
        last = human(_last(topic.topic, ()))
        alone = len([field for field in topic.fields if field.type != "text"]) == 1
        if known is not None:
            # Two odometries at one device must not both be called Speed.
            return known if self._only(topic) else f"{last} {known.lower()}"
        if field.path == "data" or (alone and field.type != "text"):
            return last
        if topic.type == "sensor_msgs/msg/BatteryState" and self._only(topic):
            return _short(field.path)
        said = _short(field.path)
        if field.name:
            said = f"{human(field.name)} {human(field.path.split('[', 1)[0]).lower()}"
        first = said.split(" ", 1)[0].lower()
        if first and last.lower().startswith(first):
            return said[:1].upper() + said[1:]
        return f"{last} {said[:1].lower() + said[1:]}" if not field.name else f"{last} {said}"

    def _only(self, topic: TopicFound) -> bool:
        return sum(other.type == topic.type for other in self._found.topics) == 1

    # ── what can be asked ──

    def _service(self, service: ServiceFound) -> None:
        if service.problem:
            self.left_out.append(f"{service.service}: {service.problem}")
            return
        place = self._place(service.service, service.type)
        self._command(place, service.service, service.type, CommandKind.SERVICE, service.fields)

    def _action(self, action: ActionFound) -> None:
        if action.problem:
            self.left_out.append(f"{action.action}: {action.problem}")
            return
        place = self._place(action.action, action.type)
        self._command(place, action.action, action.type, CommandKind.ACTION, action.fields)

    def _command(
        self,
        place: _Place,
        target: str,
        type_name: str,
        kind: CommandKind,
        fields: Iterable[FieldFound],
    ) -> None:
        commands = self._commands.setdefault(place, {})
        arguments: dict[str, Argument] = {}
        for field in fields:
            shown = human(field.path) if field.path != "data" else "On"
            arguments[_free(word_of(field.path), arguments)] = Argument(
                type=_TYPES[field.type], field=field.path, name=shown, unit=field.unit
            )
        last = _last(target, ())
        commands[_free(word_of(last), commands)] = Command(
            name=human(last) or last,
            target=target,
            type=type_name,
            kind=kind,
            arguments=arguments,
            confirm=True,
        )

    # ── what listens ──

    def _listener(self, topic: TopicFound) -> None:
        last = _last(topic.topic, ())
        message = _TWISTS.get(topic.type)
        if message is None and topic.type == "std_msgs/msg/String" and last == "control":
            # CloudConnect's own contract; a velocity topic is the better way where both are.
            if any(topic.type in _TWISTS and topic.subscribers for topic in self._found.topics):
                return
            message = DriveMessage.KEYS
        if message is None or (message is not DriveMessage.KEYS and "cmd_vel" not in last):
            return
        place = self._place(topic.topic, "geometry_msgs/msg/Twist")
        if place in self._drives:
            self.left_out.append(f"{topic.topic}: {place.name} is driven by another topic already")
            return
        self._drives[place] = Drive(
            topic=topic.topic,
            message=message,
            max_speed=CAREFUL_SPEED,
            max_turn=CAREFUL_TURN,
            picture=self._first(self._streams),
            position=self._first(self._signals, lambda signal: signal.type is SignalType.POSITION),
            stop=self._stop(place),
        )

    def _stop(self, place: _Place) -> Stop:
        topic = next(
            (
                topic.topic
                for topic in self._found.topics
                if topic.subscribers
                and topic.type == "std_msgs/msg/Bool"
                and _last(topic.topic, ()) in ("stop", "e_stop", "estop", "emergency_stop")
            ),
            "",
        )
        moving = [
            f"{place.word}/{word}"
            for word, signal in self._signals.get(place, {}).items()
            if isinstance(signal.source, RosSource)
            and (signal.source.type, signal.source.field) in list(_NAMES)[:2]
        ]
        return Stop(topic=topic, confirmed_by=tuple(moving))

    def _first(
        self, where: dict[_Place, dict[str, _T]], fits: Callable[[_T], bool] = lambda _: True
    ) -> str:
        for place in sorted(where, key=_order):
            for word, signal in where[place].items():
                if fits(signal):
                    return f"{place.word}/{word}"
        return ""

    # ── which device ──

    def _place(self, topic: str, type_name: str) -> _Place:
        spaces = topic.strip("/").split("/")[:-1]
        if type_name in PICTURES or type_name == "sensor_msgs/msg/CameraInfo":
            return self._named("camera", "Camera", DeviceKind.CAMERA, spaces[:-1])
        if type_name == "sensor_msgs/msg/BatteryState":
            return self._named("power", "Battery", DeviceKind.POWER, spaces)
        if type_name.startswith(("nav_msgs/", "geometry_msgs/msg/Twist")):
            return self._named("base", "Vehicle base", DeviceKind.VEHICLE, spaces)
        if spaces:
            return self._named("", "", DeviceKind.OTHER, spaces)
        package = type_name.split("/", 1)[0]
        if "/srv/" in type_name or "/action/" in type_name:
            driven = [topic.topic for topic in self._found.topics if _drives(topic)]
            if not driven:
                return self._named("robot", "Robot", DeviceKind.OTHER, ())
            return self._place(driven[0], "geometry_msgs/msg/Twist")
        if package in ("std_msgs", "sensor_msgs", "geometry_msgs"):
            return self._named("sensors", "Sensors", DeviceKind.OTHER, ())
        trimmed = package.removesuffix("_msgs").removesuffix("_interfaces") or package
        return self._named(trimmed, human(trimmed), DeviceKind.OTHER, ())

    def _named(self, word: str, name: str, kind: DeviceKind, spaces: Iterable[str]) -> _Place:
        parts = [space for space in spaces if space]
        whole = "_".join([*parts, word] if word else parts)
        title = " ".join([*(human(part) for part in parts), name.lower() if parts else name])
        return _Place(word_of(whole), title.strip(), kind)

    # ── what is shown first ──

    def _choose_primary(self) -> None:
        """Leave at most a dozen primary: those people know first, then numbers with a unit."""
        ranked: list[tuple[int, int, _Place, str]] = []
        order = 0
        for place, signals in self._signals.items():
            for word, signal in signals.items():
                order += 1
                rank = _rank(signal)
                if rank is not None:
                    ranked.append((rank, order, place, word))
        chosen = {(place, word) for _, _, place, word in sorted(ranked)[:MAX_PRIMARY]}
        for place, signals in self._signals.items():
            for word, signal in signals.items():
                wanted = (place, word) in chosen
                if signal.primary is not wanted:
                    signals[word] = msgspec.structs.replace(signal, primary=wanted)


_POSES = {
    "nav_msgs/msg/Odometry": "pose.pose",
    "geometry_msgs/msg/PoseStamped": "pose",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "pose.pose",
    "geometry_msgs/msg/Pose": "",
}


def _drives(topic: TopicFound) -> bool:
    return topic.type in _TWISTS and topic.subscribers > 0 and "cmd_vel" in topic.topic


def _in_position(type_name: str, path: str) -> bool:
    """Tell whether a field is part of the position signal that its topic gives already."""
    if type_name == "sensor_msgs/msg/NavSatFix":
        return path in ("latitude", "longitude", "altitude")
    base = _POSES.get(type_name)
    if base is None:
        return False
    at = f"{base}.position" if base else "position"
    return path in (f"{at}.x", f"{at}.y")


def _signal(topic: TopicFound, field: FieldFound, name: str) -> Signal:
    source = RosSource(topic=topic.topic, type=topic.type, field=field.path)
    low, high = _RANGES.get(field.unit, (None, None))
    age = _age(topic.rate)
    if field.type == "text":
        return Signal(name=name, type=SignalType.TEXT, source=source, max_age=age)
    if field.type == "boolean":
        return Signal(
            name=name, type=SignalType.STATE, states=("off", "on"), source=source, max_age=age
        )
    if field.words:
        return Signal(
            name=name, type=SignalType.STATE, states=field.words, source=source, max_age=age
        )
    whole = field.type == "integer" and field.scale == 1.0 and not field.unit
    made = Signal(
        name=name,
        unit=field.unit,
        minimum=low,
        maximum=high,
        max_age=age,
        source=source,
        primary=not field.empty,
    )
    changes: dict[str, object] = {} if field.scale == 1.0 else {"scale": field.scale}
    if whole:
        changes["decimals"] = 0
    return msgspec.structs.replace(made, **changes) if changes else made


def _rank(signal: Signal) -> int | None:
    """Give the place in the queue for the first page; none for what is never on it."""
    if signal.type in (SignalType.TEXT, SignalType.POSITION) or not signal.primary:
        return None
    source = source_as(signal.source, RosSource)
    key = (source.type, source.field)
    if key in _FIRST:
        return _FIRST.index(key)
    if source.name or source.field == "data":
        return len(_FIRST)
    if signal.type is SignalType.STATE:
        return len(_FIRST) + 3
    return len(_FIRST) + (1 if signal.unit else 2)


def _age(rate: float) -> float:
    """Give how old a value may be before it is stale: five times its usual spacing (s)."""
    if rate <= 0:
        return 60.0
    return min(max(round(5.0 / rate, 1), 2.0), 3600.0)


def _short(path: str) -> str:
    """Say a path in words, without what repeats: ``pose.pose.position.x`` → Pose position x."""
    words: list[str] = []
    for step in path.replace("[", " ").replace("]", "").replace(".", " ").split():
        word = step if step in _SMALL else human(step).lower()
        if word and (not words or words[-1] != word):
            words.append(word)
    said = " ".join(words)
    return said[:1].upper() + said[1:]


def _last(topic: str, skip: Iterable[str]) -> str:
    """Give the telling last part of a topic; the part before it where the last says nothing."""
    parts = topic.strip("/").split("/")
    while len(parts) > 1 and parts[-1] in skip:
        parts.pop()
    return parts[-1]


def _free(word: str, taken: Iterable[str]) -> str:
    """Give the word, or with a number behind where it is taken."""
    if word not in taken:
        return word
    for number in range(2, 10_000):
        tail = f"_{number}"
        other = word[: 63 - len(tail)] + tail
        if other not in taken:
            return other
    return word


def _order(place: _Place) -> tuple[int, str]:
    kinds = (DeviceKind.VEHICLE, DeviceKind.CAMERA, DeviceKind.POWER)
    return (kinds.index(place.kind) if place.kind in kinds else len(kinds), place.word)
