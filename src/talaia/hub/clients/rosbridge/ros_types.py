"""ROS messages by their definitions: bytes to plain values, and types as rosapi describes them.

`rosbags` reads messages. It is loaded when somebody first wants a message in JSON
or a type described.
"""

from __future__ import annotations

import dataclasses
import struct
from typing import TYPE_CHECKING, Any

from talaia.hub.live.taps.type_texts import (
    MessageUnreadable,
    TypeText,
    brought_store,
    read_definitions,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosbags.interfaces.typing import FieldDesc, Typesdict

    from talaia.wire.frames import TapSchema

__all__ = ["MOST_READ", "describe_fields", "describe_type", "message_reader", "read_known_message"]

# Bytes of a raw message that is read for a client.
MOST_READ = 4 * 1024 * 1024
# Types that are described at once; a robot's largest has some dozens in it.
_MOST_TYPES = 500


def message_reader(schema: TapSchema) -> Callable[[bytes], dict[str, object]]:
    """Compile what reads the messages of a schema as mappings of plain values and numpy arrays.

    What it gives raises `MessageUnreadable` for bytes that are no such message.

    Raises:
        MessageUnreadable: there is no definition, or none that can be read.

    """
    from rosbags.serde import SerdeError
    from rosbags.typesys import TypesysError
    from rosbags.typesys.store import Typestore

    # Without what ROS brings: the robot's own definitions, of time too, count. No list has more
    # items than a message that is read has bytes.
    store = Typestore(max_sequence_length=MOST_READ)
    try:
        store.register(read_definitions(TypeText(schema.type, schema.encoding, schema.definition)))
        store.get_msgdef(schema.type)
    except (TypesysError, SyntaxError, KeyError, RecursionError) as error:
        raise MessageUnreadable(f"{schema.type} cannot be read: {str(error)[:300]}") from error
    read = store.deserialize_ros1 if schema.message_encoding == "ros1" else store.deserialize_cdr

    def read_plain(data: bytes) -> dict[str, object]:
        try:
            return _plain_fields(read(data, schema.type))
        except (SerdeError, struct.error, ValueError, MemoryError, AssertionError) as error:
            raise MessageUnreadable(f"not a {schema.type}: {str(error)[:300]}") from error

    return read_plain


def read_known_message(kind: str, data: bytes) -> dict[str, object]:
    """Read the CDR of a type that comes with ROS, as plain values and lists.

    Raises:
        MessageUnreadable: the type is not known here, or the bytes are none of it.

    """
    from rosbags.serde import SerdeError

    store = brought_store()
    if kind not in store.fielddefs:
        raise MessageUnreadable(f"the type {kind[:200]!r} is read as json only")
    try:
        read = _plain_fields(store.deserialize_cdr(data, kind))
    except (SerdeError, struct.error, ValueError, MemoryError, AssertionError) as error:
        raise MessageUnreadable(f"not a {kind}: {str(error)[:300]}") from error
    return {name: _listed(value) for name, value in read.items()}


def describe_type(name: str, text: TypeText | None = None) -> list[dict[str, object]]:
    """Describe a message type and the types in it, as ``rosapi_msgs/TypeDef`` does.

    Args:
        name: such as ``geometry_msgs/msg/Twist``.
        text: its definition; without one, types that come with ROS are known.

    Raises:
        MessageUnreadable: it is not known.

    """
    types = _brought_types() if text is None else read_definitions(text)
    found: dict[str, dict[str, object]] = {}
    waiting = [name]
    while waiting and len(found) < _MOST_TYPES:
        one = waiting.pop(0)
        if one in found:
            continue
        if one not in types:
            raise MessageUnreadable(f"the type {one[:200]!r} is not known")
        constants, fields = types[one]
        described = [(field, *_field_kind(kind)) for field, kind in fields]
        found[one] = _type_definition(one, described, [(said[0], said[2]) for said in constants])
        waiting += [kind for _, kind, _ in described if "/" in kind]
    return list(found.values())


def describe_fields(name: str, fields: list[tuple[str, str]]) -> list[dict[str, object]]:
    """Describe a type by the paths of its fields, each with its ROS type (``float64[]``: a list).

    What lies deeper has types of its own, named after it.
    """
    described: dict[str, tuple[str, str, int]] = {}
    inner: dict[str, list[tuple[str, str]]] = {}
    for path, kind in fields:
        head, _, rest = path.partition(".")
        field, bracket, _ = head.partition("[")
        length = 0 if bracket or kind.endswith("[]") else -1
        if rest:
            inner.setdefault(field, []).append((rest, kind))
            described[field] = (field, f"{name}_{field}", length)
        else:
            described.setdefault(field, (field, kind.removesuffix("[]"), length))
    found = [_type_definition(name, list(described.values()), [])]
    for field, below in inner.items():
        found += describe_fields(f"{name}_{field}", below)
    return found


def _type_definition(
    name: str, fields: list[tuple[str, str, int]], constants: list[tuple[str, object]]
) -> dict[str, object]:
    return {
        "type": name,
        "fieldnames": [field for field, _, _ in fields],
        "fieldtypes": [kind for _, kind, _ in fields],
        # -1: no array; 0: of any length.
        "fieldarraylen": [length for _, _, length in fields],
        "examples": ["" if "/" in kind else "0" for _, kind, _ in fields],
        "constnames": [constant for constant, _ in constants],
        "constvalues": [str(value) for _, value in constants],
    }


def _field_kind(kind: FieldDesc) -> tuple[str, int]:
    """Give a field's type and the length of its array."""
    from rosbags.interfaces import Nodetype

    described: Any = kind
    node, of = described
    match node:
        case Nodetype.BASE:
            return of[0], -1
        case Nodetype.NAME:
            return of, -1
        case Nodetype.ARRAY:
            return _field_kind(of[0])[0], of[1]
        case _:
            return _field_kind(of[0])[0], 0


def _brought_types() -> Typesdict:
    return brought_store().fielddefs


def _listed(value: object) -> object:
    if isinstance(value, dict):
        return {name: _listed(inner) for name, inner in value.items()}
    if isinstance(value, list):
        return [_listed(inner) for inner in value]
    # Of numbers there is an array of numpy's.
    return value.tolist() if hasattr(value, "tolist") else value


def _plain_fields(message: Any) -> dict[str, object]:  # noqa: ANN401 - of a class made by rosbags
    return {
        field.name: _plain_value(getattr(message, field.name))
        for field in dataclasses.fields(message)
        # No field of the message, though its class has it so.
        if field.name != "__msgtype__"
    }


def _plain_value(value: object) -> object:
    if isinstance(value, list):
        return [_plain_value(item) for item in value]
    return _plain_fields(value) if dataclasses.is_dataclass(value) else value
