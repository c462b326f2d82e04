"""Messages that came as values, serialized as ROS does it. Pure.

A rosbridge server takes a message apart, as JSON or as CBOR; here it is put together again, by one
definition that goes along with the bytes. So the two always fit, whatever version the robot has.
"""

from __future__ import annotations

import math
from base64 import b64decode
from typing import TYPE_CHECKING, Any

import numpy as np

from talaia.gateway.adapters.ros2.type_definitions.message_decoder import compiled_store
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    FieldForm,
    FieldType,
    TypeDefinition,
)
from talaia.gateway.adapters.ros2.type_definitions.message_encoder import (
    NUMPY_WORDS,
    MessageEncoder,
)
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.gateway.adapters.ros2.type_definitions.message_definition import MessageField

__all__ = ["MessageSerializer", "cbor_carries"]

# ROS 1 writes times by other names.
_OLD_NAMES = {"sec": "secs", "nanosec": "nsecs"}
_TEXTS = ("string", "wstring")


def cbor_carries(definition: TypeDefinition, ros: int) -> bool:
    """Tell whether rosbridge_suite can write such messages as CBOR; of the others nothing comes.

    JSON it can always write, but there an infinite number is none, and lists are longer.
    """
    return all(
        _cbor_carries(field.type, ros)
        for part in definition.parts.values()
        for field in part.fields
    )


def _cbor_carries(kind: FieldType, ros: int) -> bool:
    if kind.base not in TYPE_IDS:
        # Of messages it writes lists of any kind.
        return True
    if kind.form in (FieldForm.ARRAY, FieldForm.BOUNDED) or kind.base == "wstring":
        return False
    if ros == 1:
        return kind.base != "string" or kind.form is FieldForm.ONE
    return kind.base != "byte" and not kind.text_bound


class MessageSerializer:
    """Serializes messages of one type."""

    def __init__(self, definition: TypeDefinition, ros: int) -> None:
        """Compile a checked definition for ROS 1 or 2.

        Raises:
            BadDefinition: it is too large.

        """
        self._definition = definition
        self._ros = ros
        self._encoder = MessageEncoder(definition)
        self._store = compiled_store(definition)

    def serialize_message(self, values: object) -> bytes:
        """Give the bytes of a message whose fields are attributes; what is not there is empty.

        Raises:
            FieldError: a value does not fit its field.

        """
        message = self.build_message(values)
        if self._ros == 1:
            return bytes(self._store.serialize_ros1(message, self._definition.name))
        return self._encoder.encode_message(message)

    def build_message(self, values: object) -> Any:  # noqa: ANN401 - of a class made by rosbags
        """Give the message itself: lists are lists, however the server wrote them.

        Raises:
            FieldError: a value does not fit its field.

        """
        return self._make_part(values, self._definition.name, "")

    def _make_part(self, values: object, name: str, where: str) -> Any:  # noqa: ANN401
        fields = self._definition.parts[name].fields
        found = getattr(values, "__dict__", None)
        if found is None:
            raise FieldError(where, f"expected {name}, found {values!r:.80}")
        if not fields:
            # rosbags gives an empty message of ROS 2 the byte that ROS gives it.
            return self._store.types[name](0)
        make: Any = self._store.types[name]
        return make(
            *(self._make_value(_value_of(found, field), field.type, field.name) for field in fields)
        )

    def _make_value(self, value: object, kind: FieldType, where: str) -> object:
        if kind.form is FieldForm.ONE:
            return self._make_element(value, kind.base, where)
        count = kind.size if kind.form is FieldForm.ARRAY else 0
        if value is None:
            value = [0 if kind.base in TYPE_IDS and kind.base not in _TEXTS else None] * count
        if kind.base in TYPE_IDS and kind.base not in _TEXTS:
            made: NDArray[np.generic] | list[object] = _numbers_of(value, kind, where)
        elif isinstance(value, list):
            made = [self._make_element(item, kind.base, where) for item in value]
        else:
            raise FieldError(where, f"expected a list, found {value!r:.80}")
        if kind.form is FieldForm.ARRAY and len(made) != kind.size:
            raise FieldError(where, f"expected {kind.size} elements, found {len(made)}")
        if kind.form is FieldForm.BOUNDED and len(made) > kind.size:
            raise FieldError(where, f"expected at most {kind.size} elements, found {len(made)}")
        return made

    def _make_element(self, value: object, base: str, where: str) -> object:
        if base not in TYPE_IDS:
            return self._make_part(_Empty() if value is None else value, base, where)
        if base in _TEXTS:
            if not isinstance(value, str | None):
                raise FieldError(where, f"expected a text, found {value!r:.80}")
            return value or ""
        return _number_of(value, base, where)


class _Empty:
    """A message of which nothing came."""


def _value_of(found: dict[str, object], field: MessageField) -> object:
    value = found.get(field.name)
    return found.get(_OLD_NAMES.get(field.name, "")) if value is None else value


def _number_of(value: object, base: str, where: str) -> object:
    if base.startswith("float"):
        if isinstance(value, int | float | None):
            # What JSON has no number for is NaN already; see `read_message`.
            return float(value or 0)
    elif value is None:
        return False if base == "bool" else 0
    elif base == "bool" and isinstance(value, bool | int):
        return bool(value)
    elif isinstance(value, int):
        kind = np.iinfo(NUMPY_WORDS.get(base, base))
        if kind.min <= value <= kind.max:
            return int(value)
    raise FieldError(where, f"expected {base}, found {value!r:.80}")


def _numbers_of(value: object, kind: FieldType, where: str) -> NDArray[np.generic]:
    """Give a list of numbers, however it came: as one of JSON, as bytes or as a typed array."""
    word = NUMPY_WORDS.get(kind.base, kind.base)
    try:
        match value:
            case str():
                return np.frombuffer(b64decode(value, validate=True), "u1").view(word)
            case bytes():
                return np.frombuffer(value, "u1").view(word)
            case np.ndarray():
                return value.astype(word)
            case list():
                # JSON has neither NaN nor infinities: where one stood nothing comes.
                empty = math.nan if kind.base.startswith("float") else 0
                return np.array([empty if item is None else item for item in value], word)
            case _:
                pass
    except (ValueError, TypeError, OverflowError) as error:
        raise FieldError(where, f"is no list of {kind.base}: {error}") from error
    raise FieldError(where, f"expected a list of {kind.base}, found {value!r:.80}")
