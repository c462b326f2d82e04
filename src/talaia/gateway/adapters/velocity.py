"""Velocities as fields of the message a robot listens to. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.site import DriveMessage

if TYPE_CHECKING:
    from talaia.model.site import Drive
    from talaia.wire.frames import Scalar

__all__ = ["velocity_fields"]


def velocity_fields(
    drive: Drive, linear: float, angular: float, key: str = ""
) -> dict[str, Scalar]:
    """Give the fields by path of a velocity (m/s, rad/s), or of the character that stands for it.

    A stamp stays 0: the robot takes that for its own now, and nobody else's clock can delay it.
    """
    match drive.message:
        case DriveMessage.KEYS:
            return {"data": key}
        # Only forward speed and turning: fields that are not named stay 0.
        case DriveMessage.TWIST:
            return {"linear.x": linear, "angular.z": angular}
        case DriveMessage.TWIST_STAMPED:
            return {"twist.linear.x": linear, "twist.angular.z": angular}
