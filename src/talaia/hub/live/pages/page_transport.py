"""How one connection is read and written: a page's WebSocket, or a client of this very process."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Protocol

from starlette.websockets import WebSocketDisconnect

from talaia.hub.policy import BY_DISPLAY, NOT_BY_SCRIPT
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, PageLease, RequestError
from talaia.wire.errors import UnknownKind
from talaia.wire.frames import LeaseOp
from talaia.wire.socket_frame import SocketFrame, frame_writer_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.websockets import WebSocket

    from talaia.hub.live.pages.outbox import Frame
    from talaia.wire.browser import FromBrowser, ToBrowser

__all__ = ["GONE", "PageTransport", "SocketTransport"]

# A browser sends a ping each second, and a hidden tab one a minute; after this it is gone (s).
_SILENT_S = 150.0
_NO_PAGE = "a token drives by /clients/scripts/<site> alone, if an admin lets it (Admin, Clients)"
_NO_PERSON = "a display only shows; sign in to do something"
# What a socket raises when the other side has gone or does not take anything.
GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class PageTransport(Protocol):
    """The way to one page or client, and the form in which it reads."""

    @property
    def form(self) -> str:
        """Names the form: what is written once serves all connections of the same form."""
        ...

    def encode(self, message: ToBrowser) -> Frame:
        """Write a message in the form that is read here; ``len`` of it is what it weighs."""
        ...

    def refuse_request(self, message: FromBrowser) -> RequestError | None:
        """Say why a message may not come this way, though its person has the right."""
        ...

    async def read_messages(
        self, receive: Callable[[FromBrowser], None], refuse: Callable[[RequestError], None]
    ) -> None:
        """Hand each message to ``receive`` until the other side has gone.

        ``refuse`` answers what could not be read and does no harm.

        Raises:
            PeerError: what came breaks the protocol; the connection ends with its code.

        """
        ...

    def write_frame(self, frame: Frame) -> bool:
        """Send one frame at once, if nothing that was sent before it waits; never waits.

        False: nothing is sent, and it is to go by `send_frame`.
        """
        ...

    async def send_frame(self, frame: Frame) -> None:
        """Send one frame; returns when there is room for another."""
        ...

    async def close_connection(self, code: int) -> None:
        """End the connection."""
        ...


class SocketTransport:
    """A page's WebSocket."""

    def __init__(
        self, socket: WebSocket, *, text: bool, script: bool = False, display: bool = False
    ) -> None:
        """Speak JSON with ``text``, else MessagePack; ``script``: with one that has a token.

        ``display``: with a screen, which only looks.
        """
        # Accepted already.
        self._socket = socket
        self._text = text
        self._script = script
        self._display = display
        self._writer = frame_writer_of(socket.scope.get("extensions", {}))

    @property
    def form(self) -> str:
        """JSON or MessagePack."""
        return "json" if self._text else "msgpack"

    def encode(self, message: ToBrowser) -> Frame:
        """Write a message in the form this page reads."""
        return SocketFrame(
            TO_BROWSER.encode_text(message) if self._text else TO_BROWSER.encode(message)
        )

    def refuse_request(self, message: FromBrowser) -> RequestError | None:
        """Refuse what only a page does: a script is a tool, and drives by the rules of tools."""
        about = str(type(message).__struct_config__.tag)
        if self._display and type(message) not in BY_DISPLAY:
            return RequestError(code="forbidden", message=_NO_PERSON, about=about)
        if not self._script or type(message) not in NOT_BY_SCRIPT:
            return None
        # To let go is always allowed.
        if isinstance(message, PageLease) and message.op is LeaseOp.FREE:
            return None
        return RequestError(code="forbidden", message=_NO_PAGE, about=about)

    async def read_messages(
        self, receive: Callable[[FromBrowser], None], refuse: Callable[[RequestError], None]
    ) -> None:
        """Read until the page has gone; see `PageTransport.read_messages`."""
        while True:
            # The page pings by itself, so silence is a connection that is dead.
            async with asyncio.timeout(_SILENT_S):
                event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                message = FROM_BROWSER.decode(event.get("text", "") if data is None else data)
            except UnknownKind as error:
                refuse(RequestError(code="unknown", message=str(error), about=error.kind[:200]))
                continue
            # Does not wait: what it asks is queued or answered at once.
            receive(message)

    def write_frame(self, frame: Frame) -> bool:
        """Write the frame's own bytes, which are the same for all pages of this form."""
        if self._writer is None or not isinstance(frame, SocketFrame):
            return False
        try:
            return self._writer(frame)
        except GONE:
            # `send_frame` will find that, too: it ends this connection and no other.
            return False

    async def send_frame(self, frame: Frame) -> None:
        """Send one frame."""
        if not isinstance(frame, SocketFrame):
            # Only `encode` above makes frames for this transport.
            raise TypeError(f"a page cannot be sent {type(frame).__name__}")
        if isinstance(frame.data, str):
            await self._socket.send_text(frame.data)
        else:
            await self._socket.send_bytes(frame.data)

    async def close_connection(self, code: int) -> None:
        """Close the socket."""
        await self._socket.close(code)
