"""Velocities as fields of the message a robot listens to. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.velocity_demand import STILL, VelocityDemand
from talaia.model.site import DriveMessage

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Drive
    from talaia.wire.frames import Scalar

__all__ = ["guard_mark", "stamp_fields", "steering_fields", "velocity_fields", "zero_of"]


def zero_of(drive: Drive) -> VelocityDemand:
    """Give the demand that stops a device of which nothing else is known."""
    return STILL._replace(joints=(0.0,) * len(drive.joints))


def velocity_fields(drive: Drive, demand: VelocityDemand, key: str = "") -> dict[str, Scalar]:
    """Give the fields by path of a demand, or of the character that stands for it.

    A stamp stays 0: the robot takes that for its own now, and nobody else's clock can delay it.
    """
    linear, angular, lateral, steering, speeds = demand
    match drive.message:
        case DriveMessage.KEYS:
            return {"data": key}
        # Fields that are not named stay 0.
        case DriveMessage.TWIST:
            return {"linear.x": linear, **_sideways(drive, "", lateral), "angular.z": angular}
        case DriveMessage.TWIST_STAMPED:
            aside = _sideways(drive, "twist.", lateral)
            return {"twist.linear.x": linear, **aside, "twist.angular.z": angular}
        case DriveMessage.ACKERMANN:
            return {"speed": linear, "steering_angle": steering}
        case DriveMessage.ACKERMANN_STAMPED:
            return {"drive.speed": linear, "drive.steering_angle": steering}
        case DriveMessage.JOINT_JOG:
            names: dict[str, Scalar] = {
                f"joint_names[{index}]": name for index, name in enumerate(drive.joints)
            }
            return names | {f"velocities[{index}]": speed for index, speed in enumerate(speeds)}
        case DriveMessage.JOINT_VELOCITIES:
            return {f"data[{index}]": speed for index, speed in enumerate(speeds)}
        case DriveMessage.PTZ:
            return {}  # No message of ROS: `check` refuses it there.


def steering_fields(drive: Drive) -> list[str]:
    """Name the fields that a zero leaves as they are: see `VelocityLimiter.zero`."""
    match drive.message:
        case DriveMessage.ACKERMANN:
            return ["steering_angle"]
        case DriveMessage.ACKERMANN_STAMPED:
            return ["drive.steering_angle"]
        case _:
            return []


def stamp_fields(drive: Drive, now_ns: Callable[[], int]) -> dict[str, Scalar]:
    """Give the stamp of a message whose listeners drop what has none.

    The node's own clock is asked for it, and only then: nothing else of driving needs it.
    """
    if drive.message is not DriveMessage.JOINT_JOG:
        return {}
    # MoveIt's servo takes a stamp of 0 for a command of 1970.
    seconds, rest = divmod(now_ns(), SECOND)
    return {"header.stamp.sec": seconds, "header.stamp.nanosec": rest}


def guard_mark(drive: Drive) -> dict[str, Scalar]:
    """Give values, of bytes that are not 0, for what the zero of a lost gateway leaves as it was.

    See `guard_velocity`: the angle of steered wheels, and the stamp of a joint jog.
    """
    if drive.message is DriveMessage.JOINT_JOG:
        return {"header.stamp.sec": 0x01010101, "header.stamp.nanosec": 0x01010101}
    return dict.fromkeys(steering_fields(drive), 0.1)


def _sideways(drive: Drive, path: str, lateral: float) -> dict[str, Scalar]:
    return {f"{path}linear.y": lateral} if drive.max_sideways else {}
