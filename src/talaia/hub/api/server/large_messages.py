"""WebSockets as uvicorn serves them; a large message lets others pass between its pieces.

Extensions of ASGI spare what happens thousands of times a second a queue and a task's turn: a frame
that is written once for many is written to each at once, and what a gateway says is handed on as it
comes.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

from uvicorn.protocols.utils import ClientDisconnected
from websockets.exceptions import InvalidState
from websockets.protocol import State

from talaia.bounded_http import EndingSocketProtocol
from talaia.hub.api.server.whole_frames import WholeFrames
from talaia.hub.live.gateways.link import MESSAGE_TAKER
from talaia.wire.socket_frame import FRAME_WRITER, SocketFrame

if TYPE_CHECKING:
    from collections.abc import Callable

    from uvicorn._types import ASGISendEvent
    from websockets.http11 import Request

    from talaia.hub.api.server.proxy_protocol import Asker

__all__ = ["LARGEST_PIECE", "HubSocketProtocol"]

# Bytes of a frame: so many are encrypted and written in less than 0.1 ms, a megabyte takes 2 to 3
# ms of the one loop, in which no driving frame of anybody goes on. What is encrypted stays in the
# processor's cache, too.
LARGEST_PIECE = 64 * 1024


class HubSocketProtocol(EndingSocketProtocol):
    """One WebSocket. Binary messages beyond `LARGEST_PIECE` are sent as several frames.

    That is what RFC 6455 (5.4) has fragments for: answers to pings go between them, and every
    client puts them together.
    """

    def __init__(self, *args: Any, asker: Asker | None = None, **kwargs: Any) -> None:  # noqa: ANN401 - uvicorn's own
        """Serve a connection; ``asker`` is who comes, where that is not the socket's other end."""
        super().__init__(*args, **kwargs)
        self._asker = asker
        # Cuts what comes once the other side may speak; None: not yet, or never.
        self._frames: WholeFrames | None = None
        # It said something before it was let in: the parser may be within a frame.
        self._spoke_early = False
        # Is offered each message of bytes before it is queued.
        self._taker: Callable[[bytes], bool] | None = None
        # Messages of one socket are sent by several tasks: no other may begin within one.
        self._turn = asyncio.Lock()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin."""
        super().connection_made(transport)
        self.client = self._asker or self.client

    def handle_connect(self, event: Request) -> None:
        """Offer the application what ASGI itself has no word for."""
        super().handle_connect(event)
        # One that is refused by uvicorn has no scope.
        if self.handshake_initiated and not self.close_sent:
            extensions = cast("dict[str, Any]", self.scope["extensions"])
            extensions[FRAME_WRITER] = {"write": self.write_frame}
            extensions[MESSAGE_TAKER] = {"begin": self.begin_taking}

    def begin_taking(self, taker: Callable[[bytes], bool]) -> None:
        """Offer each message of bytes to ``taker`` as it comes, while none before it is queued.

        One that gives False leaves it to the queue, and so do all that come before that is empty.
        """
        self._taker = taker

    def data_received(self, data: bytes) -> None:
        """Read what came."""
        if self._frames is None and not self._begin_frames():
            super().data_received(data)
            return
        for frame in cast("WholeFrames", self._frames).cut(data):
            # One of before has ended the connection.
            if self.transport.is_closing():
                return
            if not frame.is_message:
                super().data_received(frame.data)
            # After a farewell nothing counts any more.
            elif self.close_sent or self.conn.state is not State.OPEN:
                continue
            elif self._taker is None or not self.queue.empty() or not self._taker(frame.data):
                self.frames, self.curr_msg_data_type = [frame.data], "bytes"
                self.send_receive_event_to_app()

    def _begin_frames(self) -> bool:
        """Tell whether what comes from now on are frames."""
        if not self.handshake_complete:
            self._spoke_early |= self.handshake_initiated
            return False
        if self._spoke_early or self.conn.state is not State.OPEN or self.conn.extensions:
            return False
        self._frames = WholeFrames(self.config.ws_max_size)
        return True

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
