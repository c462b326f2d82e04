"""WebSockets as uvicorn serves them; a large message lets others pass between its pieces.

A frame that is written once for many is written to each at once, by an extension of ASGI. Short
messages that come are read past the steps that any frame may need.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

from uvicorn.protocols.utils import ClientDisconnected
from websockets.exceptions import InvalidState
from websockets.protocol import State

from talaia.bounded_http import EndingSocketProtocol
from talaia.hub.api.server.client_frames import FrameCutter
from talaia.hub.live.pages.page_transport import FRAME_WRITER
from talaia.wire.socket_frame import SocketFrame

if TYPE_CHECKING:
    from uvicorn._types import ASGISendEvent
    from websockets.http11 import Request

    from talaia.hub.api.server.proxy_protocol import Asker

__all__ = ["LARGEST_PIECE", "HubSocketProtocol"]

# Bytes of a frame: so many are encrypted and written in less than 0.1 ms, a megabyte takes 2 to 3
# ms of the one loop, in which no driving frame of anybody goes on. What is encrypted stays in the
# processor's cache, too.
LARGEST_PIECE = 64 * 1024
# Bytes of a message that is read in one step.
_SHORT = 16 * 1024
# So many messages may wait to be read before the socket is: to stop it and let it go on for each
# one costs more than to read it.
_MOST_UNREAD = 8


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
        self._cutter = FrameCutter(_SHORT)

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin."""
        super().connection_made(transport)
        self.client = self._asker or self.client

    def data_received(self, data: bytes) -> None:
        """Read what comes."""
        conn = self.conn
        if not self.handshake_initiated:
            # The request, which comes by itself.
            super().data_received(data)
            return
        for piece in self._cutter.cut_frames(data):
            # Within a message of several frames, and while it closes, the library judges.
            if piece.payload and conn.state is State.OPEN and conn.current_size is None:
                self._enqueue_message(piece.message)
            else:
                super().data_received(piece.data)

    def _enqueue_message(self, data: bytes) -> None:
        # As uvicorn has it: what comes after the farewell is left out.
        if self.close_sent:
            return
        self.queue.put_nowait({"type": "websocket.receive", "bytes": data})
        # `receive` lets it go on.
        if not self.read_paused and self.queue.qsize() >= _MOST_UNREAD:
            self.read_paused = True
            self.transport.pause_reading()

    def handle_connect(self, event: Request) -> None:
        """Offer the application what ASGI itself has no word for."""
        super().handle_connect(event)
        # One that is refused by uvicorn has no scope.
        if self.handshake_initiated and not self.close_sent:
            extensions = cast("dict[str, Any]", self.scope["extensions"])
            extensions[FRAME_WRITER] = {"write": self.write_frame}

    def write_frame(self, frame: SocketFrame) -> bool:
        """Write a frame, of which others may get the same bytes; never waits.

        False: nothing is written, since something stands before it, the other side does not read
        as fast as it is sent, or it is none for a single frame. It is then to be sent as ASGI has
        it.
        """
        if not self._may_write_at_once(len(frame)):
            return False
        self.transport.write(frame.framed)
        return True

    async def send(self, message: ASGISendEvent) -> None:
        """Send a message, as ASGI has it."""
        data = message.get("bytes") if message["type"] == "websocket.send" else None
        if isinstance(data, bytes) and self._may_write_at_once(len(data)):
            self.transport.write(SocketFrame(data).framed)
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
            and not self.transport.is_closing()
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
