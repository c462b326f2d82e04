"""Whether the arguments of a command fit its description. Pure; the hub and the gateway ask."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.list_texts import LIST_TYPES, list_text, parse_list
from talaia.model.site import ArgumentType

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.list_texts import Item
    from talaia.model.site import Argument, Command

__all__ = ["Value", "args_of", "fields_of", "list_fields", "unit_problem"]

Value = float | int | bool | str


def fields_of(command: Command, args: Mapping[str, Value]) -> dict[str, Value] | str:
    """Give the request's fields by path, or the sentence that says what is wrong with ``args``.

    A list is one text, as `list_text` writes it.
    """
    unknown = sorted(set(args) - set(command.arguments))
    if unknown:
        return f"there is no argument {unknown[0]!r}"
    # First, so that an argument that fills the same field wins.
    fields: dict[str, Value] = dict(command.fixed)
    for name, argument in command.arguments.items():
        value = args.get(name, argument.default)
        if value is None:
            return f"the argument {name!r} is missing"
        problem = _argument_problem(argument, value)
        if problem:
            return f"{name}: {problem}"
        fields[argument.field] = _field_value(argument, value)
    return fields


def _field_value(argument: Argument, value: Value) -> Value:
    """Give a value that fits its argument as an adapter gets it."""
    if argument.type is ArgumentType.NUMBER:
        # A whole number as well: a field of floats takes no int.
        return float(value)
    if argument.type in LIST_TYPES:
        return list_text(parse_list(argument.type, str(value)))
    return value


def list_fields(command: Command, fields: Mapping[str, Value]) -> dict[str, Value | list[Item]]:
    """Give the request's fields, as `fields_of` made them, with lists in place of their texts."""
    lists = {one.field: one.type for one in command.arguments.values() if one.type in LIST_TYPES}
    given: dict[str, Value | list[Item]] = dict(fields)
    for field, kind in lists.items():
        found = parse_list(kind, str(given.get(field, "")))
        # What `fields_of` let through is a list.
        given[field] = [] if isinstance(found, str) else found
    return given


def args_of(command: Command, args: Mapping[str, Value]) -> dict[str, Value]:
    """Give the arguments by name, with the defaults of those that were not given."""
    defaults = {
        name: argument.default
        for name, argument in command.arguments.items()
        if argument.default is not None
    }
    return {**defaults, **args}


def unit_problem(command: Command, units: Mapping[str, str]) -> str:
    """Say which argument was asked in another unit than the description has now, if any.

    Whoever asks says the unit that was shown beside each number: a page that was opened before
    the description changed must not send degrees where radians are meant.
    """
    for name, unit in units.items():
        argument = command.arguments.get(name)
        if argument is not None and argument.unit != unit:
            asked, meant = unit or "no unit", argument.unit or "no unit"
            return f"{name}: asked in {asked}, but it is {meant} here; load the page anew"
    return ""


def _argument_problem(argument: Argument, value: Value) -> str:
    match argument.type:
        case ArgumentType.BOOLEAN:
            return "" if isinstance(value, bool) else f"expected true or false, found {value!r}"
        case ArgumentType.TEXT:
            if not isinstance(value, str):
                return f"expected a text, found {value!r}"
            if len(value) > argument.max_length:
                return f"at most {argument.max_length} characters, found {len(value)}"
            return ""
        case ArgumentType.INTEGER:
            # For Python True is an int.
            if not isinstance(value, int) or isinstance(value, bool):
                return f"expected a whole number, found {value!r}"
            return _range_problem(argument, value)
        case ArgumentType.NUMBER:
            if not isinstance(value, int | float) or isinstance(value, bool):
                return f"expected a number, found {value!r}"
            return _range_problem(argument, value)
        case _:
            return _list_problem(argument, value)


def _list_problem(argument: Argument, value: Value) -> str:
    if not isinstance(value, str):
        return f"expected a list as text, found {value!r}"
    if len(value) > argument.max_length:
        return f"at most {argument.max_length} characters, found {len(value)}"
    found = parse_list(argument.type, value)
    if isinstance(found, str):
        return found
    for position, item in enumerate(found, 1):
        # Truths have no range.
        numeric = isinstance(item, int | float) and not isinstance(item, bool)
        if numeric and (problem := _range_problem(argument, float(item))):
            return f"item {position}: {problem}"
    return ""


def _range_problem(argument: Argument, value: float) -> str:
    try:
        finite = math.isfinite(value)
    # An int of hundreds of digits fits no float.
    except OverflowError:
        finite = False
    if not finite:
        return "expected a finite number"
    if argument.minimum is not None and value < argument.minimum:
        return f"{value} is below {argument.minimum}"
    if argument.maximum is not None and value > argument.maximum:
        return f"{value} is above {argument.maximum}"
    return ""
