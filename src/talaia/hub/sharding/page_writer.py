"""What goes down to a page, of several shards: each message whole, and none after the end."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl

from talaia.wire.browser import TO_BROWSER
from talaia.wire.socket_frame import SocketFrame, frame_writer_of

if TYPE_CHECKING:
    from starlette.types import Message, Scope, Send

    from talaia.wire.browser import ToBrowser

__all__ = ["PageWriter"]

# Answers that wait for a page that does not read; the oldest goes.
_MOST_NOTES = 64
# A page that does not read must not hold up the end of its socket (s).
_FAREWELL_S = 0.3


class PageWriter:
    """The way down to one page; whoever sends waits for it as it takes what it is sent.

    Attributes:
        writes_frames: frames that others get, too, can be written at once.

    """

    def __init__(self, scope: Scope, send: Send) -> None:
        """Write by ``send``, and by what ``scope`` offers besides."""
        self._send = send
        self._write = frame_writer_of(scope.get("extensions", {}))
        self.writes_frames = self._write is not None
        self._text = (
            dict(parse_qsl(scope.get("query_string", b"").decode("latin-1"))).get("form") == "json"
        )
        self._ended = self._closed = False
        self._notes: deque[ToBrowser] = deque(maxlen=_MOST_NOTES)
        self._noting: asyncio.Task[None] | None = None

    def write(self, frame: SocketFrame) -> bool:
        """Write a frame at once; False: it is to be sent, see `talaia.wire.socket_frame`."""
        return not self._ended and self._write is not None and self._write(frame)

    async def send(self, message: Message) -> None:
        """Send what a shard says.

        Raises:
            ConnectionResetError: the page has gone, or has been told its end.

        """
        if self._ended:
            raise ConnectionResetError("the page has gone")
        await self._send(message)

    async def send_message(self, message: ToBrowser) -> None:
        """Send the page a message in its form; raises as `send`."""
        if self._text:
            await self.send({"type": "websocket.send", "text": TO_BROWSER.encode_text(message)})
        else:
            await self.send({"type": "websocket.send", "bytes": TO_BROWSER.encode(message)})

    def add_note(self, message: ToBrowser) -> None:
        """Have a message sent; never waits."""
        self._notes.append(message)
        if self._noting is None or self._noting.done():
            self._noting = asyncio.create_task(self._send_notes(), name="answer a joined page")

    def end(self) -> None:
        """Let nothing more through but the last word."""
        self._ended = True
        if self._noting is not None:
            self._noting.cancel()

    async def send_last(self, message: Message) -> None:
        """Send the last word, if none was sent; nothing is raised where the page has gone."""
        if self._closed:
            return
        self._closed = True
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._send(message)
        except (OSError, RuntimeError, TimeoutError):
            return

    async def close(self, code: int) -> None:
        """Send the page away."""
        await self.send_last({"type": "websocket.close", "code": code})

    async def _send_notes(self) -> None:
        while self._notes:
            try:
                await self.send_message(self._notes.popleft())
            except (OSError, RuntimeError):
                return
