"""Finds whole short messages in what a WebSocket's client sends. Touches no socket itself.

A library's reader of frames goes through each in a dozen steps, for it has to be ready for all that
may come. Nearly all that a gateway sends is one kind: a binary message of some hundred bytes, in
one frame, all of it there at once. Such are cut out here; what is anything else is left as it is,
for that reader.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

try:
    from websockets.speedups import apply_mask
except ImportError:
    from websockets.utils import apply_mask

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["ClientPiece", "FrameCutter"]

# A final frame of bytes; and that a mask stands before the payload (RFC 6455, 5.2).
_BINARY, _MASKED = 0x82, 0x80
_MASK = 4
_MIDDLE, _LONG = struct.Struct("!H"), struct.Struct("!Q")


class ClientPiece(NamedTuple):
    """Bytes of a client, as they came.

    Attributes:
        data: one whole frame, or what has come of one.
        payload: where the payload begins in ``data``, after its mask; 0: it is no short message.

    """

    data: bytes
    payload: int = 0

    @property
    def message(self) -> bytes:
        """The message, of a piece that is one."""
        begin = self.payload
        return apply_mask(self.data[begin:], self.data[begin - _MASK : begin])


class FrameCutter:
    """Cuts what one client sends, from its first frame on."""

    def __init__(self, most: int) -> None:
        """Take messages of up to ``most`` bytes for short ones."""
        self._most = most
        # The begin of a frame that does not tell its length yet: 13 bytes at most.
        self._head = b""
        # So many bytes are still to come of a frame whose begin was given out.
        self._left = 0

    def cut_frames(self, data: bytes) -> Iterator[ClientPiece]:
        """Give the pieces of what has come, in its order; joined they are what came."""
        if self._head:
            data, self._head = self._head + data, b""
        begin = 0
        if self._left:
            begin = min(self._left, len(data))
            self._left -= begin
            yield ClientPiece(data[:begin])
        while begin < len(data):
            payload, size = _frame_head(data, begin)
            if not payload:
                self._head = data[begin:]
                return
            end = begin + payload + size
            # All that is asked of its first bytes: one frame, of bytes, with nothing special.
            plain = data[begin] == _BINARY and data[begin + 1] & _MASKED and size <= self._most
            piece = data[begin:end]
            self._left = max(0, end - len(data))
            yield ClientPiece(piece, payload if plain and not self._left else 0)
            begin = end


def _frame_head(data: bytes, at: int) -> tuple[int, int]:
    """Give how long a frame's head is with its mask, and its payload; 0 if the head is not whole.

    Bytes, both.
    """
    if len(data) - at < 2:
        return 0, 0
    second = data[at + 1]
    size, head = second & 0x7F, 2
    long = {126: _MIDDLE, 127: _LONG}.get(size)
    if long is not None:
        head += long.size
        if len(data) - at < head:
            return 0, 0
        size = long.unpack_from(data, at + 2)[0]
    if second & _MASKED:
        head += _MASK
    # The mask belongs to the head: a message is cut out with it or not at all.
    return (head, size) if len(data) - at >= head else (0, 0)
