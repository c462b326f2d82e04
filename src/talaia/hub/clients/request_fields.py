"""A request as the robot's own programs write it, read as the arguments of a command. Pure.

A field that the command leaves alone may be there, as long as it says nothing: it would be lost.
"""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

from talaia.model.arguments import fields_of
from talaia.model.list_texts import LIST_TYPES, list_text
from talaia.model.site import ArgumentType

if TYPE_CHECKING:
    from talaia.model.site import Argument, Command
    from talaia.wire.frames import Scalar

__all__ = ["fit_field", "fit_request", "path_steps"]

_STEP = re.compile(r"[A-Za-z_][A-Za-z0-9_]*|\[\d{1,6}\]")
# Of a header: the robot's own time is what counts, and ROS 1 numbers messages by itself.
_OF_PUBLISHER = frozenset({"stamp", "seq"})
_NO_TURN = {"x": 0, "y": 0, "z": 0, "w": 1}
# What a link's message holds of a whole number.
_LEAST_INTEGER, _MOST_INTEGER = -(2**63), 2**63 - 1
# Letters of a path or value in a sentence.
_MOST_SHOWN = 100

# By step, down to the path that a command fills.
_Tree = dict[str | int, "_Tree | str"]


def path_steps(path: str) -> tuple[str | int, ...]:
    """Cut ``pose.covariance[0]`` into names and indexes."""
    return tuple(int(step[1:-1]) if step[0] == "[" else step for step in _STEP.findall(path))


def fit_request(command: Command, request: Mapping[str, object]) -> dict[str, Scalar] | str:
    """Give the arguments by which a command makes this request, or why it cannot."""
    given: dict[str, object] = {}
    problem = _collect_fields(_fields_tree(command), request, "", given)
    if problem:
        return problem
    filled = {argument.field for argument in command.arguments.values()}
    for path, value in command.fixed.items():
        # An argument that fills the same field wins, as when it is sent. Left out is what ROS has
        # where nothing was written, and never what the description has there.
        if path not in filled and not _is_same(found := given.get(path, type(value)()), value):
            return f"{path} can only be {_shown(value)} here, not {_shown(found)}"
    args: dict[str, Scalar] = {}
    for name, argument in command.arguments.items():
        if argument.field not in given:
            if argument.default is None:
                return f"the field {argument.field} is missing"
            continue
        read = _read_value(argument, given[argument.field])
        if read is None:
            found = _shown(given[argument.field])
            return f"{argument.field}: expected {_EXPECTED[argument.type]}, found {found}"
        args[name] = read
    fields = fields_of(command, args)
    return fields if isinstance(fields, str) else args


def fit_field(command: Command, field: str, value: object) -> dict[str, Scalar] | str:
    """Give the arguments by which a command of one field fills it so, or why it cannot.

    The field's name is taken whole: that of a parameter may have dots in it.
    """
    for name, argument in command.arguments.items():
        read = _read_value(argument, value)
        if read is None:
            return f"{field}: expected {_EXPECTED[argument.type]}, found {_shown(value)}"
        args: dict[str, Scalar] = {name: read}
        fields = fields_of(command, args)
        return fields if isinstance(fields, str) else args
    fixed = command.fixed[field]
    if not _is_same(value, fixed):
        return f"{field} can only be {_shown(fixed)} here, not {_shown(value)}"
    return {}


def _fields_tree(command: Command) -> _Tree:
    tree: _Tree = {}
    for path in (*command.fixed, *(argument.field for argument in command.arguments.values())):
        at = tree
        *inner, last = path_steps(path)
        for step in inner:
            below = at.setdefault(step, {})
            if isinstance(below, str):
                break
            at = below
        else:
            at.setdefault(last, path)
    return tree


def _collect_fields(tree: _Tree | str, value: object, where: str, given: dict[str, object]) -> str:
    """Take the values that a command fills; say what else is asked for, if anything."""
    if isinstance(tree, str):
        given[tree] = value
        return ""
    if isinstance(value, Mapping):
        inner = {step: (f"{where}.{step}" if where else str(step)) for step in value}
        values = value.items()
    elif isinstance(value, list):
        inner = {at: f"{where}[{at}]" for at in range(len(value))}
        values = dict(enumerate(value)).items()
    else:
        return "" if value is None else f"{where[:_MOST_SHOWN]} has fields of its own"
    for step, below in values:
        known = tree.get(step)
        if known is not None:
            if problem := _collect_fields(known, below, inner[step], given):
                return problem
        elif not _says_nothing(below) and not _is_publishers(where, step):
            return f"{inner[step][:_MOST_SHOWN]} cannot be set here"
    return ""


def _is_publishers(where: str, step: object) -> bool:
    return where.rpartition(".")[2] == "header" and step in _OF_PUBLISHER


def _says_nothing(value: object) -> bool:
    """Tell whether a field is as in a message that nobody has filled."""
    if isinstance(value, Mapping):
        return value == _NO_TURN or all(map(_says_nothing, value.values()))
    return all(map(_says_nothing, value)) if isinstance(value, list) else not value


def _is_same(found: object, fixed: Scalar) -> bool:
    # For Python True is 1.
    return isinstance(found, bool) is isinstance(fixed, bool) and found == fixed


def _read_value(argument: Argument, value: object) -> Scalar | None:
    """Give a value as the command's argument has it; None: it is none of that type."""
    match argument.type:
        case ArgumentType.BOOLEAN:
            return value if isinstance(value, bool) else None
        case ArgumentType.TEXT:
            return value if isinstance(value, str) else None
        case ArgumentType.INTEGER:
            return _whole_number(value)
        case ArgumentType.NUMBER:
            return _number(value)
        case _:
            return _list(argument.type, value)


def _number(value: object) -> float | None:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    try:
        return float(value)
    except OverflowError:
        return None


def _whole_number(value: object) -> int | None:
    # In JSON of JavaScript there is no difference between 3 and 3.0.
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool):
        return None
    return value if _LEAST_INTEGER <= value <= _MOST_INTEGER else None


def _list(kind: ArgumentType, value: object) -> str | None:
    if kind is ArgumentType.BYTES and isinstance(value, str):
        # As rosbridge writes them in JSON.
        try:
            return list_text(base64.b64decode(value, validate=True))
        except (binascii.Error, ValueError):
            return None
    if not isinstance(value, list) or any(isinstance(item, list | Mapping) for item in value):
        return None
    return list_text(value)


def _shown(value: object) -> str:
    said = repr(value) if not isinstance(value, bool) else str(value).lower()
    return said if len(said) <= _MOST_SHOWN else f"{said[:_MOST_SHOWN]}…"


_EXPECTED = {
    ArgumentType.NUMBER: "a number",
    ArgumentType.INTEGER: "a whole number",
    ArgumentType.BOOLEAN: "true or false",
    ArgumentType.TEXT: "a text",
    **dict.fromkeys(LIST_TYPES, "a list"),
}
