"""The second connection of a gateway: pictures, and behind them raw topics.

It is apart from the link so that none of them stands before a command.
"""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from starlette.websockets import WebSocketDisconnect

from talaia.first_completed import until_first
from talaia.hub.live.gateways.doubles.duplicate_gateways import KEPT_OUT, is_beside_link
from talaia.hub.live.gateways.flood_guard import HELD_OFF, TRY_LATER
from talaia.hub.live.gateways.link import GatewayLink
from talaia.wire.errors import PeerError
from talaia.wire.frames import (
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Beat,
    BeatReply,
    Bye,
    DetectedBoxes,
    ModelOverlay,
    PictureFrame,
    RobotGraph,
    StreamError,
    TapError,
    TapMessage,
    TapSchema,
    TopicList,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.open_links import OpenLinks
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.sites import Sites
    from talaia.hub.live.taps.tap_fanout import TapFanout, TapFromGateway
    from talaia.hub.store.sites.site_registry import GatewayKey
    from talaia.wire.message import Message

__all__ = ["GatewayCamera", "MediaLinks", "MediaReceivers"]

# One that does not read must not hold up the end (s).
_FAREWELL_S = 0.5
# Reading a larger message takes long enough to be felt by who drives (bytes).
_LARGE = 16 * 1024
# What a socket raises when the other side has gone or does not take anything.
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class MediaReceivers(NamedTuple):
    """Who is handed what comes over one media connection."""

    picture: Callable[[PictureFrame], None]
    # What cannot be shown.
    trouble: Callable[[StreamError], None]
    # What is seen.
    boxes: Callable[[DetectedBoxes], None]
    overlay: Callable[[ModelOverlay], None]
    taps: Callable[[TapFromGateway], None]
    # Waited for before each message is read on.
    admit: Callable[[Message], Awaitable[None]]


class GatewayCamera:
    """One open media connection."""

    def __init__(self, socket: WebSocket) -> None:
        """Speak over ``socket``, which is accepted already."""
        self._socket = socket
        # Somebody has dismissed it.
        self._over = asyncio.Event()
        # Why; the first reason stays.
        self._reason = ""

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        self._reason = self._reason or reason
        self._over.set()

    async def serve(self, receivers: MediaReceivers, now_us: Callable[[], int]) -> None:
        """Hand on what comes until either side ends it; answer beats."""
        results = await until_first(self._read(receivers, now_us), self._over.wait())
        reason, code = self._reason, 1000
        for result in results:
            if isinstance(result, PeerError):
                reason, code = result.problem, result.code
            elif isinstance(result, Exception) and not isinstance(result, _GONE):
                raise result
        await self.send_farewell(reason, code)

    async def send_farewell(self, reason: str, code: int, after_s: float = 0.0) -> None:
        """Say one last thing and close; ``after_s`` is when to come back, 0 leaves that open."""
        try:
            async with asyncio.timeout(_FAREWELL_S):
                said = Bye(reason=reason[:2000], after_s=after_s)
                await self._socket.send_bytes(MEDIA_FROM_HUB.encode(said))
                await self._socket.close(code)
        except _GONE:
            return

    async def _read(self, receivers: MediaReceivers, now_us: Callable[[], int]) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            message = MEDIA_FROM_GATEWAY.decode(event.get("text", "") if data is None else data)
            await receivers.admit(message)
            match message:
                case PictureFrame():
                    receivers.picture(message)
                case Beat():
                    reply = BeatReply(n=message.n, mono_us=message.mono_us, peer_us=now_us())
                    await self._socket.send_bytes(MEDIA_FROM_HUB.encode(reply))
                case StreamError():
                    receivers.trouble(message)
                case DetectedBoxes():
                    receivers.boxes(message)
                case ModelOverlay():
                    receivers.overlay(message)
                case TapMessage() | TopicList() | TapSchema() | TapError() | RobotGraph():
                    receivers.taps(message)
                    # What has come already is read without a pause: of a large message all pieces,
                    # and driving frames of pages would stand behind them.
                    if len(data or b"") >= _LARGE:
                        await asyncio.sleep(0)
                case BeatReply():
                    # The hub sends no beats here: the link's own tell how far the clocks are apart.
                    pass


class MediaLinks:
    """Takes in the pictures of gateways; of each site the newest connection counts."""

    def __init__(
        self,
        *,
        sites: Sites,
        media: PictureFanout,
        taps: TapFanout,
        links: OpenLinks,
        flood_guard: FloodGuard,
        clock: Clock,
    ) -> None:
        """Hand on pictures and taps; ``links`` closes a connection whose key is revoked.

        ``flood_guard`` slows who says too much, and cuts them off.
        """
        self._flood_guard = flood_guard
        self._sites = sites
        self._media = media
        self._taps = taps
        self._links = links
        self._clock = clock
        # The open connection of each site; at most one, the newest.
        self._open: dict[str, GatewayCamera] = {}

    async def serve_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Take pictures of a site until its gateway hangs up or a newer one comes."""
        camera, site = GatewayCamera(socket), key.site
        # Told, and not merely closed: a gateway that knows when comes back then, and not before.
        if held_s := self._flood_guard.held_s(key):
            await camera.send_farewell(HELD_OFF, TRY_LATER, held_s)
            return
        # Before the older one is closed: a thief of the key must not put out the pictures.
        if not is_beside_link(self._sites.find_site(site), key):
            await camera.send_farewell(KEPT_OUT, TRY_LATER)
            return
        before = self._open.get(site)
        if before is not None:
            # A gateway needs one; the older is likely a connection that is dead.
            before.dismiss_gateway("a newer connection was opened")
        self._open[site] = camera
        # What the older has begun it will not end.
        self._taps.media_lost(site)
        try:
            with self._links.count_open(key.id, camera):
                receivers = MediaReceivers(
                    picture=lambda picture: self._publish(key, picture),
                    trouble=lambda said: self._media.trouble(site, said),
                    boxes=lambda boxes: self._media.boxes(site, boxes),
                    overlay=lambda overlay: self._media.publish_overlay(site, overlay),
                    taps=lambda said: self._receive_tap(key, camera, said),
                    admit=partial(self._flood_guard.admit_frame, key),
                )
                await camera.serve(receivers, self._now_us)
        finally:
            # A newer one may have its place already.
            if self._open.get(site) is camera:
                del self._open[site]

    def _publish(self, key: GatewayKey, picture: PictureFrame) -> None:
        live = self._sites.find_site(key.site)
        # Its offset turns the time of a picture into ours, so no link: no pictures. And none of
        # a gateway that has lost its place since it opened this.
        if live is not None and isinstance(live.link, GatewayLink) and is_beside_link(live, key):
            self._media.shot(live, picture, live.link.offset)

    def _receive_tap(self, key: GatewayKey, camera: GatewayCamera, said: TapFromGateway) -> None:
        # Pieces of two connections make no message.
        if self._open.get(key.site) is camera and is_beside_link(
            self._sites.find_site(key.site), key
        ):
            self._taps.receive(key.site, said)

    def _now_us(self) -> int:
        # Monotonic, as for the link: both compare the same clocks.
        return self._clock.monotonic_ns() // 1000
