"""Whole frames of a WebSocket, cut out of the bytes as they come (RFC 6455, 5.2). Pure.

A message of bytes is nearly always one frame, and nearly all that gateways say is such messages,
thousands a second. These are unmasked here, in a fifth of the time that a parser takes which is
ready for everything; it gets all other frames as they are, each of them whole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

try:
    from websockets.speedups import apply_mask
except ImportError:
    from websockets.utils import apply_mask

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["WholeFrame", "WholeFrames"]

# The first byte of a final frame of bytes, without extensions; in the second, that it is masked.
_BINARY, _MASKED = 0x82, 0x80
# In the first byte: that it is final, and its kind, of which those from 8 on stand by themselves.
_FINAL, _KIND, _CONTROL = 0x80, 0x0F, 8
_MASK_SIZE = 4


class WholeFrame(NamedTuple):
    """One frame: the bytes of a message that is all in it, or else the frame as it came."""

    data: bytes
    is_message: bool


class WholeFrames:
    """Cuts the bytes of one connection. A frame that is too large is passed on as it comes.

    From then on nothing is cut any more: whoever gets it ends the connection.
    """

    def __init__(self, largest: int) -> None:
        """Take frames of at most ``largest`` bytes."""
        self._largest = largest
        # What came of a frame that is not whole yet, and how many bytes it has when it is; 0: that
        # is not known yet.
        self._begun = bytearray()
        self._whole = 0
        self._passing = False
        # A message of several frames has begun: all of it is the parser's.
        self._in_message = False

    def cut(self, data: bytes) -> Iterator[WholeFrame]:
        """Give the frames that are whole with ``data``, in their order."""
        if self._passing:
            yield WholeFrame(data, is_message=False)
            return
        if self._begun:
            self._begun += data
            if len(self._begun) < self._whole:
                return
            data, self._begun = bytes(self._begun), bytearray()
        at, size = 0, len(data)
        while at < size:
            head, length = _read_head(data, at)
            if length > self._largest:
                self._passing = True
                yield WholeFrame(data[at:], is_message=False)
                return
            end = at + head + length
            if not head or end > size:
                self._begun, self._whole = bytearray(data[at:]), end - at
                return
            first, begin = data[at], at + head
            if first == _BINARY and data[at + 1] & _MASKED and not self._in_message:
                mask = data[begin - _MASK_SIZE : begin]
                yield WholeFrame(apply_mask(data[begin:end], mask), is_message=True)
            else:
                if first & _KIND < _CONTROL:
                    self._in_message = not first & _FINAL
                yield WholeFrame(data[at:end], is_message=False)
            at = end


def _read_head(data: bytes, at: int) -> tuple[int, int]:
    """Give how long a frame's head and its payload are; none and nothing: not known yet."""
    known = len(data) - at
    if known < 2:
        return 0, 0
    second = data[at + 1]
    length = second & 0x7F
    # Of two bytes, of eight, or in these seven bits.
    wide = 2 if length == 126 else 8 if length == 127 else 0
    if known < 2 + wide:
        return 0, 0
    if wide:
        length = int.from_bytes(data[at + 2 : at + 2 + wide])
    return 2 + wide + (_MASK_SIZE if second & _MASKED else 0), length
