"""Definitions of actions: the two services and the topic that one is made of (REP-2). Pure."""

from __future__ import annotations

from typing import NamedTuple

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    FieldType,
    MessageField,
    PartDefinition,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.service_definition import ServiceDefinition

__all__ = ["ACTION_PARTS", "TIME", "UUID", "ActionDefinition", "action_definition"]

# What a ``.action`` file defines, in its order; ROS makes the rest of it.
ACTION_PARTS = ("Goal", "Result", "Feedback")
UUID = "unique_identifier_msgs/msg/UUID"
TIME = "builtin_interfaces/msg/Time"
_GOAL_ID = MessageField("goal_id", FieldType(UUID))


class ActionDefinition(NamedTuple):
    """An action ``package/action/Name`` as it goes over the wire."""

    send_goal: ServiceDefinition
    get_result: ServiceDefinition
    feedback: TypeDefinition


def action_definition(
    name: str, parts: tuple[TypeDefinition, ...], uuid: TypeDefinition, time: TypeDefinition
) -> ActionDefinition:
    """Make it of what the file says.

    Args:
        name: ``package/action/Name``.
        parts: those of `ACTION_PARTS`, in that order.
        uuid: the definition of `UUID`.
        time: the definition of `TIME`.

    Raises:
        BadDefinition: a part of it is not known.

    """
    goal, result, feedback = parts

    def message(
        ending: str, fields: tuple[MessageField, ...], *of: TypeDefinition
    ) -> TypeDefinition:
        known = {name: part for definition in of for name, part in definition.parts.items()}
        whole = f"{name}_{ending}"
        known[whole] = PartDefinition(fields, {})
        return TypeDefinition(whole, known).checked()

    return ActionDefinition(
        send_goal=ServiceDefinition(
            f"{name}_SendGoal",
            message(
                "SendGoal_Request",
                (_GOAL_ID, MessageField("goal", FieldType(goal.name))),
                uuid,
                goal,
            ),
            message(
                "SendGoal_Response",
                (
                    MessageField("accepted", FieldType("bool")),
                    MessageField("stamp", FieldType(TIME)),
                ),
                time,
            ),
        ),
        get_result=ServiceDefinition(
            f"{name}_GetResult",
            message("GetResult_Request", (_GOAL_ID,), uuid),
            message(
                "GetResult_Response",
                (
                    MessageField("status", FieldType("int8")),
                    MessageField("result", FieldType(result.name)),
                ),
                result,
            ),
        ),
        feedback=message(
            "FeedbackMessage",
            (_GOAL_ID, MessageField("feedback", FieldType(feedback.name))),
            uuid,
            feedback,
        ),
    )
