"""Pictures that wait to be sent: the newest of each stream and no other."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from talaia.wire.frames import MEDIA_FROM_GATEWAY

if TYPE_CHECKING:
    from talaia.wire.frames import Picture

__all__ = ["Pictures"]


class Pictures:
    """A `PictureSink`. Beside pictures it carries the connection's few small messages."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        """Take the loop that sends."""
        self._loop = loop
        self._newest: dict[str, Picture] = {}
        self._small: deque[bytes] = deque(maxlen=100)
        self._wake = asyncio.Event()
        self._linked = False
        self.dropped = 0

    def offer(self, picture: Picture) -> None:
        """Take one picture; any thread."""
        if self._linked:
            self._loop.call_soon_threadsafe(self._put, picture)

    def _put(self, picture: Picture) -> None:
        # Taken out first, so that streams take turns instead of one starving the others.
        if self._newest.pop(picture.stream, None) is not None:
            self.dropped += 1
        self._newest[picture.stream] = picture
        self._wake.set()

    def say(self, data: bytes) -> None:
        """Queue a small message before all pictures."""
        self._small.append(data)
        self._wake.set()

    async def next(self) -> bytes:
        """Wait for the next frame to send."""
        while True:
            if self._small:
                return self._small.popleft()
            if self._newest:
                return MEDIA_FROM_GATEWAY.encode(self._newest.pop(next(iter(self._newest))))
            self._wake.clear()
            await self._wake.wait()

    def link_up(self) -> None:
        """Begin with nothing old."""
        self._newest.clear()
        self._small.clear()
        self._linked = True

    def link_lost(self) -> None:
        """Take no more until the next connection."""
        self._linked = False
        self._newest.clear()
