"""A WebSocket message of a server, with its frame written once for everybody who gets it. Pure."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["FRAME_WRITER", "SocketFrame", "frame_writer_of"]

# The extension of ASGI by which a `SocketFrame` is written at once: {"write": a function that
# gives False where it cannot, and has done nothing then}.
FRAME_WRITER = "talaia.frame_writer"

# A final frame of text and one of bytes, and after them how its length is written (RFC 6455, 5.2).
_TEXT, _BINARY = 0x81, 0x82
_SHORT, _MIDDLE, _LONG = struct.Struct("!BB"), struct.Struct("!BBH"), struct.Struct("!BBQ")


class SocketFrame:
    """One message; ``len`` of it is what it weighs.

    A server's frames are not masked (RFC 6455, 5.1), so that without compression the same bytes go
    to each connection.

    Attributes:
        data: the message, bytes or text.

    """

    # One for each message that a page is sent: small.
    __slots__ = ("_framed", "data")

    def __init__(self, data: bytes | str) -> None:
        """Hold a message."""
        self.data = data
        self._framed: bytes | None = None

    def __len__(self) -> int:
        """Give its length (bytes, or letters of a text)."""
        return len(self.data)

    @property
    def framed(self) -> bytes:
        """The one frame that carries all of it, as it is written to a socket."""
        # Only when somebody can be sent it so: a large message is cut into several frames.
        if self._framed is None:
            self._framed = _frame_message(self.data)
        return self._framed


def frame_writer_of(
    extensions: Mapping[str, Mapping[str, Callable[[SocketFrame], bool]]],
) -> Callable[[SocketFrame], bool] | None:
    """Give the function that `FRAME_WRITER` offers among a socket's ASGI extensions, or none."""
    return extensions.get(FRAME_WRITER, {}).get("write")


def _frame_message(data: bytes | str) -> bytes:
    kind, payload = (_TEXT, data.encode()) if isinstance(data, str) else (_BINARY, data)
    size = len(payload)
    if size < 126:
        return _SHORT.pack(kind, size) + payload
    if size < 65_536:
        return _MIDDLE.pack(kind, 126, size) + payload
    return _LONG.pack(kind, 127, size) + payload
