"""What the pages change, as functions from one site to the next. Pure.

Nothing here checks what `talaia check` checks: a description may be wrong while it is edited, and
says so.

Long, because each change that a page makes is one function, and they share what they add.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.configurator.description_paths import (
    Path,
    new_source,
    remove_value,
    value_at,
    with_value,
)
from talaia.configurator.errors import ConfiguratorError, WordTaken
from talaia.model.ai_services import AiServices
from talaia.model.connection import ROS_KINDS, RosSource, kind_of, source_as
from talaia.model.discovery.ros_units import word_of
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    Device,
    DeviceKind,
    Drive,
    DriveMessage,
    PositionFrame,
    Ros2Settings,
    Signal,
    SignalType,
    Site,
    Stream,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.configurator.presets import SensorKind
    from talaia.model.base import Shape

__all__ = [
    "Group",
    "NewSensor",
    "ai_services",
    "camera_paths",
    "driven_devices",
    "free_number",
    "free_word",
    "groups_at",
    "new_site",
    "position_paths",
    "with_camera",
    "with_device",
    "with_drive",
    "with_gps",
    "with_sensor",
    "with_services",
    "with_thing",
    "without_things",
]

# The founding vehicle's own topics; a robot with others says which.
METRIC = "/metric"
IMAGES = "/images"
CONTROL = "/control"
FIX = "/fix"
# CloudConnect's nodes publish each reading as a text with its name and value.
TEXT = "std_msgs/msg/String"
# About a walking child's speed, until the owner says what the robot can do.
CAREFUL_SPEED = 0.2
CAREFUL_TURN = 0.5
# A GPS says little more often than once a second, and nothing for a while under a roof.
FIX_AGE_S = 10.0


class NewSensor(NamedTuple):
    """What a person chose: the kind, the number, for *Others* a name, and a unit.

    ``unit`` is a symbol of `model.units.unit`; empty takes the kind's own.
    """

    kind: SensorKind
    # From 1; part of the address, so that the second thermometer is another sensor.
    number: int
    name: str = ""
    unit: str = ""

    @property
    def word(self) -> str:
        """The last part of its address: ``temperature1``."""
        tail = str(self.number)
        # Cut so that word and number together stay within the 63 letters of a name.
        return (self.kind.word or word_of(self.name))[: 63 - len(tail)] + tail

    @property
    def wire_name(self) -> str:
        """What the robot calls it on ``/metric``; for *Others* letter for letter as it was typed.

        A node of one's own may say ``CO2 level1`` or ``Accelerometer1``; an address may not.
        """
        return f"{self.kind.word or self.name.strip()}{self.number}"


def new_site(word: str, name: str, zone: str) -> Site:
    """Give a description with nothing in it, of a robot that speaks ROS 2."""
    return Site(talaia=1, site=word, name=name, zone=zone, ros2=Ros2Settings())


# ── AI services ──


def ai_services(site: Site) -> AiServices:
    """Tell which are wanted."""
    return site.services or AiServices()


def with_services(site: Site, services: AiServices) -> Site:
    """Want these; a site that wants none has no key for it."""
    # Not a key with everything off: a description says only what is wanted.
    wanted = None if services == AiServices() else services
    return msgspec.structs.replace(site, services=wanted)


# ── sensors ──


def free_number(site: Site, kind: SensorKind, name: str = "") -> int:
    """Give the lowest number that no sensor of this kind has."""
    taken = _taken_addresses(site)
    number = 1
    while not taken.keys().isdisjoint(_names_of(NewSensor(kind, number, name))):
        number += 1
    return number


def _names_of(new: NewSensor) -> set[str]:
    return {new.word, new.wire_name}


def _taken_addresses(site: Site) -> dict[str, str]:
    """Give the addresses of all signals, by their word and by their name on ``/metric``."""
    signals = [
        (f"{device_id}/{word}", word, signal)
        for device_id, device in site.devices.items()
        for word, signal in device.signals.items()
    ]
    # A sensor may have been renamed here while the robot calls it as before.
    heard = {
        name: address
        for address, _, signal in signals
        if (name := source_as(signal.source, RosSource).name)
    }
    # A signal of that word wins over one that the robot calls so.
    return heard | {word: address for address, word, _ in signals}


def with_sensor(site: Site, new: NewSensor) -> Site:
    """Add a sensor that the robot tells by name on ``/metric``.

    Raises:
        WordTaken: there is a sensor of that kind and number.
        ConfiguratorError: it has no name, or the site no ROS to hear it by.

    """
    if not new.kind.word and not new.name.strip():
        raise ConfiguratorError("a custom sensor needs a name")
    taken = _taken_addresses(site)
    if there := taken.get(new.word) or taken.get(new.wire_name):
        raise WordTaken(
            f"{there} is there already; number {free_number(site, new.kind, new.name)} is free"
        )
    # All of them in one device: ``/metric`` does not say which part a reading is of.
    site, place = with_device(site, "sensors", "Sensors", DeviceKind.OTHER)
    name = new.name.strip() or new.kind.name
    unit = new.unit or new.kind.unit
    usual = unit == new.kind.unit
    signal = Signal(
        name=f"{name} {new.number}",
        unit=unit,
        # A usual range is in the kind's own unit; with another unit it would be wrong.
        minimum=new.kind.minimum if usual else None,
        maximum=new.kind.maximum if usual else None,
        source=RosSource(topic=METRIC, type=TEXT, name=new.wire_name),
    )
    return with_value(site, ("devices", place, "signals", new.word), signal)


def with_device(site: Site, word: str, name: str, kind: DeviceKind) -> tuple[Site, str]:
    """Give a device of that word that is reached by ROS, made where there is none.

    Raises:
        ConfiguratorError: the site has connections, and none of them speaks ROS.

    """
    # A description begun by hand may have no connection yet.
    if not site.links():
        site = msgspec.structs.replace(site, ros2=Ros2Settings())
    links = site.links()
    by_ros = [name for name, link in links.items() if kind_of(link) in ROS_KINDS]
    if not by_ros:
        raise ConfiguratorError(
            "this needs a robot that speaks ROS, and the site has "
            f"{', '.join(links)} only; add a connection in the file"
        )
    wanted = word
    # A device of that name that is reached otherwise stays; a ROS source could not be read there.
    while word in site.devices and site.connection_of(word) not in by_ros:
        word = free_word(wanted, site.devices)
    if word not in site.devices:
        # With a single connection a device needs no key for it.
        link = "" if len(links) == 1 else by_ros[0]
        site = with_value(site, ("devices", word), Device(name=name, kind=kind, connection=link))
    return site, word


# ── services ──


def driven_devices(site: Site) -> list[str]:
    """Name the devices that can be driven."""
    return [word for word, described in site.devices.items() if described.drive is not None]


def camera_paths(site: Site) -> list[Path]:
    """Give the path of every stream."""
    return [
        ("devices", word, "streams", name)
        for word, device in site.devices.items()
        for name in device.streams
    ]


def position_paths(site: Site) -> list[Path]:
    """Give the path of every position on Earth."""
    return [
        ("devices", word, "signals", name)
        for word, device in site.devices.items()
        for name, signal in device.signals.items()
        if signal.type is SignalType.POSITION and signal.frame is PositionFrame.WGS84
    ]


def with_drive(site: Site, topic: str = CONTROL, message: DriveMessage = DriveMessage.KEYS) -> Site:
    """Make a device drivable (*actuate*), slowly, with the first camera and position in view."""
    vehicle = next(
        (word for word, device in site.devices.items() if device.kind is DeviceKind.VEHICLE), "base"
    )
    site, place = with_device(site, vehicle, "Vehicle base", DeviceKind.VEHICLE)
    drive = Drive(
        topic=topic,
        message=message,
        max_speed=CAREFUL_SPEED,
        max_turn=CAREFUL_TURN,
        picture=next((f"{camera[1]}/{camera[3]}" for camera in camera_paths(site)), ""),
        position=next((f"{path[1]}/{path[3]}" for path in position_paths(site)), ""),
    )
    return with_value(site, ("devices", place, "drive"), drive)


def with_camera(site: Site, topic: str = IMAGES) -> Site:
    """Add a camera; what is driven without a picture gets it."""
    site, place = with_device(site, "camera", "Camera", DeviceKind.CAMERA)
    word = free_word("front", site.devices[place].streams)
    name = "Front camera" if word == "front" else f"Camera {word.rpartition('_')[2]}"
    source = RosSource(topic=topic, type="sensor_msgs/msg/Image")
    site = with_value(site, ("devices", place, "streams", word), Stream(name=name, source=source))
    return _seen_while_driving(site, "picture", f"{place}/{word}")


def with_gps(site: Site, topic: str = FIX) -> Site:
    """Add a position on Earth."""
    site, place = with_device(site, "gps", "GPS", DeviceKind.OTHER)
    word = free_word("position", site.devices[place].signals)
    signal = Signal(
        name="Geographic position",
        type=SignalType.POSITION,
        frame=PositionFrame.WGS84,
        max_age=FIX_AGE_S,
        primary=False,
        source=RosSource(topic=topic, type="sensor_msgs/msg/NavSatFix"),
    )
    site = with_value(site, ("devices", place, "signals", word), signal)
    return _seen_while_driving(site, "position", f"{place}/{word}")


def _seen_while_driving(site: Site, key: str, address: str) -> Site:
    for word in driven_devices(site):
        # Only where nothing is chosen: a person's own picture stays.
        if value_at(site, ("devices", word, "drive", key)) == "":
            site = with_value(site, ("devices", word, "drive", key), address)
    return site


# ── things that people write by themselves ──


class Group(NamedTuple):
    """A kind of thing that can be added to another one.

    Attributes:
        key: of the mapping it stands in; for ``drive`` of the shape itself.
        title: what people call it.

    """

    key: str
    title: str


def groups_at(site: Site, path: Path) -> tuple[Group, ...]:
    """Tell what can be added to the thing at a path."""
    thing = value_at(site, path)
    if isinstance(thing, Site):
        return (Group("devices", "Device"),)
    if isinstance(thing, Command):
        return (Group("arguments", "Argument"),)
    if isinstance(thing, Device):
        three = (
            Group("signals", "Signal"),
            Group("streams", "Camera"),
            Group("commands", "Command"),
        )
        return three if thing.drive is not None else (*three, Group("drive", "Driving"))
    return ()


def with_thing(site: Site, path: Path, key: str, name: str) -> tuple[Site, Path]:
    """Add an empty thing of a person's own name; gives where it stands.

    Raises:
        ConfiguratorError: it has no name.

    """
    if key == "drive":
        # ROS's customary topic for it; the form is shown next.
        drive = Drive(topic="/cmd_vel", max_speed=CAREFUL_SPEED, max_turn=CAREFUL_TURN)
        return with_value(site, (*path, key), drive), (*path, key)
    if not name.strip():
        raise ConfiguratorError("a custom item needs a name")
    name = name.strip()
    mapping = value_at(site, (*path, key))
    assert isinstance(mapping, dict)  # noqa: S101 - `groups_at` names mappings
    word = free_word(word_of(name), mapping)
    # Of the device's own protocol, so that its form has the right fields at once.
    source = new_source(site, path[1]) if len(path) > 1 else RosSource()
    ros = isinstance(source, RosSource)
    pictures = RosSource(type="sensor_msgs/msg/Image") if ros else source
    made: dict[str, Shape] = {
        "devices": Device(name=name),
        "signals": Signal(name=name, source=source),
        "streams": Stream(name=name, source=pictures),
        # Confirmed until a person says otherwise: nothing is known yet of what it moves.
        "commands": Command(name=name, target="", confirm=True),
        "arguments": Argument(type=ArgumentType.NUMBER, field=word, name=name),
    }
    return with_value(site, (*path, key, word), made[key]), (*path, key, word)


# ── taking away ──


def without_things(site: Site, paths: Iterable[Path]) -> Site:
    """Take things out, what driving looked at among them, and devices that this leaves empty."""
    paths = list(paths)
    for path in paths:
        site = remove_value(site, path)
    gone = {f"{path[1]}/{path[3]}" for path in paths if len(path) == 4 and path[0] == "devices"}
    for word in driven_devices(site):
        site = with_value(site, ("devices", word, "drive"), _drive_without(site, word, gone))
    # A dict for a set in order: the steps are the same each time.
    for word in {path[1]: None for path in paths if len(path) > 2 and path[0] == "devices"}:
        device = site.devices.get(word)
        # One with an INDI name or frames says something by itself, even without things in it.
        bare = device and not (device.signals or device.streams or device.commands or device.indi)
        if bare and device and device.drive is None and device.frames is None:
            site = remove_value(site, ("devices", word))
    return site


def _drive_without(site: Site, word: str, gone: set[str]) -> Drive:
    drive = site.devices[word].drive
    assert drive is not None  # noqa: S101 - `driven_devices` says so
    signals = {f"{word}/{name}" for word, device in site.devices.items() for name in device.signals}
    streams = {f"{word}/{name}" for word, device in site.devices.items() for name in device.streams}
    # Only what is taken out now, or went with a device: a mistake of before stays to be seen.
    lost = gone | {
        address
        for address in (drive.picture, drive.position, *drive.stop.confirmed_by)
        if address and address.split("/", 1)[0] not in site.devices
    }
    # What confirms STOP is a signal; a camera of the same name that goes is not meant.
    kept = tuple(
        address for address in drive.stop.confirmed_by if address not in lost or address in signals
    )
    return msgspec.structs.replace(
        drive,
        picture="" if drive.picture in lost - streams else drive.picture,
        position="" if drive.position in lost - signals else drive.position,
        stop=msgspec.structs.replace(drive.stop, confirmed_by=kept),
    )


def free_word(word: str, taken: Iterable[str]) -> str:
    """Give the word, or with a number behind where it is taken."""
    taken = set(taken)
    number, made = 2, word
    while made in taken:
        made, number = f"{word}_{number}", number + 1
    return made
