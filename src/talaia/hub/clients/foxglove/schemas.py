"""JSON schemas of what is offered, and samples as the JSON that fits them. Pure.

Positions and pictures take the names and fields of Foxglove's well-known schemas, so that its
panels know them; other signals have a schema of their own with name and unit in it.

Long, because each schema stands beside what fills it.
"""

from __future__ import annotations

import base64
import json
import math
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.list_texts import LIST_TYPES
from talaia.model.site import ArgumentType, PositionFrame, SignalType

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Argument, Command, Signal

__all__ = [
    "ANSWER_SCHEMA",
    "EMPTY_SCHEMA",
    "FRAME_SCHEMA",
    "IMAGE_SCHEMA",
    "VIDEO_SCHEMA",
    "NamedSchema",
    "argument_schema",
    "arguments_schema",
    "encode_answer",
    "encode_frame",
    "encode_picture",
    "encode_sample",
    "made_schema",
    "signal_schema",
]

# What a local position is relative to; there is one such frame at a site.
LOCAL_FRAME = "local"

_Json = dict[str, object]


class NamedSchema(NamedTuple):
    """A schema, its name, in what it is written, and in what the messages of it are."""

    name: str
    text: str
    encoding: str = "jsonschema"
    messages: str = "json"


def made_schema(name: str, properties: Mapping[str, object], **more: object) -> NamedSchema:
    """Give the schema of an object with these properties."""
    said = {"title": name, "type": "object", **more, "properties": properties}
    return NamedSchema(name, json.dumps(said, ensure_ascii=False))


def _number(**more: object) -> _Json:
    return {"type": "number", **more}


def _object(**properties: object) -> _Json:
    return {"type": "object", "properties": properties}


_TIME = {
    "type": "object",
    "title": "time",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
    },
}
# Fields of these names are known to all of Foxglove's panels.
_TEXT: _Json = {"type": "string"}
# By these names clients know the fields without reading the schema.
_POSE = made_schema(
    "foxglove.PoseInFrame",
    {
        "timestamp": _TIME,
        "frame_id": _TEXT,
        "pose": _object(
            position=_object(x=_number(), y=_number(), z=_number()),
            orientation=_object(x=_number(), y=_number(), z=_number(), w=_number()),
        ),
    },
)
_FIX = made_schema(
    "foxglove.LocationFix",
    {
        "timestamp": _TIME,
        "frame_id": _TEXT,
        "latitude": _number(),
        "longitude": _number(),
        "altitude": _number(),
        "position_covariance": {"type": "array", "items": _number()},
        "position_covariance_type": {"type": "integer"},
    },
)
_PICTURE = {
    "timestamp": _TIME,
    "frame_id": _TEXT,
    "data": {"type": "string", "contentEncoding": "base64"},
    "format": _TEXT,
}
IMAGE_SCHEMA = made_schema("foxglove.CompressedImage", _PICTURE)
VIDEO_SCHEMA = made_schema("foxglove.CompressedVideo", _PICTURE)
# Where a device's own frame is in the local one: what is drawn in it moves along.
FRAME_SCHEMA = made_schema(
    "foxglove.FrameTransform",
    {
        "timestamp": _TIME,
        "parent_frame_id": _TEXT,
        "child_frame_id": _TEXT,
        "translation": _object(x=_number(), y=_number(), z=_number()),
        "rotation": _object(x=_number(), y=_number(), z=_number(), w=_number()),
    },
)
EMPTY_SCHEMA = made_schema("talaia.Empty", {})
ANSWER_SCHEMA = made_schema(
    "talaia.Answer",
    {"phase": {**_TEXT, "description": "succeeded"}, "message": _TEXT},
)
_TYPES = {
    ArgumentType.NUMBER: "number",
    ArgumentType.INTEGER: "integer",
    ArgumentType.BOOLEAN: "boolean",
    ArgumentType.TEXT: "string",
    **dict.fromkeys(LIST_TYPES, "string"),
}


def signal_schema(signal: Signal, device: str) -> NamedSchema:
    """Give the schema of a signal's messages; ``device`` is what people call its device."""
    title = f"{device}: {signal.name}"
    match signal.type:
        case SignalType.POSITION:
            return _FIX if signal.frame is PositionFrame.WGS84 else _POSE
        case SignalType.TEXT:
            return made_schema(
                "talaia.Text", {"timestamp": _TIME, "value": _TEXT}, description=title
            )
        case SignalType.STATE:
            # A word that the description does not name may come: see `_state`.
            states: _Json = {"type": "string", "enum": list(signal.states)}
            value = states if signal.states else _TEXT
            return made_schema(
                "talaia.State",
                {"timestamp": _TIME, "value": value, "index": {"type": "integer"}},
                description=title,
            )
        case SignalType.NUMBER:
            value = _number(description=signal.unit) if signal.unit else _number()
            return made_schema(
                "talaia.Number", {"timestamp": _TIME, "value": value}, description=title
            )


