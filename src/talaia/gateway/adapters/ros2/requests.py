"""Messages to the robot: fields by path, demands in the forms robots listen to."""

from __future__ import annotations

import re
from array import array
from importlib import import_module
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from talaia.gateway.errors import FieldError, TypeMissing
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.samples.field_paths import parse_path
from talaia.model.site import Drive, DriveMessage
from talaia.wire.frames import CommandPhase, Scalar

if TYPE_CHECKING:
    from talaia.gateway.velocity_demand import VelocityDemand

__all__ = ["class_of", "fill", "outcome_of", "velocity_message"]

# As rclpy names the type of a list: sequence<rcl_interfaces/Parameter>, sequence<double, 4>.
_LIST_OF = re.compile(
    r"sequence<(?:(?P<package>\w+)/(?P<name>\w+)|(?P<plain>[\w ]+(?:<\d+>)?))"
    r"(?:, (?P<bound>\d+))?>\Z"
)
MAX_GROWN = 64


def class_of(type_name: str, used_by: str) -> Any:  # noqa: ANN401 - ROS's packages are untyped
    """Import the Python class of a ROS type.

    Raises:
        TypeMissing: its package is not installed, or has no such type.

    """
    package, middle, name = type_name.split("/")
    try:
        return getattr(import_module(f"{package}.{middle}"), name)
    except (ImportError, AttributeError) as error:
        raise TypeMissing(type_name, used_by) from error


def fill(message: Any, fields: dict[str, Scalar]) -> None:  # noqa: ANN401
    """Set fields of a message by path, as the types the message has there.

    Raises:
        FieldError: no such field, or a value that does not fit it.

    """
    for path, value in fields.items():
        steps = parse_path(path)
        try:
            at, last = message, steps[-1]
            for step, following in pairwise(steps):
                inner = getattr(at, step) if isinstance(step, str) else at[step]
                if isinstance(step, str) and isinstance(following, int):
                    _grow(at, step, inner, following)
                at = inner
            if isinstance(last, str):
                setattr(at, last, _as(getattr(at, last), value, path))
            else:
                at[last] = _as(at[last], value, path)
        except (AttributeError, IndexError, TypeError) as error:
            raise FieldError(path, f"the message has no such field ({error})") from error
        except (AssertionError, ValueError, OverflowError) as error:
            raise FieldError(path, f"{value!r} does not fit ({error})") from error


def _grow(owner: Any, name: str, held: Any, index: int) -> None:  # noqa: ANN401
    """Make a list long enough for an index: a request starts with empty ones."""
    if not isinstance(held, list | array) or index < len(held):
        return
    found = _LIST_OF.match(owner.get_fields_and_field_types().get(name, ""))
    if found is None or index >= min(MAX_GROWN, int(found["bound"] or MAX_GROWN)):
        return
    missing = index + 1 - len(held)
    if found["name"]:
        kind = class_of(f"{found['package']}/msg/{found['name']}", name)
        held.extend(kind() for _ in range(missing))
    elif (plain := found["plain"]).startswith(("string", "wstring")):
        held.extend([""] * missing)
    else:
        held.extend([False if plain == "boolean" else 0] * missing)


def _as(now: object, value: Scalar, path: str) -> Scalar:
    """Give the value in the type that the field holds now; never a silent cut."""
    if isinstance(now, bool):
        if not isinstance(value, bool):
            raise FieldError(path, f"expected true or false, found {value!r}")
        return value
    if isinstance(now, str):
        return value if isinstance(value, str) else str(value)
    if isinstance(value, str):
        raise FieldError(path, f"expected a number, found {value!r}")
    if isinstance(now, int):
        if int(value) != value:
            raise FieldError(path, f"expected a whole number, found {value!r}")
        return int(value)
    return float(value)


def outcome_of(response: object) -> CommandOutcome:
    """Read a service's answer: ``success`` and ``message`` where it has them.

    Setting parameters answers with a ``result`` (or with one for each) of ``successful`` and
    ``reason``.
    """
    said = getattr(response, "message", "")
    message = said if isinstance(said, str) else ""
    good = getattr(response, "success", True) is not False
    results = getattr(response, "results", None) or [getattr(response, "result", None)]
    for result in results:
        reason = getattr(result, "reason", None)
        if isinstance(reason, str):
            message = message or reason
            good = good and getattr(result, "successful", True) is not False
    if not good:
        return CommandOutcome(CommandPhase.FAILED, message or "the robot says it did not succeed")
    return CommandOutcome(CommandPhase.SUCCEEDED, message)


def velocity_message(drive: Drive, message: Any, demand: VelocityDemand, key: str = "") -> Any:  # noqa: ANN401
    """Set a demand in a message of the drive's type, and give it.

    A stamp stays 0: the robot takes that for its own now, and nobody else's clock can delay it.
    """
    linear, angular, lateral, steering, speeds = demand
    match drive.message:
        case DriveMessage.KEYS:
            message.data = key
        case DriveMessage.TWIST | DriveMessage.TWIST_STAMPED:
            stamped = drive.message is DriveMessage.TWIST_STAMPED
            twist = message.twist if stamped else message
            twist.linear.x, twist.linear.y, twist.angular.z = linear, lateral, angular
        case DriveMessage.ACKERMANN | DriveMessage.ACKERMANN_STAMPED:
            stamped = drive.message is DriveMessage.ACKERMANN_STAMPED
            steered = message.drive if stamped else message
            steered.speed, steered.steering_angle = linear, steering
        case DriveMessage.JOINT_JOG:
            message.joint_names, message.velocities = list(drive.joints), list(speeds)
        case DriveMessage.JOINT_VELOCITIES:
            message.data = list(speeds)
        case DriveMessage.PTZ:
            pass  # No message of ROS: `check` refuses it there.
    return message
