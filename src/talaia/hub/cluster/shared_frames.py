"""One frame that goes to many sockets by way of another hub: it crosses to that hub once.

A page's frame is the same bytes for each page of its form. What is written in one turn of the loop
to sockets that came in at one hub goes there as one message: which sockets, by tunnel and number,
and the bytes. Every socket still has numbers of its own without a hole, and a window of its own.
"""

from __future__ import annotations

import asyncio
import struct
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.cluster.frames import FrameKind, TunnelFrame
from talaia.hub.cluster.tunnel import TunnelName
from talaia.wire.socket_frame import SocketFrame

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from talaia.hub.cluster.bus import BusLane
    from talaia.hub.cluster.tunnel import TunnelEnd

__all__ = ["SharedFrames", "read_shared"]

# How many sockets, and whether the message is text; then each one's tunnel and number.
_HEAD, _TAKER = struct.Struct("<IB"), struct.Struct("<QQ")
# Sockets of one message, which with the longest frame stays within what the bus takes at once.
_MOST_TAKERS = 2_000


class _Waiting(NamedTuple):
    """A frame that goes out with this turn, and to whom: tunnels with their numbers."""

    frame: SocketFrame
    takers: list[tuple[TunnelEnd, int]]


class SharedFrames:
    """Gathers what is written to many sockets at once, and posts it by hub."""

    def __init__(self, post: Callable[[TunnelName, BusLane, TunnelFrame], Awaitable[None]]) -> None:
        """Send by ``post``."""
        self._post = post
        # By hub and lane, in the order in which it was written.
        self._waiting: dict[tuple[str, BusLane], deque[_Waiting]] = {}
        self._posting: set[asyncio.Task[None]] = set()

    def add_taker(self, tunnel: TunnelEnd, number: int, frame: SocketFrame) -> None:
        """Let ``frame`` go to ``tunnel`` as its ``number``, with this turn of the loop."""
        key = tunnel.name.hub, tunnel.lane
        waiting = self._waiting.get(key)
        if waiting is None:
            waiting = self._waiting[key] = deque()
            asyncio.get_running_loop().call_soon(self._begin_posting, key)
        # Whoever sends the same to many does so one after the other.
        if not waiting or waiting[-1].frame is not frame or _is_full(waiting[-1]):
            waiting.append(_Waiting(frame, []))
        waiting[-1].takers.append((tunnel, number))

    async def post_waiting(self, tunnel: TunnelEnd) -> None:
        """Post what waits for the hub of ``tunnel``: its next frame goes behind that."""
        await self._post_all((tunnel.name.hub, tunnel.lane))

    def _begin_posting(self, key: tuple[str, BusLane]) -> None:
        if key in self._waiting:
            task = asyncio.create_task(self._post_all(key))
            # Kept until it is done: the loop holds tasks only weakly.
            self._posting.add(task)
            task.add_done_callback(self._posting.discard)

    async def _post_all(self, key: tuple[str, BusLane]) -> None:
        # One by one, and taken out before it is posted: the bus sends in the order in which it is
        # called, and several tunnels may ask for this at the same time.
        try:
            while waiting := self._take_first(key):
                frame = TunnelFrame(FrameKind.SHARED, 0, 0, _pack(waiting))
                try:
                    await self._post(TunnelName(key[0], 0), key[1], frame)
                except OSError as error:
                    for tunnel, _ in waiting.takers:
                        tunnel.break_off(str(error))
        finally:
            # Who asked may be cancelled, and what others wrote goes out all the same.
            if key in self._waiting:
                asyncio.get_running_loop().call_soon(self._begin_posting, key)

    def _take_first(self, key: tuple[str, BusLane]) -> _Waiting | None:
        queue = self._waiting.get(key)
        if queue is None:
            return None
        first = queue.popleft()
        if not queue:
            del self._waiting[key]
        return first


def _is_full(waiting: _Waiting) -> bool:
    return len(waiting.takers) >= _MOST_TAKERS


def _pack(waiting: _Waiting) -> bytes:
    data = waiting.frame.data
    head = _HEAD.pack(len(waiting.takers), isinstance(data, str))
    takers = [_TAKER.pack(tunnel.name.number, number) for tunnel, number in waiting.takers]
    return b"".join((head, *takers, data.encode() if isinstance(data, str) else data))


def read_shared(payload: bytes) -> tuple[Iterator[tuple[int, int]], SocketFrame] | None:
    """Read what came: each taker's tunnel and number, and the frame; None when it is none."""
    if len(payload) < _HEAD.size:
        return None
    count, is_text = _HEAD.unpack_from(payload)
    end = _HEAD.size + count * _TAKER.size
    if len(payload) < end:
        return None
    data = payload[end:]
    try:
        frame = SocketFrame(data.decode() if is_text else data)
    except UnicodeDecodeError:
        return None
    return _TAKER.iter_unpack(payload[_HEAD.size : end]), frame
