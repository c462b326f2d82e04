"""The frames between the ROS 1 adapter and its node's process. Pure.

A frame is its length (u32, of what follows), its kind (u8) and its body, little-endian. Kind 0 is
a JSON object with ``op``; kind 1 is a message: the number of its topic (u16), when it came (i64,
µs since the epoch) and its bytes as ROS 1 serialized them. Kind 2 is a piece of a message for the
hub: the number of its tap (u32) and of the kind of its publisher (u16), when it came (i64), the
bytes of the whole message and of the pieces before this one (u32 each), and its bytes.
`rospy_bridge.pipe_frames` has the other end.
"""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any, NamedTuple

from talaia.gateway.errors import AdapterLost

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "MAX_FRAME",
    "FrameSplitter",
    "ReceivedFrame",
    "ReceivedMessage",
    "TappedPiece",
    "frame_of",
]

_HEAD = struct.Struct("<IB")
_STAMP = struct.Struct("<Hq")
_PIECE = struct.Struct("<IHqII")
_JSON, _MESSAGE, _TAPPED = 0, 1, 2
MAX_FRAME = 16 * 1024 * 1024


class ReceivedMessage(NamedTuple):
    """A message of a topic: its number, when it came (µs, UTC), and its bytes."""

    topic: int
    time_us: int
    raw: bytes


class TappedPiece(NamedTuple):
    """A piece of a message of a tap; its kind is as ``tapped_kind`` told it before."""

    tap: int
    kind: int
    time_us: int
    size: int
    at: int
    data: bytes


ReceivedFrame = ReceivedMessage | TappedPiece | dict[str, Any]


def frame_of(said: dict[str, object]) -> bytes:
    """Write a JSON frame."""
    body = json.dumps(said).encode()
    return _HEAD.pack(len(body) + 1, _JSON) + body


class FrameSplitter:
    """Cuts what comes through a pipe into frames."""

    def __init__(self) -> None:
        """Start with nothing waiting."""
        self._waiting = bytearray()

    def split_data(self, data: bytes) -> Iterator[ReceivedFrame]:
        """Take what came and give the frames that are whole.

        Raises:
            AdapterLost: these are no frames of ours.

        """
        self._waiting += data
        start = 0
        try:
            while len(self._waiting) - start >= _HEAD.size:
                size, kind = _HEAD.unpack_from(self._waiting, start)
                if not 1 <= size <= MAX_FRAME:
                    raise AdapterLost(f"ROS 1's node sent a frame of {size} bytes")
                end = start + 4 + size
                if len(self._waiting) < end:
                    break
                body = bytes(self._waiting[start + _HEAD.size : end])
                start = end
                yield _read_frame(kind, body)
        finally:
            del self._waiting[:start]


def _read_frame(kind: int, body: bytes) -> ReceivedFrame:
    if kind == _TAPPED and len(body) >= _PIECE.size:
        tap, of, time_us, size, at = _PIECE.unpack_from(body)
        return TappedPiece(tap, of, time_us, size, at, body[_PIECE.size :])
    if kind == _MESSAGE and len(body) >= _STAMP.size:
        topic, time_us = _STAMP.unpack_from(body)
        return ReceivedMessage(topic, time_us, body[_STAMP.size :])
    if kind == _JSON:
        try:
            said = json.loads(body)
        except (ValueError, RecursionError) as error:
            raise AdapterLost(f"ROS 1's node sent no JSON: {error}") from error
        if isinstance(said, dict) and isinstance(said.get("op"), str):
            return said
    raise AdapterLost("ROS 1's node sent a frame that is none of ours")
