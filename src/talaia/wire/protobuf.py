"""Protocol Buffers' wire format: fields by their numbers, without a compiler of descriptions.

By https://protobuf.dev/programming-guides/encoding/: two small messages of others (Prometheus's
remote read, Sparkplug's payload) do not need a library whose messages are generated code.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "bytes_field",
    "double_field",
    "encode_varint",
    "float_field",
    "read_bytes",
    "read_fields",
    "read_text",
    "read_whole",
    "signed_64",
    "varint_field",
]

_VARINT, _FIXED_64, _BYTES, _FIXED_32 = 0, 1, 2, 5
_FIXED_SIZES = {_FIXED_64: 8, _FIXED_32: 4}
_MASK_64 = 2**64 - 1
# Seven bits in each byte: a number of 64 bits takes ten.
_MOST_VARINT = 10


def read_fields(data: bytes) -> Iterator[tuple[int, int | bytes]]:
    """Go through the fields of a message: numbers of varints, bytes of all other kinds.

    Raises:
        PeerError: it is cut off, or none.

    """
    at = 0
    while at < len(data):
        key, at = _read_varint(data, at)
        number, kind = key >> 3, key & 7
        if not number:
            raise PeerError("a field of protobuf has the number 0")
        if kind == _VARINT:
            value, at = _read_varint(data, at)
            yield number, value
            continue
        if kind == _BYTES:
            size, at = _read_varint(data, at)
        elif kind in _FIXED_SIZES:
            size = _FIXED_SIZES[kind]
        else:
            raise PeerError(f"field {number} of protobuf is of the unknown kind {kind}")
        if size > len(data) - at:
            raise PeerError(f"field {number} of protobuf is cut off")
        yield number, data[at : at + size]
        at += size


def read_whole(value: int | bytes) -> int:
    """Give a field that has to be a number.

    Raises:
        PeerError: it is none.

    """
    if isinstance(value, bytes):
        raise PeerError("a field of protobuf has bytes where a number belongs")
    return value


def read_bytes(value: int | bytes) -> bytes:
    """Give a field that has to be bytes.

    Raises:
        PeerError: it is none.

    """
    if isinstance(value, int):
        raise PeerError("a field of protobuf has a number where bytes belong")
    return value


def read_text(value: int | bytes) -> str:
    """Give a field that has to be a text.

    Raises:
        PeerError: it is none.

    """
    try:
        return read_bytes(value).decode()
    except UnicodeDecodeError as error:
        raise PeerError("a text of protobuf is not UTF-8") from error


def signed_64(value: int) -> int:
    """Give a signed number of 64 bits, which stands in a varint as its two's complement."""
    return value - 2**64 if value >= 2**63 else value


def encode_varint(value: int) -> bytes:
    """Write a number of at most 64 bits; a negative one as its two's complement."""
    value &= _MASK_64
    written = bytearray()
    while value > 0x7F:
        written.append(value & 0x7F | 0x80)
        value >>= 7
    written.append(value)
    return bytes(written)


def varint_field(number: int, value: int) -> bytes:
    """Write a field with a whole number or a truth value."""
    return encode_varint(number << 3 | _VARINT) + encode_varint(value)


def bytes_field(number: int, value: bytes | str) -> bytes:
    """Write a field with bytes, a text or another message."""
    data = value.encode() if isinstance(value, str) else value
    return encode_varint(number << 3 | _BYTES) + encode_varint(len(data)) + data


def double_field(number: int, value: float) -> bytes:
    """Write a field with a number of 64 bits."""
    return encode_varint(number << 3 | _FIXED_64) + struct.pack("<d", value)


def float_field(number: int, value: float) -> bytes:
    """Write a field with a number of 32 bits."""
    return encode_varint(number << 3 | _FIXED_32) + struct.pack("<f", value)


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for place in range(_MOST_VARINT):
        if at + place >= len(data):
            raise PeerError("a number of protobuf is cut off")
        byte = data[at + place]
        value |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return value & _MASK_64, at + place + 1
    raise PeerError("a number of protobuf has more than 64 bits")
