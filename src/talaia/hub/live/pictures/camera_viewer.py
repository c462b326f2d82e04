"""One page that looks at one camera: a socket, and in `PicturePacing` what goes over it when."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Any, Protocol

from starlette.websockets import WebSocketDisconnect

from talaia.first_completed import until_first
from talaia.hub.live.pages.page_connections import SESSION_OVER
from talaia.hub.live.pictures.picture_pacing import PicturePacing
from talaia.wire.browser import (
    MEDIA_FROM_BROWSER,
    MEDIA_TO_BROWSER,
    BoxesRequest,
    PagePing,
    PagePong,
    PictureShown,
    RequestError,
    SessionEnded,
    ViewerAttention,
)
from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.frames import camera_address, unblurred_address

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, MutableMapping

    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.pictures.picture_pacing import Ready

__all__ = ["Viewer"]

# A page that does not read must not hold up the end (s).
_FAREWELL_S = 0.3
# Problems and answers to pings that wait; the oldest goes.
_MOST_NOTES = 8
# Models of one camera whose word waits; a description has no more.
_MOST_OVERLAYS = 8
# What a socket raises when the other side has gone or does not take anything.
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class PictureSocket(Protocol):
    """What a viewer speaks over: a page's WebSocket, or a client in this process."""

    async def receive(self) -> MutableMapping[str, Any]:
        """Give the next ASGI event."""
        ...

    async def send_text(self, data: str, /) -> None:
        """Send a frame as text."""
        ...

    async def send_bytes(self, data: bytes, /) -> None:
        """Send a frame; returns when there is room for another."""
        ...

    async def close(self, code: int = ..., /) -> None:
        """End it."""
        ...


