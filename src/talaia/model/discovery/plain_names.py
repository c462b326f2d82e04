"""Names that say no more than people need: no robot's name at each device, and none twice. Pure."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import RosSource
from talaia.model.discovery.device_places import robot_namespace
from talaia.model.discovery.ros_units import readable_name
from talaia.model.discovery.topic_words import last_part

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.discovery.probe_report import Found
    from talaia.model.site import Device, Signal

__all__ = ["with_plain_names"]


def with_plain_names(found: Found, devices: Mapping[str, Device]) -> dict[str, Device]:
    """Give devices, by word, with names as people say them; their words stay as they are."""
    # Of several robots the namespace is what tells which: then there is none of all.
    space = robot_namespace(found.topics)
    robot = f"{readable_name(space)} " if space else ""
    plain = {word: _without_robot(device.name, robot) for word, device in devices.items()}
    # Two that would be called the same keep what tells them apart.
    count = Counter(plain.values())
    return {
        word: msgspec.structs.replace(
            device,
            name=plain[word] if count[plain[word]] == 1 else device.name,
            signals=_told_apart(device.signals),
        )
        for word, device in devices.items()
    }


def _without_robot(name: str, robot: str) -> str:
    rest = name.removeprefix(robot)
    return rest[:1].upper() + rest[1:]


def _told_apart(signals: Mapping[str, Signal]) -> dict[str, Signal]:
    """Add the last part of its topic to each name that several signals of a device have."""
    count = Counter(signal.name for signal in signals.values())
    made = dict(signals)
    for word, signal in signals.items():
        if count[signal.name] > 1 and isinstance(signal.source, RosSource) and signal.source.topic:
            part = readable_name(last_part(signal.source.topic)).lower()
            made[word] = msgspec.structs.replace(signal, name=f"{signal.name} ({part})")
    return made
