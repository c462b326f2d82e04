"""Packets of Engine.IO 3 and 4: one in each WebSocket frame, several in a polled body."""

from __future__ import annotations

import base64
import binascii
import re
import struct
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = [
    "MAX_SOCKETIO_BODY",
    "EngineKind",
    "EnginePacket",
    "EngineRevision",
    "decode_body",
    "decode_frame",
    "encode_body",
    "encode_frame",
]

# Of a client: a frame, or the body of a request (bytes).
MAX_SOCKETIO_BODY = 1024 * 1024
# In one body: each costs more than its few letters.
_MOST_PACKETS = 1000
# Revision 4 puts this between the packets of a body.
_SEPARATOR = "\x1e"
# Revision 3, of bodies with bytes: what a packet is, and the end of its length.
_AS_TEXT, _AS_BYTES, _LENGTH_END = 0, 1, 0xFF
_MOST_DIGITS = 8
_LENGTH = re.compile(r"([0-9]{1,8}):")


class EngineRevision(IntEnum):
    """Which Engine.IO a client speaks, as ``EIO`` in its address."""

    OLD = 3
    NEW = 4


class EngineKind(IntEnum):
    """What a packet is."""

    OPEN = 0
    CLOSE = 1
    PING = 2
    PONG = 3
    MESSAGE = 4
    UPGRADE = 5
    NOOP = 6


class EnginePacket(NamedTuple):
    """One packet; only a message may be bytes."""

    kind: EngineKind
    data: str | bytes = ""


def encode_frame(packet: EnginePacket, revision: EngineRevision) -> str | bytes:
    """Write a packet as a WebSocket frame."""
    if isinstance(packet.data, str):
        return f"{packet.kind.value}{packet.data}"
    # What is no text is a message; the old revision says so once more.
    return packet.data if revision is EngineRevision.NEW else bytes((packet.kind,)) + packet.data


def decode_frame(frame: str | bytes, revision: EngineRevision) -> EnginePacket:
    """Read a WebSocket frame.

    Raises:
        PeerError: it is no packet (code 1002), or too large (1009).

    """
    _check_size(len(frame))
    if isinstance(frame, str):
        return _read_text(frame)
    if revision is EngineRevision.NEW:
        return EnginePacket(EngineKind.MESSAGE, frame)
    if not frame or frame[0] != EngineKind.MESSAGE:
        raise PeerError(f"bytes are a message, which begins with 4, not {frame[:1]!r}")
    return EnginePacket(EngineKind.MESSAGE, frame[1:])


def encode_body(
    packets: Iterable[EnginePacket], revision: EngineRevision, *, as_text: bool
) -> bytes:
    """Write packets as the body of an answer.

    Args:
        packets: at least one.
        revision: the client's.
        as_text: the client of the old revision asked for text alone (``b64=1``).

    """
    if revision is EngineRevision.NEW:
        return _SEPARATOR.join(map(_base64_packet, packets)).encode()
    if as_text:
        # The length counts letters. What is sent here is ASCII: clients count others differently.
        texts = (_base64_packet(packet, old=True) for packet in packets)
        return "".join(f"{len(text)}:{text}" for text in texts).encode()
    body = bytearray()
    for packet in packets:
        frame = encode_frame(packet, revision)
        body.append(_AS_TEXT if isinstance(frame, str) else _AS_BYTES)
        content = frame.encode() if isinstance(frame, str) else frame
        body.extend(int(digit) for digit in str(len(content)))
        body.append(_LENGTH_END)
        body += content
    return bytes(body)


def decode_body(body: bytes, revision: EngineRevision) -> list[EnginePacket]:
    """Read the body of a client's request.

    Raises:
        PeerError: it is no such body (code 1002), or too large (1009).

    """
    _check_size(len(body))
    packets: list[EnginePacket] = []
    if revision is EngineRevision.OLD and body[:1] in {b"\x00", b"\x01"}:
        found = _split_bytes(body)
    else:
        try:
            text = body.decode()
        except UnicodeDecodeError as error:
            raise PeerError(f"a body that is no UTF-8: {error}") from error
        found = (
            _split_old_text(text)
            if revision is EngineRevision.OLD
            else map(_read_packet, text.split(_SEPARATOR, _MOST_PACKETS))
        )
    for packet in found:
        if len(packets) >= _MOST_PACKETS:
            raise PeerError(f"more than {_MOST_PACKETS} packets in one body", 1009)
        packets.append(packet)
    return packets


