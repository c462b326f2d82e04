"""WebSockets as uvicorn serves them; a large message lets others pass between its pieces."""

from __future__ import annotations

import asyncio
import struct
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.utils import ClientDisconnected
from websockets.exceptions import InvalidState
from websockets.protocol import State

from talaia.bounded_http import EndingSocketProtocol

if TYPE_CHECKING:
    from uvicorn._types import ASGISendEvent

    from talaia.hub.api.server.proxy_protocol import Asker

__all__ = ["LARGEST_PIECE", "HubSocketProtocol"]

# Bytes of a frame: so many are encrypted and written in less than 0.1 ms, a megabyte takes 2 to 3
# ms of the one loop, in which no driving frame of anybody goes on. What is encrypted stays in the
# processor's cache, too.
LARGEST_PIECE = 64 * 1024
_FINAL_BINARY = 0x82
_MIDDLE, _LONG = struct.Struct("!BBH"), struct.Struct("!BBQ")


class HubSocketProtocol(EndingSocketProtocol):
    """One WebSocket. Binary messages beyond `LARGEST_PIECE` are sent as several frames.

    That is what RFC 6455 (5.4) has fragments for: answers to pings go between them, and every
    client puts them together.
    """

    def __init__(self, *args: Any, asker: Asker | None = None, **kwargs: Any) -> None:  # noqa: ANN401 - uvicorn's own
        """Serve a connection; ``asker`` is who comes, where that is not the socket's other end."""
        super().__init__(*args, **kwargs)
        self._asker = asker
        # Messages of one socket are sent by several tasks: no other may begin within one.
        self._turn = asyncio.Lock()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin."""
        super().connection_made(transport)
        self.client = self._asker or self.client

    async def send(self, message: ASGISendEvent) -> None:
        """Send a message, as ASGI has it."""
        data = message.get("bytes") if message["type"] == "websocket.send" else None
        if isinstance(data, bytes) and self._may_write_at_once(len(data)):
            self.transport.write(_frame_head(len(data)) + data)
            return
        if not isinstance(data, bytes) or len(data) <= LARGEST_PIECE:
            if self.writable.is_set() and not self._turn.locked():
                # Nearly all there is: written before anybody else has a turn, so it needs none.
                await super().send(message)
                return
            async with self._turn:
                await super().send(message)
        else:
            async with self._turn:
                await self._send_pieces(memoryview(data))

    def _may_write_at_once(self, size: int) -> bool:
        """Tell whether a binary message is one frame that nothing stands before.

        Nearly all that the hub sends is: a frame to each of some hundred pages, ten times a second.
        """
        return (
            size <= LARGEST_PIECE
            and self.writable.is_set()
            and not self._turn.locked()
            and self.handshake_complete
            and self.initial_response is None
            and not self.close_sent
            and not self.disconnected
            and self.conn.state is State.OPEN
            and not self.conn.extensions
        )

    async def _send_pieces(self, data: memoryview) -> None:
        sent = 0
        try:
            while sent < len(data):
                await self.writable.wait()
                sent = self._write_piece(data, sent)
                # Whoever else has something to do comes first.
                await asyncio.sleep(0)
        except asyncio.CancelledError:
            # Whoever sends next may not begin within this message.
            while sent < len(data) and not self.disconnected:
                sent = self._write_piece(data, sent)
            raise

    def _write_piece(self, data: memoryview, at: int) -> int:
        """Write what comes from ``at`` on; give where the next piece begins."""
        end = min(at + LARGEST_PIECE, len(data))
        if self.disconnected or self.close_sent or not self.handshake_complete:
            raise ClientDisconnected
        try:
            if at == 0:
                self.conn.send_binary(data[:end], fin=False)
            else:
                self.conn.send_continuation(data[at:end], fin=end == len(data))
        except InvalidState:
            # It is closing: nothing can be sent any more.
            raise ClientDisconnected from None
        self.transport.write(b"".join(self.conn.data_to_send()))
        return end


def _frame_head(size: int) -> bytes:
    """Give what stands before an unmasked, final binary frame of ``size`` bytes (RFC 6455, 5.2)."""
    if size < 126:
        return bytes((_FINAL_BINARY, size))
    if size < 65_536:
        return _MIDDLE.pack(_FINAL_BINARY, 126, size)
    return _LONG.pack(_FINAL_BINARY, 127, size)