class Viewer:
    """One page that looks at one stream. Holds at most a tenth of a second that waits."""

    def __init__(
        self,
        socket: PictureSocket,
        *,
        who: Who,
        site: str,
        stream: str,
        now_us: Callable[[], int],
        able: Collection[str] = (),
        text: bool,
        unblurred: bool = False,
    ) -> None:
        """Look at ``stream`` (``device/stream``) of ``site``; JSON with ``text``.

        Args:
            socket: accepted already.
            who: looks.
            site: see above.
            stream: see above.
            now_us: monotonic.
            able: what the page can show; none from one that knows JPEG only, and no problems.
            text: see above.
            unblurred: its pictures as they are, where others get them blurred; who asks for this
                has seen to it that ``who`` may.

        """
        self.who = who
        self.site = site
        # By its own address, whatever was asked for: nobody gets another stream by a name.
        self.camera = camera_address(stream)
        # What is asked of the gateway.
        self.stream = unblurred_address(stream) if unblurred else self.camera
        self.text = text
        # Which form it gets and when, by how it answers.
        self.flow = PicturePacing(able)
        # Pages that name no abilities are of older versions, which do not read problems.
        self.hears_problems = bool(able)
        # What is seen on the pictures is wanted, too, and what models tell of them.
        self.wants_boxes = self.wants_overlays = False
        # Told that what it wants, or its need of a picture to begin with, may have changed.
        self.on_flow: Callable[[Viewer], None] = lambda _viewer: None
        # The form that the camera was last asked for because of this page.
        self._told = self.flow.form
        # Monotonic (µs).
        self._now_us = now_us
        self._socket = socket
        # Problems and answers that wait to be told.
        self._notes: deque[bytes | str] = deque(maxlen=_MOST_NOTES)
        # What is seen on the newest picture; only the newest counts.
        self._boxes: bytes | str | None = None
        # The newest of each model that has not gone out, by its name.
        self._overlays: dict[str, bytes | str] = {}
        # Something may be sent.
        self._wake = asyncio.Event()
        # The session is over.
        self._over = asyncio.Event()
        # Why, for the page.
        self._reason = ""

    def offer(self, ready: Ready) -> None:
        """Hand over a picture; what waits and is of no use any more gives way."""
        self.flow.offer(ready, self._now_us())
        self._wake.set()
        self._send_state()

    def boxes(self, frame: bytes | str) -> None:
        """Hand over what is seen on a picture, in place of what has not gone out yet."""
        self._boxes = frame
        self._wake.set()

    def queue_overlay(self, model: str, frame: bytes | str) -> None:
        """Hand over what a model tells, in place of what it told and has not gone out yet."""
        self._overlays.pop(model, None)
        self._overlays[model] = frame
        if len(self._overlays) > _MOST_OVERLAYS:
            del self._overlays[next(iter(self._overlays))]
        self._wake.set()

    def _send_state(self) -> None:
        if self.flow.broken or self.flow.form is not self._told:
            self._told = self.flow.form
            self.on_flow(self)

    def trouble(self, why: str) -> None:
        """Say why there is no picture, to a page that knows what to do with it."""
        if self.hears_problems:
            self._notes.append(self._written(RequestError(code="picture", message=why)))
            self._wake.set()

    def end(self, reason: str) -> None:
        """Close, since the session is over."""
        self._reason = reason
        self._over.set()

    def tell_end(self, ends_us: int, *, idle: bool) -> None:
        """Say nothing: the page's other socket tells the person."""

    def take_use(self) -> bool:
        """Looking at pictures is not doing anything."""
        # To watch is no use of a session: a picture that is left open does not keep it alive.
        return False

    async def serve(self) -> None:
        """Send pictures until either side ends it."""
        results = await until_first(self._read(), self._write(), self._over.wait())
        code = SESSION_OVER if self._over.is_set() else 1000
        for result in results:
            if isinstance(result, PeerError):
                code = result.code
            elif isinstance(result, Exception) and not isinstance(result, _GONE):
                raise result
        await self._farewell(code)

    async def _read(self) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            try:
                message = MEDIA_FROM_BROWSER.decode(event.get("text", "") if data is None else data)
            except UnknownKind:
                # A page that is newer than we are.
                continue
            match message:
                case PictureShown():
                    self.flow.shown(message.seq, self._now_us())
                case ViewerAttention():
                    self.flow.glance(still=message.still)
                case BoxesRequest():
                    self._ask_boxes(on=message.on, overlays=message.overlays)
                case PagePing():
                    pong = PagePong(n=message.n, at_ms=message.at_ms, hub_us=self._now_us())
                    self._notes.append(self._written(pong))
            self._wake.set()
            self._send_state()

    async def _write(self) -> None:
        while True:
            await self._wake.wait()
            # Before all is sent: what comes meanwhile sets it again.
            self._wake.clear()
            while self._notes:
                await self._send(self._notes.popleft())
            while (frame := self.flow.next_picture(self._now_us())) is not None:
                await self._send(frame)
            # While a picture waits for the connection, boxes must not take it up.
            if self._boxes is not None and not self.flow.waits:
                boxes, self._boxes = self._boxes, None
                await self._send(boxes)
            while self._overlays and not self.flow.waits:
                await self._send(self._overlays.pop(next(iter(self._overlays))))

    def _ask_boxes(self, *, on: bool, overlays: bool) -> None:
        if (on, overlays) != (self.wants_boxes, self.wants_overlays):
            self.wants_boxes, self.wants_overlays = on, overlays
            # Those of before are of pictures that have gone.
            self._boxes = None
            self._overlays.clear()
            self.on_flow(self)

    async def _send(self, frame: bytes | str) -> None:
        if isinstance(frame, str):
            await self._socket.send_text(frame)
        elif isinstance(frame, bytes):
            await self._socket.send_bytes(frame)

    def _written(self, message: RequestError | SessionEnded | PagePong) -> bytes | str:
        if self.text:
            return MEDIA_TO_BROWSER.encode_text(message)
        return MEDIA_TO_BROWSER.encode(message)

    async def _farewell(self, code: int) -> None:
        try:
            async with asyncio.timeout(_FAREWELL_S):
                if code == SESSION_OVER:
                    await self._send(self._written(SessionEnded(reason=self._reason)))
                await self._socket.close(code)
        except _GONE:
            return
