"""Values to CBOR (RFC 8949), arrays of numbers with the tags of RFC 8746. Written only.

rosbridge clients say JSON alone, so nothing here reads CBOR.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np

__all__ = ["encode_cbor"]

_UNSIGNED, _NEGATIVE, _BYTES, _TEXT, _ARRAY, _MAP, _TAG = (kind << 5 for kind in range(7))
_FALSE, _TRUE, _NULL = b"\xf4", b"\xf5", b"\xf6"
_DOUBLE = struct.Struct(">Bd")
_DOUBLE_HEAD = 0xFB
# The head's low bits say how the number after it is written.
_SHORT, _HEADS = 24, ((1, ">BB"), (2, ">BH"), (4, ">BI"), (8, ">BQ"))
# Little-endian arrays by numpy's kind and width; `bytes` stand for those of unsigned bytes.
_ARRAY_TAGS = {
    "u2": 69,
    "u4": 70,
    "u8": 71,
    "i1": 72,
    "i2": 77,
    "i4": 78,
    "i8": 79,
    "f4": 85,
    "f8": 86,
}


def encode_cbor(value: object) -> bytes:
    """Write a value.

    Args:
        value: None, booleans, numbers, texts, bytes, lists, tuples, numpy arrays of one dimension,
            and mappings of these.

    Raises:
        TypeError: it is or holds something else.
        OverflowError: a whole number of more than 64 bits.

    """
    written = bytearray()
    _write_value(written, value)
    return bytes(written)


def _write_value(written: bytearray, value: object) -> None:
    match value:
        case None:
            written += _NULL
        case bool() | np.bool_():
            written += _TRUE if value else _FALSE
        case int() | np.integer():
            _write_integer(written, int(value))
        case float() | np.floating():
            written += _DOUBLE.pack(_DOUBLE_HEAD, float(value))
        case str():
            # ROS texts may be any bytes; what is no UTF-8 becomes a replacement character.
            text = value.encode("utf-8", "replace")
            _write_head(written, _TEXT, len(text))
            written += text
        case bytes() | bytearray() | memoryview():
            _write_head(written, _BYTES, len(value))
            written += value
        case np.ndarray():
            form = f"{value.dtype.kind}{value.dtype.itemsize}"
            if form == "u1":
                _write_value(written, value.tobytes())
            elif form in _ARRAY_TAGS:
                _write_head(written, _TAG, _ARRAY_TAGS[form])
                _write_value(written, np.ascontiguousarray(value, f"<{form}").tobytes())
            else:
                _write_value(written, value.tolist())
        case list() | tuple():
            _write_head(written, _ARRAY, len(value))
            for item in value:
                _write_value(written, item)
        case Mapping():
            _write_head(written, _MAP, len(value))
            for key, item in value.items():
                _write_value(written, key)
                _write_value(written, item)
        case _:
            raise TypeError(f"{type(value).__name__} has no CBOR")


def _write_head(written: bytearray, kind: int, number: int) -> None:
    if number < _SHORT:
        written.append(kind | number)
        return
    for at, (width, form) in enumerate(_HEADS):
        if number < 1 << (8 * width):
            written += struct.pack(form, kind | (_SHORT + at), number)
            return
    raise OverflowError(f"{number} has more than 64 bits")


def _write_integer(written: bytearray, number: int) -> None:
    if number >= 0:
        _write_head(written, _UNSIGNED, number)
    else:
        _write_head(written, _NEGATIVE, -1 - number)
