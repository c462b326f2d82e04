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
    MessageField,
    TypeDefinition,
)
from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from rosbags.typesys.store import Typestore

__all__ = ["NUMPY_WORDS", "MessageEncoder"]

# numpy's words where they are others.
NUMPY_WORDS = {"bool": "bool", "byte": "uint8", "char": "uint8"}
_TEXTS = ("string", "wstring")
# Memory that one array of a request may take.
_MAX_ELEMENTS = 1_000_000


class MessageEncoder:
    """Writes messages of one type."""

    def __init__(self, definition: TypeDefinition) -> None:
        """Compile a checked definition.

        Raises:
            BadDefinition: it is too large.

        """
        for name, part in definition.parts.items():
            for field in part.fields:
                if field.type.form is FieldForm.ARRAY and field.type.size > _MAX_ELEMENTS:
                    raise BadDefinition(f"{name}.{field.name}: too large to be sent")
        self._definition = definition
        self._store: Typestore = compiled_store(definition)
        # rosbags has no wide texts: before it writes, they become what it has in their place.
        self._wide = any(
            field.type.base == "wstring"
            for part in definition.parts.values()
            for field in part.fields
        )

    def new_message(self) -> Any:  # noqa: ANN401 - a class of rosbags' making
        """Give a message with 0, false, empty texts and empty lists in it."""
        return self._new_part(self._definition.name)

    def encode_message(self, message: object) -> bytes:
        """Give its bytes, with the header of CDR.

        Raises:
            FieldError: a value does not fit its field.

        """
        if self._wide:
            self._widen_texts(message, self._definition.name)
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

    def _widen_texts(self, message: Any, part: str) -> None:  # noqa: ANN401
        for field in self._definition.parts[part].fields:
            kind = field.type
            if kind.base in TYPE_IDS and kind.base != "wstring":
                continue
            value = getattr(message, field.name, None)
            one = kind.form is FieldForm.ONE
            try:
                values = [value] if one else list(value or ())
            except TypeError as error:
                raise FieldError(field.name, f"expected a list, found {value!r}") from error
            if kind.base != "wstring":
                for inner in values:
                    self._widen_texts(inner, kind.base)
                continue
            wide = [_widened(text, field) for text in values]
            setattr(message, field.name, wide[0] if one else wide)

    def _empty_value(self, kind: FieldType) -> Any:  # noqa: ANN401
        plain = kind.base in TYPE_IDS and kind.base not in _TEXTS
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
        if base in _TEXTS:
            return ""
        if base == "bool":
            return False
        return 0.0 if base.startswith("float") else 0


class _WideText(str):
    """A text as rosbags writes a wide one: a message of one sequence, see `message_decoder`."""

    __slots__ = ("units",)
    units: NDArray[np.uint32]


def _widened(text: object, field: MessageField) -> _WideText:
    if not isinstance(text, str):
        raise FieldError(field.name, f"expected a text, found {text!r}")
    wide = _WideText(text)
    # Half of a pair is no character, and yet what a wide text of ROS may hold.
    units = np.frombuffer(text.encode("utf-16-le", "surrogatepass"), "<u2")
    bound = field.type.text_bound
    if bound and len(units) > bound:
        raise FieldError(field.name, f"a text of {len(units)} characters, and at most {bound} fit")
    wide.units = units.astype(np.uint32)
    return wide