def arguments_schema(name: str, command: Command) -> NamedSchema:
    """Give the schema of a command's arguments."""
    # By the names that people give arguments, not by the paths they fill.
    properties = {key: argument_schema(argument) for key, argument in command.arguments.items()}
    required = [key for key, argument in command.arguments.items() if argument.default is None]
    return made_schema(f"talaia.{name.replace('/', '.')}", properties, required=required)


def encode_sample(signal: Signal, values: Mapping[str, float | str], time_us: int) -> bytes | None:
    """Write a signal's message.

    Args:
        signal: as it is described.
        values: of its parts; of a single one under the empty name.
        time_us: of the newest of them (UTC).

    Returns:
        None while a part without which it says nothing is not known.

    """
    said: _Json = {"timestamp": _time_of(time_us)}
    match signal.type:
        case SignalType.POSITION if signal.frame is PositionFrame.WGS84:
            fix = _fix(values)
            if fix is None:
                return None
            said |= fix
        case SignalType.POSITION:
            pose = _pose(values)
            if pose is None:
                return None
            said |= pose
        case SignalType.STATE:
            said |= _state(signal, values.get("", math.nan))
        case SignalType.TEXT | SignalType.NUMBER:
            value = values.get("", math.nan)
            # JSON has no NaN: what is not known is null.
            known = isinstance(value, str) or math.isfinite(value)
            said["value"] = value if known else None
    return msgspec.json.encode(said)


def encode_frame(child: str, values: Mapping[str, float | str], time_us: int) -> bytes | None:
    """Write where a device's frame is; None while that is not known."""
    placed = _placed(values)
    if placed is None:
        return None
    position, orientation = placed
    return msgspec.json.encode(
        {
            "timestamp": _time_of(time_us),
            "parent_frame_id": LOCAL_FRAME,
            "child_frame_id": child,
            "translation": position,
            "rotation": orientation,
        }
    )


def encode_picture(data: bytes, *, camera: str, time_us: int, form: str = "jpeg") -> bytes:
    """Write a picture of a camera, ``jpeg`` or of an ``h264`` film (Annex B)."""
    return msgspec.json.encode(
        {
            "timestamp": _time_of(time_us),
            "frame_id": camera,
            "data": base64.b64encode(data).decode(),
            "format": form,
        }
    )


def encode_answer(phase: str, message: str) -> bytes:
    """Write what came of a command."""
    return msgspec.json.encode({"phase": phase, "message": message})


def argument_schema(argument: Argument) -> dict[str, object]:
    """Give the schema of one argument."""
    said: _Json = {"type": _TYPES[argument.type], "title": argument.name}
    # What is not said in the description is left out.
    facts = {
        "description": argument.unit,
        "minimum": argument.minimum,
        "maximum": argument.maximum,
        "default": argument.default,
    }
    return said | {key: value for key, value in facts.items() if value not in {None, ""}}


def _time_of(time_us: int) -> _Json:
    return {"sec": max(0, time_us // 1_000_000), "nsec": time_us % 1_000_000 * 1000}


def _state(signal: Signal, value: float | str) -> _Json:
    # Of a state that robots give as a text.
    if isinstance(value, str):
        return {"value": value, "index": -1}
    if not math.isfinite(value):
        return {"value": "", "index": -1}
    # What a description names no word for is shown as its number.
    index = int(value)
    known = 0 <= index < len(signal.states)
    return {"value": signal.states[index] if known else str(index), "index": index}


def _finite(values: Mapping[str, float | str], part: str, missing: float | None) -> float | None:
    # NaN stands for unknown.
    value = values.get(part, math.nan)
    return value if not isinstance(value, str) and math.isfinite(value) else missing


def _pose(values: Mapping[str, float | str]) -> _Json | None:
    placed = _placed(values)
    if placed is None:
        return None
    position, orientation = placed
    return {
        "frame_id": LOCAL_FRAME,
        "pose": {"position": position, "orientation": orientation},
    }


def _placed(values: Mapping[str, float | str]) -> tuple[_Json, _Json] | None:
    """Give position and orientation in the local frame."""
    x, y = _finite(values, "x", None), _finite(values, "y", None)
    if x is None or y is None:
        return None
    # About the vertical: half of the angle makes the quaternion.
    half = (_finite(values, "yaw", 0.0) or 0.0) / 2
    turned: _Json = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
    return {"x": x, "y": y, "z": 0.0}, turned


def _fix(values: Mapping[str, float | str]) -> _Json | None:
    lat, lon = _finite(values, "lat", None), _finite(values, "lon", None)
    if lat is None or lon is None:
        return None
    return {
        "frame_id": "wgs84",
        "latitude": lat,
        "longitude": lon,
        "altitude": _finite(values, "alt", 0.0),
        "position_covariance": [0.0] * 9,
        # Unknown.
        "position_covariance_type": 0,
    }
