"""Messages written by their definitions: an object to fill, and its bytes."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from talaia.gateway.adapters.ros2.type_definitions.message_decoder import compiled_store
from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    BadDefinition,
    FieldForm,
    FieldType,
    TypeDefinition,
)
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

__all__ = ["NUMPY_WORDS", "MessageEncoder"]

# numpy's words where they are others.
NUMPY_WORDS = {"bool": "bool", "byte": "uint8", "char": "uint8"}
# Memory that one array of a request may take.
_MAX_ELEMENTS = 1_000_000


class MessageEncoder:
    """Writes messages of one type."""

    def __init__(self, definition: TypeDefinition) -> None:
        """Compile a checked definition.

        Raises:
            BadDefinition: it has wide texts, which are not written here; or it is too large.

        """
        for name, part in definition.parts.items():
            for field in part.fields:
                # rosbags has no wide texts; they are read by a detour that does not lead back.
                if field.type.base == "wstring":
                    raise BadDefinition(f"{name}.{field.name}: wide texts cannot be sent")
                if field.type.form is FieldForm.ARRAY and field.type.size > _MAX_ELEMENTS:
                    raise BadDefinition(f"{name}.{field.name}: too large to be sent")
        self._definition = definition
        self._store: Typestore = compiled_store(definition)

    def new_message(self) -> Any:  # noqa: ANN401 - a class of rosbags' making
        """Give a message with 0, false, empty texts and empty lists in it."""
        return self._new_part(self._definition.name)

    def encode_message(self, message: object) -> bytes:
        """Give its bytes, with the header of CDR.

        Raises:
            FieldError: a value does not fit its field.

        """
        try:
            return bytes(self._store.serialize_cdr(message, self._definition.name))
        except (struct.error, ValueError, TypeError, AttributeError) as error:
            raise FieldError("", f"a value does not fit its field: {error}") from error

    def _new_part(self, name: str) -> Any:  # noqa: ANN401
        fields = self._definition.parts[name].fields
        # rosbags gives an empty message the byte that ROS gives it.
        if not fields:
            return self._store.types[name](0)
        return self._store.types[name](*(self._empty_value(field.type) for field in fields))

    def _empty_value(self, kind: FieldType) -> Any:  # noqa: ANN401
        plain = kind.base in TYPE_IDS and kind.base != "string"
        match kind.form:
            case FieldForm.ONE:
                return self._empty_element(kind.base)
            case FieldForm.ARRAY if plain:
                return np.zeros(kind.size, NUMPY_WORDS.get(kind.base, kind.base))
            case FieldForm.ARRAY:
                return [self._empty_element(kind.base) for _ in range(kind.size)]
            case _:
                return np.zeros(0, NUMPY_WORDS.get(kind.base, kind.base)) if plain else []

    def _empty_element(self, base: str) -> Any:  # noqa: ANN401
        if base not in TYPE_IDS:
            return self._new_part(base)
        if base == "string":
            return ""
        if base == "bool":
            return False
        return 0.0 if base.startswith("float") else 0
