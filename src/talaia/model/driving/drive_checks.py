"""What must fit in how a device is driven; returns findings, raises nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import (
    Finding,
    at_least,
    check_above,
    finding_of,
    name_fits,
    number_text,
    range_fits,
    topic_fits,
)
from talaia.model.closed_lists import DriveMessage, SignalType
from talaia.model.driving.drive import Keys
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.driving.drive import Drive, DrivenJoint
    from talaia.model.site import Site

__all__ = ["PTZ_AXES", "drive_findings"]

# Of an ONVIF camera, in this order.
PTZ_AXES = ("pan", "tilt", "zoom")
# More joints than the longest arm with its hand; a driving frame carries one number for each.
_MOST_JOINTS = 32


def drive_findings(site: Site, where: str, drive: Drive) -> Iterator[Finding]:
    """Check one device's driving."""
    yield from _topic_findings(where, drive)
    yield from _limit_findings(where, drive)
    if drive.message is DriveMessage.PTZ:
        yield from _sole_findings(site, where, drive)
    if drive.max_reverse is not None:
        yield from at_least(f"{where}.max_reverse", drive.max_reverse, 0)
    # The limits of the safety rules: a description may be stricter, and looser only within these.
    for key, low, high, unit in (
        ("rate", 5, 100, "Hz"),
        ("ttl", 0.05, 0.5, "s"),
        ("zeros_for", 0.5, 10, "s"),
        ("lease", 1, 10, "s"),
    ):
        found = getattr(drive, key)
        if not low <= found <= high:
            yield Finding(
                f"{where}.{key}",
                f"expected {low} to {high} {unit}, found {number_text(found)}",
                "the safety rules allow no more",
            )
    # Of every type, by address; each place below picks its own.
    kinds = {
        f"{device_id}/{signal_id}": signal.type
        for device_id, device in site.devices.items()
        for signal_id, signal in device.signals.items()
    }
    yield from _named_findings(site, where, drive, kinds)
    if drive.message is DriveMessage.KEYS and drive.max_reverse == 0:
        yield Finding(f"{where}.max_reverse", "the key x drives backward", "leave it out")
    yield from _check_keys(f"{where}.keys", drive, kinds)
    for name, joint in drive.joints.items():
        yield from _joint_findings(f"{where}.joints.{name}", joint, kinds)
        if drive.message is DriveMessage.PTZ:
            yield from _axis_findings(f"{where}.joints.{name}", name, joint)


def _sole_findings(site: Site, where: str, drive: Drive) -> Iterator[Finding]:
    """Check that no device before this one turns the same camera: each lease is for one of them."""
    only = next(iter(site.links()), "")
    turned: dict[str, str] = {}
    for device_id, device in site.devices.items():
        if device.drive is None or device.drive.message is not DriveMessage.PTZ:
            continue
        camera = device.connection or only
        if device.drive is drive:
            if camera in turned:
                problem = f"{turned[camera]} turns this camera already"
                yield Finding(where, problem, "leave one of them out: two people could turn it")
            return
        turned[camera] = device_id


def _topic_findings(where: str, drive: Drive) -> Iterator[Finding]:
    """Check that a robot has a topic, and a camera none."""
    if drive.message is DriveMessage.PTZ:
        for key, topic in (("topic", drive.topic), ("stop.topic", drive.stop.topic)):
            if topic:
                yield Finding(f"{where}.{key}", "an ONVIF camera has no topics", "leave it out")
    elif not drive.topic:
        yield Finding(where, "the key 'topic' is missing", "add topic: … (a text)")
    else:
        yield from topic_fits(f"{where}.topic", drive.topic)


def _limit_findings(where: str, drive: Drive) -> Iterator[Finding]:
    """Check that the limits which a message needs are there, and those of another are not."""
    message = drive.message
    turns = message.twists or message is DriveMessage.KEYS
    # Of joints each has its own limit.
    needed = [] if message.jogs else ["max_speed", "max_turn" if turns else "max_steering"]
    for key in needed:
        # How fast a robot may go its owner has to say: none is assumed.
        if getattr(drive, key) == 0:
            problem = f"the key {key!r} is missing, or 0"
            yield Finding(where, problem, f"write {key}: … (a number above 0)")
    for key in (
        "max_speed",
        "max_turn",
        "max_acceleration",
        "max_turn_acceleration",
        "max_steering_speed",
        "max_joint_acceleration",
    ):
        if getattr(drive, key) == 0 and key in ("max_speed", "max_turn"):
            continue
        for finding in check_above(f"{where}.{key}", getattr(drive, key), 0):
            yield finding._replace(remedy="limits have no sign; backward has its own, max_reverse")
    for key in ("max_sideways", "max_steering"):
        yield from at_least(f"{where}.{key}", getattr(drive, key), 0)
    # Wheels that are turned by more roll nowhere.
    if drive.max_steering >= 1.5:
        problem = f"expected an angle below 1.5 rad, found {number_text(drive.max_steering)}"
        yield Finding(f"{where}.max_steering", problem, "it is in radians: 0.5 is some 29°")
    # What another message would need stands for a mistake: it would be silently without effect.
    others = {
        "max_speed": not message.jogs,
        "max_sideways": message.twists,
        "max_turn": turns,
        "max_steering": message.steers,
        "joints": message.jogs,
    }
    for key, fits in others.items():
        if getattr(drive, key) and not fits:
            yield Finding(f"{where}.{key}", f"{message} has no room for it", "leave it out")
    if message.jogs and not drive.joints:
        remedy = "add joints: {name of a joint: {max_speed: 0.2}}"
        yield Finding(where, "the key 'joints' is missing", remedy)
    if len(drive.joints) > _MOST_JOINTS:
        problem = f"expected at most {_MOST_JOINTS} joints, found {len(drive.joints)}"
        yield Finding(f"{where}.joints", problem, "drive them as devices of their own")


