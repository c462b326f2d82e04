"""Packets of Socket.IO: events of namespaces, with bytes behind them, to values and back."""

from __future__ import annotations

import json
import re
from enum import IntEnum
from typing import NamedTuple

from talaia.wire.errors import PeerError
from talaia.wire.nested_json import decode_nested

__all__ = ["SocketAssembly", "SocketKind", "SocketPacket", "encode_socket"]

# Bytes of one event (beside its text) come as so many packets at the most, so large together.
_MOST_ATTACHED = 16
_MOST_ATTACHED_BYTES = 1024 * 1024
_LONGEST_NAMESPACE = 200
# Kind, number of attachments, namespace (of old clients with a query), number of the answer.
_HEAD = re.compile(r"([0-6])(?:([0-9]{1,4})-)?(?:(/[^,]*)(?:,|\Z))?([0-9]{1,18})?")


class SocketKind(IntEnum):
    """What a packet is."""

    CONNECT = 0
    DISCONNECT = 1
    EVENT = 2
    ACK = 3
    ERROR = 4
    BINARY_EVENT = 5
    BINARY_ACK = 6


_WITH_BYTES = {SocketKind.BINARY_EVENT: SocketKind.EVENT, SocketKind.BINARY_ACK: SocketKind.ACK}
_BINARY = {kind: binary for binary, kind in _WITH_BYTES.items()}


class SocketPacket(NamedTuple):
    """One packet; never of a binary kind, since its bytes are in ``data``.

    Attributes:
        kind: what it is.
        namespace: with its slash, without a query.
        data: of an event a list, with its name first; None: nothing.
        number: of the answer that is wanted or given.

    """

    kind: SocketKind
    namespace: str = "/"
    data: object = None
    number: int | None = None


def encode_socket(packet: SocketPacket) -> list[str | bytes]:
    """Write a packet: its text, and its bytes behind it; floats in it must be finite.

    All of it is ASCII, since old clients do not agree on how long other letters are.
    """
    attached: list[str | bytes] = []
    data = _detach_bytes(packet.data, attached)
    kind = _BINARY.get(packet.kind, packet.kind) if attached else packet.kind
    text = [str(kind.value)]
    if attached:
        text.append(f"{len(attached)}-")
    if packet.namespace != "/":
        text.append(f"{packet.namespace},")
    if packet.number is not None:
        text.append(str(packet.number))
    if data is not None:
        text.append(json.dumps(data, separators=(",", ":"), allow_nan=False))
    return ["".join(text), *attached]


class SocketAssembly:
    """Reads what one client says; an event waits here until its bytes have come."""

    def __init__(self) -> None:
        """Begin with nothing."""
        # The packet that waits, and what has come of its bytes.
        self._waiting: SocketPacket | None = None
        self._wanted = 0
        self._attached: list[bytes] = []
        self._size = 0

    def add_message(self, message: str | bytes) -> SocketPacket | None:
        """Take a message of Engine.IO; give the packet that is whole now, if one is.

        Raises:
            PeerError: no packet, or bytes that belong to none (code 1002); too many bytes (1009).

        """
        if isinstance(message, bytes):
            return self._add_bytes(message)
        if self._waiting is not None:
            raise PeerError(f"a text where {self._wanted} attachments of an event are awaited")
        packet, wanted = _read_packet(message)
        if not wanted:
            return packet
        if wanted > _MOST_ATTACHED:
            raise PeerError(f"at most {_MOST_ATTACHED} attachments of one event", 1009)
        self._waiting, self._wanted = packet, wanted
        return None

    def _add_bytes(self, data: bytes) -> SocketPacket | None:
        if self._waiting is None:
            raise PeerError("bytes that belong to no event")
        self._size += len(data)
        if self._size > _MOST_ATTACHED_BYTES:
            raise PeerError(f"one event has at most {_MOST_ATTACHED_BYTES} bytes attached", 1009)
        self._attached.append(data)
        if len(self._attached) < self._wanted:
            return None
        packet, attached = self._waiting, self._attached
        self._waiting, self._attached, self._size = None, [], 0
        return packet._replace(data=_attach_bytes(packet.data, attached))


def _read_packet(text: str) -> tuple[SocketPacket, int]:
    """Read a packet's text; give with it how many attachments follow."""
    head = _HEAD.match(text)
    if head is None:
        raise PeerError(f"a packet begins with a digit from 0 to 6, not {text[:20]!r}")
    kind = SocketKind(int(head[1]))
    # Old clients put a query behind it, as in an address.
    namespace = (head[3] or "/").partition("?")[0]
    if len(namespace) > _LONGEST_NAMESPACE:
        raise PeerError(f"a namespace has at most {_LONGEST_NAMESPACE} letters")
    rest = text[head.end() :]
    try:
        data = decode_nested(rest) if rest else None
    except ValueError as error:
        raise PeerError(
            f"what follows {head[0][:100]!r} is no JSON that is read here: {str(error)[:200]}"
        ) from error
    plain = _WITH_BYTES.get(kind, kind)
    if plain is SocketKind.EVENT and not _names_event(data):
        raise PeerError("an event is a list that begins with its name")
    if (head[2] is not None) != (plain is not kind):
        raise PeerError(f"attachments go with kinds 5 and 6 alone, not with {kind.value}")
    number = int(head[4]) if head[4] else None
    return SocketPacket(plain, namespace, data, number), int(head[2] or 0)


def _names_event(data: object) -> bool:
    # Some clients number their events.
    return isinstance(data, list) and bool(data) and isinstance(data[0], str | int)


def _detach_bytes(value: object, attached: list[str | bytes]) -> object:
    match value:
        case bytes():
            attached.append(value)
            return {"_placeholder": True, "num": len(attached) - 1}
        case list() | tuple():
            return [_detach_bytes(item, attached) for item in value]
        case dict():
            return {name: _detach_bytes(item, attached) for name, item in value.items()}
        case _:
            return value


def _attach_bytes(value: object, attached: list[bytes]) -> object:
    match value:
        case {"_placeholder": True, "num": int(number)}:
            if not 0 <= number < len(attached):
                raise PeerError(f"there is no attachment {number}")
            return attached[number]
        case list():
            return [_attach_bytes(item, attached) for item in value]
        case dict():
            return {name: _attach_bytes(item, attached) for name, item in value.items()}
        case _:
            return value
