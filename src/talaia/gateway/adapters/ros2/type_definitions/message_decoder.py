"""Messages decoded by their definitions: `rosbags` compiles a decoder for each type."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, cast

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_typestore

from talaia.gateway.adapters.ros2.type_definitions.message_definition import (
    TYPE_IDS,
    BadDefinition,
    FieldForm,
    FieldType,
    TypeDefinition,
)
from talaia.gateway.errors import FieldError
from talaia.ros_definitions import OutOfBounds, check_names

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray
    from rosbags.interfaces.typing import BaseDesc, FieldDesc, NameDesc, Typesdict
    from rosbags.typesys.store import Typestore

__all__ = ["compiled_store", "decoder_of"]

# rosbags has no texts of wide characters. On the wire they are a sequence of UTF-16 units of four
# bytes each, so they are read as a message of one, whose class makes a text of them.
_WIDE = "talaia/msg/WideText"
_LITTLE = b"\x00\x01"


def decoder_of(
    definition: TypeDefinition, *, proven: bool, store: Typestore | None = None
) -> Callable[[bytes], object]:
    """Compile a decoder of a checked definition.

    It gives an object with the message's fields: numbers, texts, numpy arrays, lists of objects;
    and raises `FieldError` for bytes that are no such message.

    Args:
        definition: see `TypeDefinition.checked`.
        proven: its hash is the publisher's. If not, bytes that are left over are an error: then it
            is another version's.
        store: of `compiled_store`, where there is one already.

    Raises:
        BadDefinition: it cannot be compiled.

    """
    return _decoder(store or compiled_store(definition), definition.name, proven=proven)


def compiled_store(definition: TypeDefinition) -> Typestore:
    """Compile a checked definition for rosbags.

    Raises:
        BadDefinition: it cannot be compiled.

    """
    store = get_typestore(Stores.EMPTY)
    # What it brings may differ from what the robot has.
    store.types.clear()
    store.fielddefs.clear()
    types: dict[str, object] = {
        name: (
            [],
            [(field.name, _described(field.type)) for field in part.fields],
        )
        for name, part in definition.parts.items()
    }
    types[_WIDE] = ([], [("units", (Nodetype.SEQUENCE, ((Nodetype.BASE, ("uint32", 0)), 0)))])
    try:
        # A robot's word, or a file's: rosbags runs what it writes of it.
        check_names(cast("Typesdict", types))
        store.register(cast("Typesdict", types))
        store.types[_WIDE] = cast("Any", _wide_text)
        store.get_msgdef(definition.name)
    except (OutOfBounds, TypesysError, SyntaxError, KeyError, RecursionError) as error:
        raise BadDefinition(f"{definition.name[:200]!r} cannot be decoded: {error}") from error
    return store


def _decoder(store: Typestore, name: str, *, proven: bool) -> Callable[[bytes], object]:
    # Looked up once: this runs for each message.
    decode = store.deserialize_cdr
    decoders = store.get_msgdef(name)

    def read(data: bytes) -> object:
        try:
            if not proven:
                return decode(data, name)
            # Not `decode`: ROS counts too many bytes for some sequences and for wide texts, and
            # sends what lies behind them, too.
            if data[:2] == _LITTLE:
                return decoders.deserialize_cdr_le(data[4:], 0, decoders.cls, store)[0]
            return decoders.deserialize_cdr_be(data[4:], 0, decoders.cls, store)[0]
        except (SerdeError, struct.error, ValueError, MemoryError) as error:
            raise FieldError("", f"what came is not a {name}: {error}") from error

    return read


def _described(kind: FieldType) -> FieldDesc:
    inner: BaseDesc | NameDesc
    if kind.base == "wstring":
        inner = (Nodetype.NAME, _WIDE)
    elif kind.base in TYPE_IDS:
        # rosbags has signed bytes in arrays.
        word = "uint8" if kind.base == "byte" else kind.base
        inner = cast("BaseDesc", (Nodetype.BASE, (word, kind.text_bound)))
    else:
        inner = (Nodetype.NAME, kind.base)
    match kind.form:
        case FieldForm.ONE:
            return inner
        case FieldForm.ARRAY:
            return (Nodetype.ARRAY, (inner, kind.size))
        case _:
            return (Nodetype.SEQUENCE, (inner, kind.size))


def _wide_text(units: NDArray[np.uint32]) -> str:
    # Two units may be one character, so they are joined as what they are.
    return units.astype("<u2").tobytes().decode("utf-16-le", "replace")
