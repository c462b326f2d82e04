"""Pictures from a gateway to everyone who looks: the newest wins, nobody waits for anybody."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.hub.live.browsers import SESSION_OVER
from talaia.hub.live.race import until_first
from talaia.wire.browser import MEDIA_FROM_BROWSER, MEDIA_TO_BROWSER, Ended, Shot
from talaia.wire.errors import PeerError
from talaia.wire.frames import Watch

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.auth.permissions import Who
    from talaia.hub.live.clocks import ClockOffset
    from talaia.hub.live.outbox import Frame
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.wire.frames import Picture

__all__ = ["Media", "Viewer"]

# Pictures that may be under way to a page: one being sent, one being drawn.
CREDIT = 2
_FAREWELL_S = 0.3
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class Viewer:
    """One page that looks at one stream. Holds at most one picture that waits."""

    def __init__(self, socket: WebSocket, who: Who, site: str, stream: str, *, text: bool) -> None:
        """Look at ``stream`` (``device/stream``) of ``site``; JSON with ``text``."""
        self.who = who
        self.site = site
        self.stream = stream
        self.text = text
        self.skipped = 0
        self._socket = socket
        self._newest: Frame | None = None
        self._credit = CREDIT
        self._wake = asyncio.Event()
        self._over = asyncio.Event()
        self._reason = ""

    def offer(self, frame: Frame) -> None:
        """Hand over a picture; one that still waits gives way."""
        if self._newest is not None:
            self.skipped += 1
        self._newest = frame
        self._wake.set()

    def end(self, reason: str) -> None:
        """Close, since the session is over."""
        self._reason = reason
        self._over.set()

    def tell_end(self, ends_us: int, *, idle: bool) -> None:
        """Say nothing: the page's other socket tells the person."""

    def take_use(self) -> bool:
        """Looking at pictures is not doing anything."""
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
            MEDIA_FROM_BROWSER.decode(event.get("text", "") if data is None else data)
            self._credit = min(CREDIT, self._credit + 1)
            self._wake.set()

    async def _write(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._credit and self._newest is not None:
                frame, self._newest = self._newest, None
                self._credit -= 1
                await self._send(frame)

    async def _send(self, frame: Frame) -> None:
        if isinstance(frame, str):
            await self._socket.send_text(frame)
        else:
            await self._socket.send_bytes(frame)

    async def _farewell(self, code: int) -> None:
        try:
            async with asyncio.timeout(_FAREWELL_S):
                if code == SESSION_OVER:
                    ended = Ended(reason=self._reason)
                    text = self.text
                    await self._send(
                        MEDIA_TO_BROWSER.encode_text(ended)
                        if text
                        else MEDIA_TO_BROWSER.encode(ended)
                    )
                await self._socket.close(code)
        except _GONE:
            return


class Media:
    """All viewers, and what the gateways are asked to send for them."""

    def __init__(self, sites: Sites, clock: Clock, linger_s: float) -> None:
        """A stream rests ``linger_s`` after its last viewer has gone."""
        self._sites = sites
        self._clock = clock
        self._linger_s = linger_s
        self._viewers: dict[tuple[str, str], set[Viewer]] = {}
        self._timers: dict[tuple[str, str], asyncio.TimerHandle] = {}

    def join(self, viewer: Viewer) -> None:
        """Take a viewer in; the first one wakes the stream."""
        key = (viewer.site, viewer.stream)
        timer = self._timers.pop(key, None)
        if timer is not None:
            timer.cancel()
        first = key not in self._viewers
        self._viewers.setdefault(key, set()).add(viewer)
        if first:
            self.watch(viewer.site)

    def leave(self, viewer: Viewer) -> None:
        """Let a viewer go; a little after the last one the stream rests."""
        key = (viewer.site, viewer.stream)
        viewers = self._viewers.get(key, set())
        viewers.discard(viewer)
        if not viewers and key in self._viewers and key not in self._timers:
            loop = asyncio.get_running_loop()
            self._timers[key] = loop.call_later(self._linger_s, self._rest, key)

    def watch(self, site: str) -> None:
        """Tell a site's gateway which streams are looked at now."""
        live = self._sites.get(site)
        if live is not None and live.link is not None:
            streams = sorted(stream for where, stream in self._viewers if where == site)
            live.link.send(Watch(streams=streams))

    def close(self) -> None:
        """Stop the timers."""
        for timer in self._timers.values():
            timer.cancel()
        self._timers.clear()

    def shot(self, live: LiveSite, picture: Picture, offset: ClockOffset) -> None:
        """Hand a picture to its viewers; written once for all who read the same form."""
        viewers = self._viewers.get((live.name, picture.stream))
        if not viewers:
            return
        captured = offset.ours(picture.mono_us)
        now_us = self._clock.monotonic_ns() // 1000
        shot = Shot(
            seq=picture.seq,
            time_us=picture.time_us,
            # Without an estimate yet: as if it had been taken now. Never from the future.
            hub_us=now_us if captured is None else min(captured, now_us),
            width=picture.width,
            height=picture.height,
            format=picture.format,
            data=picture.data,
        )
        written: dict[bool, Frame] = {}
        for viewer in viewers:
            if viewer.text not in written:
                written[viewer.text] = (
                    MEDIA_TO_BROWSER.encode_text(shot)
                    if viewer.text
                    else MEDIA_TO_BROWSER.encode(shot)
                )
            viewer.offer(written[viewer.text])

    def _rest(self, key: tuple[str, str]) -> None:
        del self._timers[key]
        if not self._viewers.get(key):
            self._viewers.pop(key, None)
            self.watch(key[0])
