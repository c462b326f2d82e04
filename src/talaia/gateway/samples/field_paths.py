"""From a raw message to a signal's value: paths are compiled once, then only followed."""

from __future__ import annotations

import math
import re
from operator import attrgetter
from typing import TYPE_CHECKING, SupportsFloat, cast

from talaia.gateway.errors import FieldError
from talaia.model.connection import RosSource, source_as
from talaia.model.site import PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Signal

__all__ = [
    "MAX_TEXT",
    "compile_getter",
    "number_of",
    "parse_path",
    "reader_of",
    "text_of",
    "yaw_of",
]

MAX_TEXT = 2000
_STEP = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)|\[(\d{1,6})\]|(\.)")


def parse_path(path: str) -> tuple[str | int, ...]:
    """Cut ``pose.covariance[0]`` into names and indexes.

    Raises:
        FieldError: not the path of a field.

    """
    steps: list[str | int] = []
    at, name_wanted = 0, True
    while at < len(path):
        match = _STEP.match(path, at)
        if match is None or bool(match[1]) is not name_wanted:
            raise FieldError(path, "is not the path of a field; write it as pose.x or a[0]")
        if match[1]:
            steps.append(match[1])
        elif match[2]:
            steps.append(int(match[2]))
        name_wanted = bool(match[3])
        at = match.end()
    if name_wanted:
        raise FieldError(path, "is not the path of a field; write it as pose.x or a[0]")
    return tuple(steps)


def compile_getter(path: str) -> Callable[[object], object]:
    """Compile a path to a function from message to field.

    The function raises `FieldError` when the message has no such field.
    """
    steps = parse_path(path)
    follow: Callable[[object], object]
    if all(isinstance(step, str) for step in steps):
        follow = attrgetter(path)
    else:

        def follow(message: object) -> object:
            for step in steps:
                if isinstance(step, str):
                    message = getattr(message, step)
                else:
                    message = cast("list[object]", message)[step]
            return message

    def get(message: object) -> object:
        try:
            return follow(message)
        except AttributeError as error:
            raise FieldError(path, f"the message has no such field ({error})") from error
        except (IndexError, TypeError) as error:
            raise FieldError(path, f"there is no such element ({error})") from error

    return get


def number_of(value: object, path: str = "", states: tuple[str, ...] = ()) -> float:
    """Give a field's value as a number: a truth as 0 or 1, a state's word as its position.

    Raises:
        FieldError: a list, a text that is no number, or a nested message.

    """
    if isinstance(value, str):
        if value in states:
            return float(states.index(value))
        try:
            return float(value)
        except ValueError:
            raise FieldError(path, f"expected a number, found the text {value[:40]!r}") from None
    if isinstance(value, bytes) and len(value) == 1:  # how rclpy gives a single byte
        return float(value[0])
    if getattr(value, "size", 1) != 1 or isinstance(value, list | tuple | bytes):
        raise FieldError(path, f"is a list; say which element is meant: {path}[0]")
    try:
        return float(cast("SupportsFloat", value))
    except (TypeError, ValueError, OverflowError):
        raise FieldError(path, f"expected a number, found {type(value).__name__}") from None


def text_of(value: object) -> str:
    """Give a field's value as a text that fits the wire."""
    text = value if isinstance(value, str) else str(value)
    # A lone surrogate cannot be written as UTF-8, and one bad text would spoil its whole batch.
    return text.encode("utf-8", "replace").decode()[:MAX_TEXT]


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """Give the yaw (rad, counter-clockwise) of a quaternion, as REP-103 has it."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def reader_of(signal: Signal) -> Callable[[object], tuple[float, ...]]:
    """Compile a signal to a function from message to its numbers, one for each of `parts_of`.

    Texts are read by `text_of`; a signal with ``source.name`` by the adapter's own table.
    """
    source = source_as(signal.source, RosSource)
    if signal.type is SignalType.POSITION:
        if signal.frame is PositionFrame.WGS84:
            return _wgs84(source.field)
        return _local(source.field, signal.yaw_from)
    path, scale, states = source.field, signal.scale, signal.states
    get = compile_getter(path)

    def read(message: object) -> tuple[float, ...]:
        value = get(message)
        if type(value) is float:  # by far the most common, and worth a shorter way
            return (value * scale,)
        return (number_of(value, path, states) * scale,)

    return read


def _child_getters(path: str, *names: str) -> tuple[Callable[[object], object], ...]:
    return tuple(compile_getter(f"{path}.{name}" if path else name) for name in names)


def _wgs84(path: str) -> Callable[[object], tuple[float, ...]]:
    lat, lon, alt = _child_getters(path, "latitude", "longitude", "altitude")

    def read(message: object) -> tuple[float, ...]:
        return (
            number_of(lat(message), "latitude"),
            number_of(lon(message), "longitude"),
            number_of(alt(message), "altitude"),
        )

    return read


def _local(path: str, yaw_from: str) -> Callable[[object], tuple[float, ...]]:
    get_x, get_y = _child_getters(path, "x", "y")
    turn = _child_getters(yaw_from, "x", "y", "z", "w") if yaw_from else None

    def read(message: object) -> tuple[float, ...]:
        x, y = number_of(get_x(message), "x"), number_of(get_y(message), "y")
        if turn is None:
            return (x, y, math.nan)
        return (x, y, yaw_of(*(number_of(get(message), yaw_from) for get in turn)))

    return read
