"""Names that say no more than people need: no robot's name at each device, and none twice. Pure."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import RosSource
from talaia.model.discovery.device_places import robot_namespace, spoken_space
from talaia.model.discovery.ros_units import readable_name
from talaia.model.discovery.rules.spoken_names import spoken_name
from talaia.model.discovery.topic_words import last_part

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Command, Device, Signal

__all__ = ["with_plain_names"]


def with_plain_names(found: Found, devices: Mapping[str, Device]) -> dict[str, Device]:
    """Give devices, by word, with names as people say them; their words stay as they are."""
    # Of several robots the namespace is what tells which: then there is none of all.
    space = robot_namespace(found.topics)
    said = spoken_space(space) if space else ""
    robot = f"{said[:1].upper()}{said[1:]} " if said else ""
    # Drivers that say themselves what they are (INDI, Alpaca, ONVIF) have names by people.
    theirs = {device.word for device in found.devices if device.described is not None}
    spoken = {
        word: device if word in theirs else _spoken_device(device)
        for word, device in devices.items()
    }
    # Of `spot_ros2` of the robot spot its first word is left out, and the second said.
    short = {word: _without_robot(device.name, robot) for word, device in devices.items()}
    plain = {word: name if word in theirs else spoken_name(name) for word, name in short.items()}
    # Two that would be called the same keep what tells them apart.
    count = Counter(plain.values())
    names = {word: plain[word] if count[plain[word]] == 1 else spoken[word].name for word in plain}
    count = Counter(names.values())
    return {
        word: msgspec.structs.replace(
            device,
            name=names[word] if count[names[word]] == 1 else f"{names[word]} ({word})",
            signals=_told_apart(device.signals),
            commands=_commands_apart(device.commands),
        )
        for word, device in spoken.items()
    }


def _spoken_device(device: Device) -> Device:
    return msgspec.structs.replace(
        device,
        name=spoken_name(device.name),
        signals={
            word: msgspec.structs.replace(one, name=spoken_name(one.name, one.unit))
            for word, one in device.signals.items()
        },
        commands={word: _spoken_command(one) for word, one in device.commands.items()},
        streams={
            word: msgspec.structs.replace(one, name=spoken_name(one.name))
            for word, one in device.streams.items()
        },
    )


def _spoken_command(command: Command) -> Command:
    arguments = {
        word: msgspec.structs.replace(one, name=spoken_name(one.name or word, one.unit))
        if one.name
        else one
        for word, one in command.arguments.items()
    }
    # One that sets a single value has its unit in its own name, too.
    unit = next((one.unit for one in arguments.values()), "") if len(arguments) == 1 else ""
    name = spoken_name(command.name, unit)
    return msgspec.structs.replace(command, name=name, arguments=arguments)


def _without_robot(name: str, robot: str) -> str:
    rest = name.removeprefix(robot)
    return rest[:1].upper() + rest[1:]


def _told_apart(signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """Add to each name that several signals of a device have what tells them apart."""
    made = dict(signals)
    for name, count in Counter(signal.name for signal in signals.values()).items():
        alike = {word: one for word, one in signals.items() if one.name == name}
        sources = [one.source for one in alike.values() if isinstance(one.source, RosSource)]
        if count == 1 or len(sources) != count or not all(one.topic for one in sources):
            continue
        # The last part of its topic says most; of one topic it is the unit, or the field.
        labels = (
            [readable_name(last_part(one.topic)).lower() for one in sources],
            [one.unit or "state" for one in alike.values()],
            [one.field for one in sources],
        )
        chosen = next((some for some in labels if len(set(some)) == count), labels[0])
        for word, label in zip(alike, chosen, strict=True):
            made[word] = msgspec.structs.replace(alike[word], name=f"{name} ({label})")
    return made


def _commands_apart(commands: Mapping[str, Command]) -> dict[str, Command]:
    """Add to each name that several commands of a device have what tells their targets apart."""
    made = dict(commands)
    for name, count in Counter(command.name for command in commands.values()).items():
        if count == 1:
            continue
        alike = {word: one for word, one in commands.items() if one.name == name}
        parts = {word: one.target.strip("/").split("/") for word, one in alike.items()}
        for columns in zip(*parts.values(), strict=False):
            if len(set(columns)) == count:
                for word, part in zip(alike, columns, strict=True):
                    said = f"{name} ({readable_name(part).lower()})"
                    made[word] = msgspec.structs.replace(alike[word], name=said)
                break
    return made
