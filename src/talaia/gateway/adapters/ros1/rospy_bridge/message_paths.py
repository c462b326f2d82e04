"""Fields of ROS 1 messages by path, and messages' types by name."""

# ruff: noqa: ANN401 - rospy ships no types
from __future__ import annotations

from typing import TYPE_CHECKING

import rospy
from roslib import message as ros_types  # type: ignore[import-not-found]

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


def fill_message(message: Any, fields: dict[str, Any]) -> Any:
    """Set fields by path; `ValueError` tells which does not fit."""
    for path, value in fields.items():
        steps = _steps_of(path)
        try:
            at = message
            for step in steps[:-1]:
                at = _value_at(at, step)
            last = steps[-1]
            if last.startswith("["):
                # Only what is there is set: genpy makes lists of fixed length full, others empty.
                index = int(last[1:-1])
                at[index] = _fitting_value(at[index], value)
            else:
                setattr(at, last, _fitting_value(getattr(at, last), value))
        except (AttributeError, IndexError, TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"field {path!r}: {error}") from error
    return message


def number_at(message: Any, path: str) -> float:
    """Read a number by path."""
    for step in _steps_of(path):
        message = _value_at(message, step)
    return float(message)


def class_of(name: str, find: Callable[[str], Any]) -> Any:
    """Import a type ``package/middle/Name``; ROS 1 itself knows no middle part."""
    package, _, short = name.split("/")
    found = find(package + "/" + short)
    if found is None:
        raise LookupError(name)
    return found


def message_class(name: str) -> Any:
    """Find the class of a message, or None."""
    return ros_types.get_message_class(name)


def service_class(name: str) -> Any:
    """Find the class of a service, or None."""
    return ros_types.get_service_class(name)


def _steps_of(path: str) -> list[str]:
    return path.replace("[", ".[").split(".")


def _value_at(holder: Any, step: str) -> Any:
    return holder[int(step[1:-1])] if step.startswith("[") else getattr(holder, step)


def _fitting_value(now: Any, value: Any) -> Any:
    """Give the value in the type that stands there now; never a silent cut."""
    # genpy takes anything and fails only when it serializes, with a word of struct's. And bool
    # goes first: in Python it is an int.
    if isinstance(now, bool):
        if not isinstance(value, bool):
            raise TypeError(f"expected true or false, found {value!r}")
        return value
    if isinstance(now, str):
        return value if isinstance(value, str) else str(value)
    if isinstance(value, str):
        raise TypeError(f"expected a number, found {value!r}")
    if isinstance(now, int):
        if int(value) != value:
            raise ValueError(f"expected a whole number, found {value!r}")
        return int(value)
    if isinstance(now, (rospy.Time, rospy.Duration)):
        return type(now).from_sec(float(value))
    return float(value)
