"""CBOR (RFC 8949) as rosbridge writes it, with typed arrays (RFC 8746), to message objects. Pure.

Only reading, and only what a message can hold: numbers, texts, bytes, lists and maps with text
keys. Every length is held against what is there before anything is made of it.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

import numpy as np

from talaia.gateway.errors import FieldError

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["read_cbor"]

_MAX_DEPTH = 32
_FLOATS = {25: ">e", 26: ">f", 27: ">d"}
_SIMPLE: dict[int, object] = {20: False, 21: True, 22: None, 23: None}
# Tags of typed arrays: RFC 8746, section 2.1. All are little-endian but for single bytes.
_ARRAYS = {
    64: "u1",
    68: "u1",
    69: "<u2",
    70: "<u4",
    71: "<u8",
    72: "i1",
    77: "<i2",
    78: "<i4",
    79: "<i8",
    84: "<f2",
    85: "<f4",
    86: "<f8",
}


def read_cbor(data: bytes, make: Callable[[dict[str, object]], object]) -> object:
    """Read one item; each map goes through ``make``.

    Raises:
        FieldError: it is not CBOR, or holds what no message does.

    """
    reader = _Reader(data, make)
    try:
        value = reader.read_item(0)
    except (IndexError, struct.error, UnicodeDecodeError, ValueError) as error:
        raise FieldError("", f"is not CBOR: {error}") from error
    if reader.at != len(data):
        raise FieldError("", "is not CBOR: there is more behind it")
    return value


class _Reader:
    def __init__(self, data: bytes, make: Callable[[dict[str, object]], object]) -> None:
        self._data = data
        self._make = make
        self.at = 0

    def read_item(self, depth: int) -> object:
        """Read the next item."""
        if depth > _MAX_DEPTH:
            raise ValueError("it is nested too deeply")
        first = self._data[self.at]
        self.at += 1
        major, low = first >> 5, first & 31
        if major == 7:
            return self._read_simple(low)
        number = self._read_number(low)
        match major:
            case 0:
                return number
            case 1:
                return -1 - number
            case 2:
                return self._read_bytes(number)
            case 3:
                return self._read_bytes(number).decode()
            case 4:
                # An item takes a byte at least, so a length beyond the rest is a lie.
                self._check_length(number)
                return [self.read_item(depth + 1) for _ in range(number)]
            case 5:
                self._check_length(number)
                return self._make(dict(self._read_pair(depth) for _ in range(number)))
            case _:
                return self._read_tagged(number, self.read_item(depth + 1))

    def _read_number(self, low: int) -> int:
        if low < 24:
            return low
        if low > 27:
            raise ValueError("a length that is not told beforehand")
        return int.from_bytes(self._read_bytes(1 << (low - 24)), "big")

    def _read_bytes(self, count: int) -> bytes:
        self._check_length(count)
        self.at += count
        return self._data[self.at - count : self.at]

    def _check_length(self, count: int) -> None:
        if count > len(self._data) - self.at:
            raise ValueError("it is cut off")

    def _read_pair(self, depth: int) -> tuple[str, object]:
        key = self.read_item(depth + 1)
        if not isinstance(key, str):
            raise ValueError("a key that is no text")  # noqa: TRY004 - about the data
        return key, self.read_item(depth + 1)

    def _read_simple(self, low: int) -> object:
        if low in _FLOATS:
            kind = _FLOATS[low]
            return struct.unpack(kind, self._read_bytes(struct.calcsize(kind)))[0]
        if low not in _SIMPLE:
            raise ValueError(f"a simple value {low}")
        return _SIMPLE[low]

    def _read_tagged(self, tag: int, value: object) -> object:
        kind = _ARRAYS.get(tag)
        if kind is not None and isinstance(value, bytes):
            return np.frombuffer(value, kind)
        # Other tags say how to look at a value, not what it is.
        return value
