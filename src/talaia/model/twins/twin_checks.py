"""Whether a twin can be run beside the device that it is of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding
from talaia.model.connection import Ros2Connection, RosSource
from talaia.model.site import DriveMessage
from talaia.model.twins.twin import MODES
from talaia.model.twins.twin_topics import SIGNAL_PARTS, position_source, signal_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Device, Site
    from talaia.model.twins.twin import Twin

__all__ = ["twin_findings"]

_BOUNDS = (
    ("friction", 0.0, 1000.0, "N per m/s"),
    ("track_width", 0.01, 10.0, "m"),
    ("follow_rate", 0.05, 20.0, "1/s"),
    ("reset_beyond", 0.01, 100.0, "m"),
    ("reset_turn", 0.01, 3.14, "rad"),
    ("reset_after", 0.0, 60.0, "s"),
)


def twin_findings(site: Site) -> Iterator[Finding]:
    """List what keeps twins from being run, one after the other."""
    of: dict[str, str] = {}
    for name, device in site.devices.items():
        if (twin := device.twin) is None:
            continue
        where = f"$.devices.{name}.twin"
        for key, low, high, unit in _BOUNDS:
            found = getattr(twin, key)
            # Written so that NaN, which is in no order, is refused as well.
            if not low <= found <= high:
                yield Finding(
                    f"{where}.{key}", f"expected {low:g} to {high:g} {unit}, found {found:g}"
                )
        if twin.of in of:
            yield Finding(
                f"{where}.of",
                f"{twin.of} has a twin already: {of[twin.of]}",
                "a device has one twin: leave one of them out",
            )
        of[twin.of] = name
        yield from _robot_findings(site, where, name, twin)
        yield from _signal_findings(site, f"$.devices.{name}", name, device)


def _robot_findings(site: Site, where: str, name: str, twin: Twin) -> Iterator[Finding]:
    real, own = site.devices.get(twin.of), site.devices[name]
    if real is None or real.drive is None:
        driven = ", ".join(key for key, one in site.devices.items() if one.drive is not None)
        known = f"one of: {driven}" if driven else "describe the drive of a device"
        yield Finding(f"{where}.of", f"there is no driven device {twin.of!r}", known)
        return
    link = site.links().get(site.connection_of(twin.of))
    if not isinstance(link, Ros2Connection):
        yield Finding(f"{where}.of", f"{twin.of} is not reached by ROS 2, and a twin speaks it")
        return
    if site.connection_of(name) != site.connection_of(twin.of):
        yield Finding(where, f"it is not reached by the connection of {twin.of}", "name the same")
    if own.drive is not None:
        yield Finding(
            f"$.devices.{name}.drive",
            f"a twin is driven under the lease of {twin.of}",
            "leave drive out",
        )
    if real.drive.message not in (DriveMessage.TWIST, DriveMessage.TWIST_STAMPED):
        yield Finding(
            f"{where}.of", f"{twin.of} is driven by {real.drive.message}: a twin follows a Twist"
        )
    if position_source(site, twin.of) is None:
        yield Finding(
            f"{where}.of",
            f"where {twin.of} is, is not read from a nav_msgs/msg/Odometry",
            f"name such a signal: devices.{twin.of}.drive.position",
        )


def _signal_findings(site: Site, where: str, name: str, device: Device) -> Iterator[Finding]:
    for key in ("pose", "mode", "pose_error"):
        signal = device.signals.get(key)
        expected = f"/{name}/{SIGNAL_PARTS[key][0]}"
        source = None if signal is None else signal.source
        if isinstance(source, RosSource) and source.topic == expected:
            continue
        yield Finding(
            f"{where}.signals.{key}",
            f"the gateway has to read {key} of a twin on {expected}",
            signal_text(name, key),
        )
    mode = device.signals.get("mode")
    if mode is not None and mode.states != MODES:
        yield Finding(f"{where}.signals.mode.states", f"a twin's modes are {', '.join(MODES)}")