def _joint_findings(
    where: str, joint: DrivenJoint, kinds: Mapping[str, SignalType]
) -> Iterator[Finding]:
    if joint.name:
        yield from name_fits(f"{where}.name", joint.name)
    yield from check_above(f"{where}.max_speed", joint.max_speed, 0)
    yield from range_fits(where, joint.minimum, joint.maximum)
    yield from _number_named(f"{where}.position", joint.position, kinds)
    if not joint.position and (joint.minimum is not None or joint.maximum is not None):
        problem = "an end holds only where it is known how the joint stands"
        yield Finding(where, problem, "name its signal: position: device/signal")


def _axis_findings(where: str, name: str, joint: DrivenJoint) -> Iterator[Finding]:
    """Check what is a camera's own: which axes it has, and that it knows their ends itself."""
    if name not in PTZ_AXES:
        yield Finding(where, f"{name!r} is no axis of a camera", f"write: {', '.join(PTZ_AXES)}")
    if joint.max_speed > 1:
        problem = f"expected a share of the camera's fastest, found {number_text(joint.max_speed)}"
        yield Finding(f"{where}.max_speed", problem, "write 1 for as fast as it can")
    if joint.position or joint.slides:
        key = "position" if joint.position else "slides"
        yield Finding(f"{where}.{key}", "a camera knows its own ends", "leave it out")


def _named_findings(
    site: Site, where: str, drive: Drive, kinds: Mapping[str, SignalType]
) -> Iterator[Finding]:
    """Check what driving names elsewhere in the description."""
    if drive.stop.topic and drive.message is not DriveMessage.PTZ:
        yield from topic_fits(f"{where}.stop.topic", drive.stop.topic)
    yield from check_above(f"{where}.stop.below", drive.stop.below, 0)
    for index, address in enumerate(drive.stop.confirmed_by):
        at = f"{where}.stop.confirmed_by[{index}]"
        # There, but no number: another name would lead astray.
        if address in kinds and kinds[address] is not SignalType.NUMBER:
            problem = f"{address!r} is of type {kinds[address]}, and a number belongs here"
            yield Finding(at, problem, "name a number that is 0 while it stands, as its speed")
        elif address not in kinds:
            known = [address for address, kind in kinds.items() if kind is SignalType.NUMBER]
            yield finding_of(UnknownWord(at, "number signal", address, known))
    streams = [
        f"{device_id}/{stream_id}"
        for device_id, device in site.devices.items()
        for stream_id in device.streams
    ]
    if drive.picture and drive.picture not in streams:
        yield finding_of(UnknownWord(f"{where}.picture", "stream", drive.picture, streams))
    if drive.position and kinds.get(drive.position) is not SignalType.POSITION:
        known = [address for address, kind in kinds.items() if kind is SignalType.POSITION]
        yield finding_of(UnknownWord(f"{where}.position", "position signal", drive.position, known))


def _check_keys(where: str, drive: Drive, kinds: Mapping[str, SignalType]) -> Iterator[Finding]:
    keys = drive.keys
    if keys != Keys() and drive.message is not DriveMessage.KEYS:
        yield Finding(where, f"{drive.message} takes no characters", "leave it out")
    for name, step, limit in (
        ("speed_step", keys.speed_step, drive.max_speed),
        ("turn_step", keys.turn_step, drive.max_turn),
    ):
        # Left out, a press is one character and nothing is counted.
        if step is None:
            continue
        yield from check_above(f"{where}.{name}", step, 0)
        if step > limit:
            yield Finding(
                f"{where}.{name}",
                f"one character is {step:g}, more than the limit of {limit:g}",
                "no character could be sent; raise the limit if the robot may go as fast",
            )
    for name, address in (("speed", keys.speed), ("turn", keys.turn)):
        yield from _number_named(f"{where}.{name}", address, kinds)


def _number_named(where: str, address: str, kinds: Mapping[str, SignalType]) -> Iterator[Finding]:
    if address and kinds.get(address) is not SignalType.NUMBER:
        known = [address for address, kind in kinds.items() if kind is SignalType.NUMBER]
        yield finding_of(UnknownWord(where, "number signal", address, known))
