"""By which topics and frames a twin is reached: all of them stand below its own name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import RosSource
from talaia.model.site import Drive, DriveMessage, Keys, Stop

if TYPE_CHECKING:
    from talaia.model.site import Site
    from talaia.model.twins.twin import Twin

__all__ = [
    "ODOMETRY",
    "SIGNAL_PARTS",
    "base_frame",
    "device_text",
    "position_source",
    "signal_text",
    "twin_drive",
    "twins_of",
    "velocity_topic",
]

ODOMETRY = "nav_msgs/msg/Odometry"
_FLOAT = "std_msgs/msg/Float64"
# Of each signal: the end of its topic, its type, the field, and the rest of its description.
SIGNAL_PARTS: dict[str, tuple[str, str, str, str]] = {
    "pose": (
        "odom",
        ODOMETRY,
        "pose.pose.position",
        "name: Position of the twin, role: none, type: position, frame: local, "
        "yaw_from: pose.pose.orientation, max_rate: 10, primary: false",
    ),
    "speed": (
        "odom",
        ODOMETRY,
        "twist.twist.linear.x",
        "name: Speed of the twin, role: none, unit: m/s, max_rate: 10, primary: false",
    ),
    "mode": (
        "mode",
        "std_msgs/msg/UInt8",
        "data",
        "name: Twin, type: state, states: [waiting, following, rehearsing]",
    ),
    "pose_error": ("pose_error", _FLOAT, "data", "name: Pose error, unit: m, max_rate: 10"),
    "heading_error": (
        "heading_error",
        _FLOAT,
        "data",
        "name: Heading error, unit: rad, max_rate: 10",
    ),
    "speed_error": ("speed_error", _FLOAT, "data", "name: Speed error, unit: m/s, max_rate: 10"),
    "resets": (
        "resets",
        "std_msgs/msg/UInt32",
        "data",
        "name: Resets of the twin, decimals: 0, primary: false",
    ),
}


def velocity_topic(name: str) -> str:
    """Name the topic on which the twin alone is driven; the gateway alone publishes there."""
    return f"/{name}/cmd_vel"


def base_frame(name: str) -> str:
    """Name the frame of the twin's body; its parent is the odometry frame of the robot."""
    return f"{name}/base_link"


def twins_of(site: Site) -> dict[str, tuple[str, Twin]]:
    """Give the twins of a site by the device that each is of: the twin's name, and the twin."""
    return {
        device.twin.of: (name, device.twin)
        for name, device in site.devices.items()
        if device.twin is not None
    }


def twin_drive(real: Drive, name: str) -> Drive:
    """Give how a twin is driven: as its device, on a topic of its own and without a STOP of it."""
    return msgspec.structs.replace(
        real,
        topic=velocity_topic(name),
        message=DriveMessage.TWIST,
        keys=Keys(),
        # The simulated vehicle has wheels that roll forward.
        max_sideways=0.0,
        # STOP is the robot's: nothing of it may depend on the twin.
        stop=Stop(),
        picture="",
        position=f"{name}/pose",
    )


def position_source(site: Site, device: str) -> RosSource | None:
    """Find the odometry by which a twin knows where its device is; none where there is none."""
    described = site.devices.get(device)
    if described is None or described.drive is None:
        return None
    signal = site.signal(described.drive.position)
    source = None if signal is None else signal.source
    return source if isinstance(source, RosSource) and source.type == ODOMETRY else None


def signal_text(name: str, key: str) -> str:
    """Write a twin's signal as it stands in a description."""
    topic, kind, field, rest = SIGNAL_PARTS[key]
    source = f"{{topic: /{name}/{topic}, type: {kind}, field: {field}}}"
    return f"write: {key}: {{{rest}, source: {source}}}"


def device_text(name: str, of: str) -> str:
    """Write the device of a twin as it stands below ``devices`` in a description."""
    lines = [f"  {name}:", "    name: Digital twin", "    kind: vehicle", f"    twin: {{of: {of}}}"]
    lines.append("    signals:")
    lines += [f"      {signal_text(name, key).removeprefix('write: ')}" for key in SIGNAL_PARTS]
    lines += [
        "    commands:",
        "      follow:",
        "        name: Follow the robot again",
        f"        target: /{name}/follow",
        "        type: std_srvs/srv/Trigger",
    ]
    return "\n".join(lines) + "\n"