def _base64_packet(packet: EnginePacket, *, old: bool = False) -> str:
    if isinstance(packet.data, str):
        return f"{packet.kind.value}{packet.data}"
    kind = str(packet.kind.value) if old else ""
    return f"b{kind}{base64.b64encode(packet.data).decode()}"


def _read_text(text: str) -> EnginePacket:
    try:
        # One digit of ASCII; `int` takes those of other scripts, too.
        return EnginePacket(EngineKind("0123456".index(text[0])), text[1:])
    except (IndexError, ValueError):
        raise PeerError(f"a packet begins with a digit from 0 to 6, not {text[:20]!r}") from None


def _read_packet(text: str, *, old: bool = False) -> EnginePacket:
    """Read a packet of a body, in which bytes are base64."""
    if not text.startswith("b"):
        return _read_text(text)
    if old and not text.startswith("b4"):
        raise PeerError(f"bytes are a message, which begins with b4, not {text[:20]!r}")
    try:
        data = base64.b64decode(text[2 if old else 1 :], validate=True)
    except (binascii.Error, ValueError) as error:
        raise PeerError(f"bytes that are no base64: {error}") from error
    return EnginePacket(EngineKind.MESSAGE, data)


def _split_old_text(text: str) -> Iterator[EnginePacket]:
    # Lengths count the units of UTF-16, as JavaScript does: a smiley is two.
    wide = not text.isascii() and max(text) > "\uffff"
    units = _split_surrogates(text) if wide else text
    at = 0
    while at < len(units):
        length = _LENGTH.match(units, at)
        if length is None:
            raise PeerError(f"a packet begins with its length and a colon, not {units[at:][:20]!r}")
        end = length.end() + int(length[1])
        if end > len(units):
            raise PeerError(f"a packet of {length[1]} letters, of which {len(units) - at} came")
        packet = units[length.end() : end]
        yield _read_packet(_join_surrogates(packet) if wide else packet, old=True)
        at = end


def _split_surrogates(text: str) -> str:
    encoded = text.encode("utf-16-le")
    return "".join(map(chr, struct.unpack(f"<{len(encoded) // 2}H", encoded)))


def _join_surrogates(units: str) -> str:
    try:
        return units.encode("utf-16-le", "surrogatepass").decode("utf-16-le")
    except UnicodeDecodeError as error:
        raise PeerError("a packet that ends in the middle of a letter") from error


def _split_bytes(body: bytes) -> Iterator[EnginePacket]:
    at = 0
    while at < len(body):
        kind = body[at]
        end = body.find(_LENGTH_END, at, at + _MOST_DIGITS + 2)
        digits = body[at + 1 : end]
        if kind not in {_AS_TEXT, _AS_BYTES} or end < 0 or not digits or max(digits) > 9:
            raise PeerError(f"a packet begins with 0 or 1 and its length, not {body[at:][:10]!r}")
        start = end + 1
        at = start + int("".join(map(str, digits)))
        if at > len(body):
            raise PeerError(f"a packet of {at - start} bytes, of which {len(body) - start} came")
        content = body[start:at]
        if kind == _AS_BYTES:
            yield decode_frame(content, EngineRevision.OLD)
            continue
        try:
            yield _read_text(content.decode())
        except UnicodeDecodeError as error:
            raise PeerError(f"a packet that is no UTF-8: {error}") from error


def _check_size(size: int) -> None:
    if size > MAX_SOCKETIO_BODY:
        raise PeerError(f"{size} bytes are over the limit of {MAX_SOCKETIO_BODY}", 1009)
