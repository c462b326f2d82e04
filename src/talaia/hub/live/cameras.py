"""The second connection of a gateway: pictures only, so that none stands before a command."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.hub.live.race import until_first
from talaia.wire.errors import PeerError
from talaia.wire.frames import (
    MEDIA_FROM_GATEWAY,
    MEDIA_FROM_HUB,
    Beat,
    BeatReply,
    Boxes,
    Bye,
    Picture,
    Trouble,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.websockets import WebSocket

__all__ = ["GatewayCamera"]

_FAREWELL_S = 0.5
_GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class GatewayCamera:
    """One open media connection."""

    def __init__(self, socket: WebSocket) -> None:
        """Speak over ``socket``, which is accepted already."""
        self._socket = socket
        self._over = asyncio.Event()
        self._reason = ""

    def dismiss(self, reason: str) -> None:
        """Say good-bye and close."""
        self._reason = self._reason or reason
        self._over.set()

    async def serve(
        self,
        take: Callable[[Picture], None],
        trouble: Callable[[Trouble], None],
        boxes: Callable[[Boxes], None],
        now_us: Callable[[], int],
    ) -> None:
        """Hand each picture to ``take`` until either side ends it; answer beats.

        ``trouble`` is told what cannot be shown, ``boxes`` what is seen.
        """
        results = await until_first(self._read(take, trouble, boxes, now_us), self._over.wait())
        reason, code = self._reason, 1000
        for result in results:
            if isinstance(result, PeerError):
                reason, code = result.problem, result.code
            elif isinstance(result, Exception) and not isinstance(result, _GONE):
                raise result
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._socket.send_bytes(MEDIA_FROM_HUB.encode(Bye(reason=reason)))
                await self._socket.close(code)
        except _GONE:
            return

    async def _read(
        self,
        take: Callable[[Picture], None],
        trouble: Callable[[Trouble], None],
        boxes: Callable[[Boxes], None],
        now_us: Callable[[], int],
    ) -> None:
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return
            data = event.get("bytes")
            message = MEDIA_FROM_GATEWAY.decode(event.get("text", "") if data is None else data)
            match message:
                case Picture():
                    take(message)
                case Beat():
                    reply = BeatReply(n=message.n, mono_us=message.mono_us, peer_us=now_us())
                    await self._socket.send_bytes(MEDIA_FROM_HUB.encode(reply))
                case Trouble():
                    trouble(message)
                case Boxes():
                    boxes(message)
                case BeatReply():
                    pass
