"""The link of one gateway: frames in, frames out, the most urgent first."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.hub.live.gateways.clock_offset import ClockOffset
from talaia.hub.live.gateways.frame_limits import UNKNOWN
from talaia.hub.live.gateways.handed_down import HandedDown
from talaia.hub.live.gateways.send_lanes import PrioritySendQueue
from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB, Bye

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from starlette.websockets import WebSocket

    from talaia.wire.frames import FromGateway, FromHub

__all__ = ["GONE", "GatewayLink"]

_LOG = logging.getLogger(__name__)
# One that does not read must not hold up the end of its link (s).
_FAREWELL_S = 0.5
# Of messages of unknown kinds before a link is attached: a newer gateway may say some.
_MOST_EARLY = 100
# What a socket raises when the other side has gone or does not take anything.
GONE = (WebSocketDisconnect, RuntimeError, OSError, TimeoutError)


class GatewayLink:
    """One open link. `send` never waits; a task of its own writes, the most urgent first."""

    def __init__(self, socket: WebSocket) -> None:
        """Speak over ``socket``, which is accepted already."""
        # Waited for before a message of a kind is read. The site's own once it is attached: what
        # another one with the site's key says, which waits, is no debt of the site's.
        self.admit_kind: Callable[[str], Awaitable[None]] = self._admit_few
        # Unknown messages before it was attached.
        self._early = 0
        # Of its clock, by beats; counts those that were answered too.
        self.offset = ClockOffset()
        # The site's own once it is attached.
        self.handed_down = HandedDown()
        self._socket = socket
        # What waits to go down; written by `write_queued` alone.
        self._lanes = PrioritySendQueue()
        # Something waits.
        self._wake = asyncio.Event()
        # The end that somebody asked for, with the reason; the first one stays.
        self._over: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    def send(self, message: FromHub) -> None:
        """Queue a message."""
        self.handed_down.record_message(message)
        # So much waits that it cannot be reading.
        if not self._lanes.enqueue_message(message):
            self.dismiss_gateway("it does not listen")
        self._wake.set()

    def dismiss_gateway(self, reason: str) -> None:
        """Say good-bye and close."""
        if not self._over.done():
            self._over.set_result(reason)

    async def receive_message(self) -> FromGateway | None:
        """Read one message; None when the gateway has hung up. Unknown kinds are skipped.

        Raises:
            PeerError: it is none, or there are too many of unknown kinds.

        """
        while True:
            event = await self._socket.receive()
            if event["type"] == "websocket.disconnect":
                return None
            data = event.get("bytes")
            try:
                return LINK_FROM_GATEWAY.decode(event.get("text", "") if data is None else data)
            # A newer gateway may say more than this hub knows.
            except UnknownKind as error:
                _LOG.debug("a gateway sent %s", error)
                await self.admit_kind(UNKNOWN)

    async def _admit_few(self, kind: str) -> None:
        # Not by the clock: what a stranger may say before it is let in is little, however slowly.
        self._early += 1
        if self._early > _MOST_EARLY:
            raise PeerError(f"too many of {kind} before it was linked", 1013)

    async def write_queued(self) -> None:
        """Send what is queued, for ever."""
        while True:
            await self._wake.wait()
            # Before the lanes are emptied: what is queued meanwhile sets it again.
            self._wake.clear()
            while self._lanes:
                # One at a time: a STOP that comes during a send goes out next.
                await self._socket.send_bytes(LINK_FROM_HUB.encode(self._lanes.next_message()))

    async def wait_dismissed(self) -> str:
        """Wait until somebody dismisses this link; give the reason."""
        # The cancelled wait would cancel the future itself.
        return await asyncio.shield(self._over)

    async def send_farewell(self, reason: str, code: int, after_s: float = 0.0) -> None:
        """Say one last thing and close, to a gateway that may not be listening.

        ``after_s`` is when it is to come back; 0 leaves that to it.
        """
        try:
            async with asyncio.timeout(_FAREWELL_S):
                await self._socket.send_bytes(
                    LINK_FROM_HUB.encode(Bye(reason=reason[:2000], after_s=after_s))
                )
                await self._socket.close(code)
        except GONE:
            return
