"""Messages of a gateway's media connection, put together from their pieces. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from talaia.wire.frames import TapMessage

__all__ = ["PieceReassembly"]

# Bytes of messages that are not whole yet; a gateway sends a few at a time.
_MOST_OPEN = 64 * 1024 * 1024


class PieceReassembly:
    """The messages of one connection that are under way, one for each topic at the most."""

    def __init__(self) -> None:
        """Begin with none."""
        # By the topic's number: the pieces so far, and their bytes.
        self._open: dict[int, tuple[list[bytes], int]] = {}
        self._bytes = 0

    def add_piece(self, piece: TapMessage) -> bytes | None:
        """Take a piece; give the whole message when this was its last.

        A message whose beginning was not heard is left out, as is one that another cuts short.

        Raises:
            PeerError: the pieces make no message, or too much is under way.

        """
        if piece.at == 0:
            self.forget_topic(piece.number)
            if len(piece.data) == piece.size:
                return piece.data
            pieces: list[bytes] = []
            have = 0
        elif piece.number in self._open:
            pieces, have = self._open[piece.number]
        else:
            return None
        have += len(piece.data)
        if piece.at != have - len(piece.data) or have > piece.size or not piece.data:
            raise PeerError("pieces that make no message")
        pieces.append(piece.data)
        self._bytes += len(piece.data)
        if self._bytes > _MOST_OPEN:
            raise PeerError("too many messages at once that are not whole", 1009)
        self._open[piece.number] = pieces, have
        if have < piece.size:
            return None
        self.forget_topic(piece.number)
        return b"".join(pieces)

    def forget_topic(self, number: int) -> None:
        """Forget the message of a topic that is under way."""
        _, have = self._open.pop(number, ((), 0))
        self._bytes -= have

    def clear(self) -> None:
        """Forget all: the connection is another one."""
        self._open.clear()
        self._bytes = 0
