"""What the ROS 1 node is asked to get ready for a site, as frames. Pure.

The node knows publications and calls by names of ours: ``drive DEVICE``, ``stop DEVICE`` and a
command's address. `rospy_bridge.main` does what the frames ask for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.adapters.velocity import steering_fields, velocity_fields, zero_of
from talaia.gateway.driving.drive_keys import HALT
from talaia.model.site import CommandKind, DriveMessage

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.site import Command, Device, Drive

    Frame = dict[str, object]

__all__ = ["command_frames", "site_frames"]

_BOOL = "std_msgs/msg/Bool"


def site_frames(devices: Mapping[str, Device]) -> Iterator[Frame]:
    """Ask for all that is published and called."""
    for device_id, device in devices.items():
        if device.drive is not None:
            yield from _drive_frames(device_id, device.drive)
        yield from command_frames(device_id, device)


def command_frames(device_id: str, device: Device) -> Iterator[Frame]:
    """Ask for what a device's commands need; again, to connect to them anew."""
    for name, command in device.commands.items():
        frame = _command_frame(f"{device_id}/{name}", command)
        if frame is not None:
            yield frame


def _drive_frames(device_id: str, rule: Drive) -> Iterator[Frame]:
    yield {
        "op": "voice",
        "id": f"drive {device_id}",
        "topic": rule.topic,
        "type": rule.message.value,
        # The node says it by itself when nobody speaks: also when this process is gone.
        "zero": velocity_fields(rule, zero_of(rule), HALT),
        # Steered wheels stay as they stand.
        "kept": steering_fields(rule),
        # Characters may add up: none takes another's place before it is sent.
        "deep": 20 if rule.message is DriveMessage.KEYS else 1,
    }
    if rule.stop.topic:
        yield {
            "op": "voice",
            "id": f"stop {device_id}",
            "topic": rule.stop.topic,
            "type": _BOOL,
            # A node of the robot that starts later hears of a STOP, too.
            "latch": True,
        }


def _command_frame(address: str, command: Command) -> Frame | None:
    match command.kind:
        case CommandKind.TOPIC:
            return {
                "op": "voice",
                "id": address,
                "topic": command.target,
                "type": command.type,
                "deep": 10,
            }
        case CommandKind.ACTION:
            return {
                "op": "action",
                "id": address,
                "name": command.target,
                "type": command.type,
                "progress": command.progress,
                "progress_end": command.progress_end,
            }
        case CommandKind.SERVICE:
            return {"op": "service", "id": address, "name": command.target, "type": command.type}
        case _:
            # Parameters are set by name, without anything to get ready.
            return None
