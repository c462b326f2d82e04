"""One client's line of Engine.IO, whatever carries it: polled requests, a WebSocket, or both.

What carries it pulls what waits for the client, and hands over what the client sent; the session
only knows messages. So a change from polling to a WebSocket loses and doubles nothing.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections import deque
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import MS, SECOND
from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import (
    MAX_SOCKETIO_BODY,
    EngineKind,
    EnginePacket,
    EngineRevision,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.clock import Clock

__all__ = ["EngineConnection", "EngineTimes", "LineGone"]

# Bytes that wait for the client before its session has to wait; one message may stand over it.
_MOST_WAITING = 256 * 1024
# Messages that were read and not handled yet.
_MOST_READ = 64
_PROBE = "probe"
# `python-engineio` reads no more of one answer.
_MOST_POLLED = 16


class EngineTimes(NamedTuple):
    """How the two sides know of each other, as the client is told.

    Attributes:
        ping_ns: the one whose turn it is pings so often: an old client, or we.
        timeout_ns: what was not heard for so long beside that is gone.

    """

    ping_ns: int = 20 * SECOND
    # More than the other: `socketIO-client` waits no longer for an answer to a poll.
    timeout_ns: int = 25 * SECOND


class LineGone(ConnectionError):
    """The client has gone, or we have closed its line."""


class EngineConnection:
    """A client's line.

    Attributes:
        revision: the client's.
        sid: names it in the client's requests; it is a secret, like a session.
        user: whose token opened it; those of others cannot use it. A server without accounts has
            one for all.
        as_text: the client reads polled bytes as base64 alone.
        close_code: for a WebSocket, once it is closed.

    """

    def __init__(
        self,
        revision: EngineRevision,
        *,
        user: int = 0,
        clock: Clock,
        as_text: bool = False,
        times: EngineTimes | None = None,
    ) -> None:
        """Begin with a new ``sid``."""
        self.revision = revision
        # 256 bits: whoever knows it may speak as this client.
        self.sid = secrets.token_urlsafe(32)
        self.user = user
        self.as_text = as_text
        self.close_code = 1000
        self._clock = clock
        self._times = times or EngineTimes()
        # For the client; messages that belong together stand together.
        self._waiting: deque[EnginePacket] = deque()
        self._size = 0
        # Something waits, or was pulled, or who carries it has changed.
        self._changed = asyncio.Condition()
        # From the client.
        self._read: asyncio.Queue[str | bytes] = asyncio.Queue(_MOST_READ)
        self._closed = asyncio.Event()
        self._heard_ns = clock.monotonic_ns()
        # A WebSocket carries it; one has asked to.
        self._on_socket = False
        self._upgrading = False
        self._polled = False

    @property
    def waiting_bytes(self) -> int:
        """How many bytes wait for the client."""
        return self._size

    @property
    def is_closed(self) -> bool:
        """Whether its end has come; what waits may still be pulled."""
        return self._closed.is_set()

    @property
    def is_on_socket(self) -> bool:
        """Whether a WebSocket that has taken over carries it."""
        return self._on_socket

    def opening_packet(self, *, upgrades: bool) -> EnginePacket:
        """Give the first packet: how the line is kept, and whether a WebSocket may follow."""
        said = {
            "sid": self.sid,
            "upgrades": ["websocket"] if upgrades else [],
            "pingInterval": self._times.ping_ns // MS,
            "pingTimeout": self._times.timeout_ns // MS,
            "maxPayload": MAX_SOCKETIO_BODY,
        }
        return EnginePacket(EngineKind.OPEN, json.dumps(said))

    # ── the session's side ──

    async def send_messages(
        self, messages: Sequence[str | bytes], *, until_pulled: bool = False
    ) -> None:
        """Send messages behind each other, once there is room.

        Args:
            messages: they stay together.
            until_pulled: return only when they were pulled; else as soon as they wait.

        Raises:
            LineGone: it is closed.

        """
        async with self._changed:
            await self._changed.wait_for(lambda: self.is_closed or self._size < _MOST_WAITING)
            if self.is_closed:
                raise LineGone
            for message in messages:
                self._add_packet(EnginePacket(EngineKind.MESSAGE, message))
            self._changed.notify_all()
            if until_pulled:
                await self._changed.wait_for(lambda: self.is_closed or not self._waiting)

    async def next_message(self) -> str | bytes:
        """Wait for a message of the client; every one is given before its end.

        Raises:
            LineGone: it is closed.

        """
        if self._read.empty():
            getting = asyncio.ensure_future(self._read.get())
            closing = asyncio.ensure_future(self._closed.wait())
            try:
                await asyncio.wait({getting, closing}, return_when=asyncio.FIRST_COMPLETED)
                if getting.done():
                    return getting.result()
            finally:
                getting.cancel()
                closing.cancel()
            raise LineGone
        return self._read.get_nowait()

    async def keep_alive(self) -> None:
        """Ping where that is our part; return when the client was not heard for too long."""
        while True:
            silent_ns = self._clock.monotonic_ns() - self._heard_ns
            left_ns = self._times.ping_ns + self._times.timeout_ns - silent_ns
            if left_ns <= 0:
                return
            await asyncio.sleep(min(self._times.ping_ns, left_ns) / SECOND)
            if self.revision is EngineRevision.NEW:
                async with self._changed:
                    # One is enough for a client that does not read.
                    if not any(packet.kind is EngineKind.PING for packet in self._waiting):
                        self._add_packet(EnginePacket(EngineKind.PING))
                    self._changed.notify_all()

    async def close_line(self, code: int = 1000) -> None:
        """Close it; what waits goes first, if the client still reads. Once is enough."""
        if self.is_closed:
            return
        self.close_code = code
        self._closed.set()
        async with self._changed:
            self._add_packet(EnginePacket(EngineKind.CLOSE))
            self._changed.notify_all()

    # ── the carrier's side ──

    @contextmanager
    def hold_poll(self) -> Iterator[None]:
        """Let one request wait for the client.

        Raises:
            PeerError: another does already, or a WebSocket carries the line.

        """
        if self._polled or self._on_socket:
            raise PeerError("this session is polled by another request, or has a WebSocket")
        self._polled = True
        try:
            yield
        finally:
            self._polled = False

    async def pull_packets(self, *, polling: bool = False) -> list[EnginePacket]:
        """Wait for what goes to the client next, and hand it over.

        Raises:
            LineGone: it is closed, and nothing waits any more.

        """
        self._heard_ns = self._clock.monotonic_ns() if polling else self._heard_ns
        async with self._changed:
            await self._changed.wait_for(
                lambda: self._waiting or self.is_closed or (polling and self._leaves_polling())
            )
            if polling and self._leaves_polling() and not self._waiting:
                # The client has asked for a WebSocket: its waiting request ends with nothing.
                return [EnginePacket(EngineKind.NOOP)]
            if not self._waiting:
                raise LineGone
            count = min(len(self._waiting), _MOST_POLLED) if polling else len(self._waiting)
            packets = [self._waiting.popleft() for _ in range(count)]
            self._size -= sum(len(packet.data) + 1 for packet in packets)
            self._changed.notify_all()
            return packets

    async def receive_packet(self, packet: EnginePacket) -> None:
        """Take a packet of the client; waits while too many are not handled yet.

        Raises:
            PeerError: a packet that clients do not send there.

        """
        self._heard_ns = self._clock.monotonic_ns()
        match packet.kind:
            case EngineKind.MESSAGE:
                if not self.is_closed:
                    await self._read.put(packet.data)
            case EngineKind.PING:
                async with self._changed:
                    # One that pings and does not read is no reason to keep each.
                    if self._size < _MOST_WAITING:
                        self._add_packet(EnginePacket(EngineKind.PONG, packet.data))
                    self._changed.notify_all()
            case EngineKind.CLOSE:
                await self.close_line()
            case EngineKind.PONG | EngineKind.NOOP:
                pass
            case EngineKind.OPEN | EngineKind.UPGRADE:
                raise PeerError(f"a client sends no packet {packet.kind.value} here")

    async def offer_upgrade(self, packet: EnginePacket) -> EnginePacket:
        """Answer the first packet of a WebSocket that is to carry the line.

        Raises:
            PeerError: it is no probe, or a WebSocket carries the line already.

        """
        probed = packet.kind is EngineKind.PING and packet.data == _PROBE
        if self._on_socket or self._upgrading or not probed:
            raise PeerError("a WebSocket takes over a polled session once, and probes it first")
        self._upgrading = True
        async with self._changed:
            self._changed.notify_all()
        return EnginePacket(EngineKind.PONG, _PROBE)

    async def end_upgrade(self, *, done: bool) -> None:
        """Let the WebSocket carry the line from now on, or go on without it."""
        self._upgrading, self._on_socket = False, done
        async with self._changed:
            self._changed.notify_all()

    def _leaves_polling(self) -> bool:
        return self._upgrading or self._on_socket

    def _add_packet(self, packet: EnginePacket) -> None:
        self._waiting.append(packet)
        self._size += len(packet.data) + 1
