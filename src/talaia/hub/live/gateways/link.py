"""The link of one gateway: frames in, frames out, the most urgent first."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from starlette.websockets import WebSocketDisconnect

from talaia.hub.live.gateways.clock_offset import ClockOffset
from talaia.hub.live.gateways.frame_limits import UNKNOWN, frame_kind
from talaia.hub.live.gateways.handed_down import HandedDown
from talaia.hub.live.gateways.send_lanes import PrioritySendQueue
from talaia.wire.errors import PeerError, UnknownKind
from talaia.wire.frames import LINK_FROM_GATEWAY, LINK_FROM_HUB, Bye
from talaia.wire.socket_frame import SocketFrame, frame_writer_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.websockets import WebSocket

    from talaia.wire.frames import FromGateway, FromHub

__all__ = ["GONE", "MESSAGE_TAKER", "GatewayLink"]

# The extension of ASGI by which our server offers messages of bytes as they come: {"begin": takes
# a function that gives False for what is to be queued}. Over a hub that hands a socket through
# there is none, and all are queued.
MESSAGE_TAKER = "talaia.message_taker"

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
        # Counts a message of a kind and gives how long it has to wait (s). The site's own once it
        # is attached: what another one with the site's key says, which waits, is no debt of the
        # site's.
        self.charge_kind: Callable[[str], float] = self._charge_few
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
        # The writing task has nothing in its hands: what is said now may be written at once.
        self._idle = False
        self._write_frame = frame_writer_of(socket.scope.get("extensions", {}))
        # Deals with what comes. Whoever reads the queue waits for it, with nothing in its hands:
        # then what comes may pass it by.
        self._handle: Callable[[FromGateway], bool] = lambda _: False
        self._resting = False
        # Of a message that could not: how long it has to wait (s), or what is wrong.
        self._charged_s: float | None = None
        self._failure: Exception | None = None
        # The end that somebody asked for, with the reason; the first one stays.
        self._over: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    def send(self, message: FromHub) -> None:
        """Queue a message."""
        self.handed_down.record_message(message)
        if self._idle and not self._lanes and self._write_at_once(message):
            return
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
                if wait_s := self.charge_kind(UNKNOWN):
                    await asyncio.sleep(wait_s)

    async def read_messages(self, handle: Callable[[FromGateway], bool]) -> None:
        """Have each message dealt with until ``handle`` gives False, or the gateway has hung up.

        Raises:
            PeerError: what came is no message, or the gateway is cut off.

        """
        self._handle = handle
        taking = self._socket.scope.get("extensions", {}).get(MESSAGE_TAKER)
        if taking is not None:
            taking["begin"](self._take_at_once)
        try:
            while True:
                self._resting = True
                message = await self.receive_message()
                self._resting = False
                if self._failure is not None:
                    raise self._failure
                if message is None:
                    return
                wait_s, self._charged_s = self._charged_s, None
                if wait_s is None:
                    wait_s = self.charge_kind(frame_kind(message))
                if wait_s:
                    await asyncio.sleep(wait_s)
                if not handle(message):
                    return
        finally:
            self._resting = False

    def _take_at_once(self, data: bytes) -> bool:
        """Deal with a message as it comes; False: whoever reads the queue has to."""
        if not self._resting:
            return False
        # Unless all is well, that one goes on from here.
        self._resting = False
        try:
            message = LINK_FROM_GATEWAY.decode(data)
            if isinstance(message, Bye):
                return False
            wait_s = self.charge_kind(frame_kind(message))
            if wait_s:
                self._charged_s = wait_s
                return False
            self._handle(message)
        except UnknownKind:
            return False
        # Raised where the link is read, not where bytes come in.
        except Exception as error:  # noqa: BLE001
            self._failure = error
            return False
        self._resting = True
        return True

    def _charge_few(self, kind: str) -> float:
        # Not by the clock: what a stranger may say before it is let in is little, however slowly.
        self._early += 1
        if self._early > _MOST_EARLY:
            raise PeerError(f"too many of {kind} before it was linked", 1013)
        return 0.0

    def _write_at_once(self, message: FromHub) -> bool:
        """Write a message past the lanes; a task's turn for each costs more than the rest of it."""
        if self._write_frame is None:
            return False
        try:
            return self._write_frame(SocketFrame(LINK_FROM_HUB.encode(message)))
        except GONE:
            # Whoever writes what is queued will find that, too.
            return False

    async def write_queued(self) -> None:
        """Send what is queued, for ever."""
        while True:
            self._idle = True
            await self._wake.wait()
            self._idle = False
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
