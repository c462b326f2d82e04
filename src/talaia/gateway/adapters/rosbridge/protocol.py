"""What is said to a rosbridge server and what it says (rosbridge v2). Pure.

https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from __future__ import annotations

import json
import math
from base64 import b64decode
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.rosbridge.cbor import read_cbor
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.samples.field_paths import compile_getter, number_of, parse_path
from talaia.wire.frames import CommandPhase
from talaia.wire.nested_json import check_depth

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Command
    from talaia.wire.frames import Scalar

__all__ = [
    "MessageAttributes",
    "ServerMessage",
    "bytes_of",
    "nest_fields",
    "outcome_of",
    "progress_of",
    "read_message",
    "type_for",
    "write_frame",
]

# As action_msgs/GoalStatus counts.
_GOALS = {
    4: CommandPhase.SUCCEEDED,
    5: CommandPhase.CANCELLED,
    6: CommandPhase.FAILED,
}


class MessageAttributes:
    """A map with its keys as attributes, so that a path is followed as in any message."""

    def __init__(self, fields: Mapping[str, object]) -> None:
        """Take the fields."""
        self.__dict__.update(fields)

    def __repr__(self) -> str:
        return f"Message({self.__dict__})"


class ServerMessage(NamedTuple):
    """What a server said.

    Attributes:
        op: ``publish``, ``service_response``, ``action_feedback``, ``action_result``, ``status``.
        id: of the call this answers, or empty.
        topic: of a publication.
        body: its message, or the values of an answer, in what form it came.
        result: whether a call went well.
        status: how an action ended; see action_msgs/GoalStatus.
        level: of a status.

    """

    op: str
    id: str = ""
    topic: str = ""
    body: object = None
    result: bool = True
    status: int = 0
    level: str = ""


def type_for(name: str, ros: int) -> str:
    """Write a type as the server takes it: ROS 1 knows no middle part."""
    package, _, short = name.split("/")
    return f"{package}/{short}" if ros == 1 else name


def write_frame(op: str, **what: object) -> str:
    """Write a frame to the server."""
    return json.dumps({"op": op, **what}, allow_nan=False)


def nest_fields(fields: Mapping[str, Scalar]) -> dict[str, object]:
    """Turn fields by path into nested maps; the server gives the others their defaults.

    Raises:
        FieldError: an element of a list that does not follow the one before, or a path that
            goes through a value.

    """
    root: dict[str, object] = {}
    for path, value in fields.items():
        steps = parse_path(path)
        at: object = root
        for step, following in pairwise(steps):
            at = _step_into(at, step, [] if isinstance(following, int) else {}, path)
        _step_into(at, steps[-1], value, path)
    return root


def _step_into(at: object, step: str | int, fresh: object, path: str) -> object:
    """Give what is at a step; put ``fresh`` there if nothing is."""
    if isinstance(at, dict) and isinstance(step, str):
        return at.setdefault(step, fresh)
    if isinstance(at, list) and isinstance(step, int):
        if step > len(at):
            raise FieldError(path, f"element {step} does not follow the one before")
        if step == len(at):
            at.append(fresh)
        return at[step]
    raise FieldError(path, "goes through a value that is already set")


def read_message(data: str | bytes) -> ServerMessage:
    """Read a frame of the server.

    Raises:
        FieldError: it is none.

    """
    if isinstance(data, bytes):
        found = read_cbor(data, MessageAttributes)
    else:
        try:
            found = json.loads(data, object_hook=_make_attributes)
            check_depth(data, found)
        except (ValueError, RecursionError) as error:
            raise FieldError("", f"the server sent no JSON: {error}") from error
    said = getattr(found, "__dict__", {}) if isinstance(found, MessageAttributes) else {}
    op = said.get("op")
    if not isinstance(op, str):
        raise FieldError("", "the server sent a frame without op")
    body = said.get("msg", said.get("values"))
    status, result = said.get("status"), said.get("result")
    return ServerMessage(
        op,
        str(said.get("id") or ""),
        str(said.get("topic") or ""),
        body,
        result is not False,
        status if isinstance(status, int) else 0,
        str(said.get("level") or ""),
    )


def _make_attributes(fields: dict[str, object]) -> MessageAttributes:
    # JSON has no NaN, so the server writes null.
    return MessageAttributes(
        {key: math.nan if value is None else value for key, value in fields.items()}
    )


def bytes_of(message: object) -> object:
    """Give an image message its data as bytes, which JSON carries as base64.

    Raises:
        FieldError: it has none.

    """
    data = getattr(message, "data", None)
    if isinstance(data, str) and isinstance(message, MessageAttributes):
        try:
            return MessageAttributes({**message.__dict__, "data": b64decode(data, validate=True)})
        except ValueError as error:
            raise FieldError("data", "is not base64") from error
    if data is None:
        raise FieldError("data", "the message has no such field")
    return message


def outcome_of(said: ServerMessage) -> CommandOutcome:
    """Read the answer to a call or the result of an action."""
    body = said.body
    words = body if isinstance(body, str) else getattr(body, "message", "")
    message = words[:2000] if isinstance(words, str) else ""
    if said.op == "action_result" and said.result:
        phase = _GOALS.get(said.status, CommandPhase.UNKNOWN)
        return CommandOutcome(phase, message)
    if not said.result:
        refused = "does not exist" in message or "unavailable" in message
        phase = CommandPhase.REFUSED if refused else CommandPhase.FAILED
        return CommandOutcome(phase, message or "the robot says it did not succeed")
    if getattr(body, "success", True) is False:
        return CommandOutcome(CommandPhase.FAILED, message or "the robot says it did not succeed")
    return CommandOutcome(CommandPhase.SUCCEEDED, message)


def progress_of(said: ServerMessage, command: Command) -> CommandOutcome:
    """Read the feedback of an action."""
    progress = 0.0
    # What counts down is told by its first value, which is not kept here.
    if command.progress and command.progress_end:
        try:
            value = number_of(compile_getter(command.progress)(said.body), command.progress)
            progress = value / command.progress_end
        except FieldError:
            progress = 0.0
    return CommandOutcome(CommandPhase.RUNNING, "", min(1.0, max(0.0, progress)))
