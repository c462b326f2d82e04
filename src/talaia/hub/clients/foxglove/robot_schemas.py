"""JSON schemas of the robot's own services: of the requests that commands make of it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.clients.foxglove.schemas import argument_schema, made_schema
from talaia.hub.clients.request_fields import path_steps
from talaia.model.list_texts import LIST_TYPES

if TYPE_CHECKING:
    from talaia.hub.clients.foxglove.schemas import NamedSchema
    from talaia.hub.clients.robot_names import RobotName

__all__ = ["ROBOT_ANSWER_SCHEMA", "robot_schema"]

_Json = dict[str, object]
# As the robot's own services answer, those of `std_srvs` among them.
ROBOT_ANSWER_SCHEMA = made_schema(
    "talaia.RobotAnswer", {"success": {"type": "boolean"}, "message": {"type": "string"}}
)


def robot_schema(robot: RobotName) -> NamedSchema:
    """Give the schema of a request of the robot's own, as far as commands make such."""
    properties: _Json = {}
    for path, argument in robot.arguments().items():
        said = argument_schema(argument)
        if argument.type in LIST_TYPES:
            # In the robot's own request it is one.
            said = {**said, "type": "array", "items": {}}
        _place(properties, path_steps(path), said)
    for path, values in robot.fixed().items():
        _place(properties, path_steps(path), {"enum": list(dict.fromkeys(values))})
    return made_schema(robot.type, properties)


def _place(properties: _Json, steps: tuple[str | int, ...], said: _Json) -> None:
    """Put what is said of a field where it lies."""
    step, *rest = steps
    if not rest:
        properties.setdefault(str(step), said)
        return
    if isinstance(rest[0], int):
        # Of a list each item is alike.
        held = properties.setdefault(
            str(step), {"type": "array", "items": {"type": "object", "properties": {}}}
        )
        if len(rest) == 1 or not isinstance(held, dict):
            return
        held, rest = held.get("items"), rest[1:]
    else:
        held = properties.setdefault(str(step), {"type": "object", "properties": {}})
    inner = held.get("properties") if isinstance(held, dict) else None
    if isinstance(inner, dict):
        _place(inner, tuple(rest), said)
