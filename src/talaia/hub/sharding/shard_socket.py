"""A socket of a page at one shard, as the application there sees it."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from starlette.types import ASGIApp, Message, Scope

__all__ = ["ShardSocket"]

# What a page has said and the shard has not read: a subscription has at most a megabyte.
_MOST_WAITING, _MOST_BYTES = 2_000, 4 * 1024 * 1024
# 1013: try again later (IANA's registry of close codes).
_TRY_LATER = 1013


class ShardSocket:
    """One socket, from its opening to its end.

    Attributes:
        shard: whose application it is at.
        accepted: the shard has let the page in.
        denied: with which HTTP status it did not; 0: it did, or has not said.
        close_code: with which it closed; None: it has not.

    """

    def __init__(
        self, shard: str, scope: Scope, hear: Callable[[ShardSocket, Message], Awaitable[None]]
    ) -> None:
        """Be one at ``shard``, opened as ``scope`` says; what it sends goes to ``hear``."""
        self.shard = shard
        self.accepted = False
        self.denied = 0
        self.close_code: int | None = None
        self._scope = scope
        self._hear = hear
        self._opened = False
        self._waiting: deque[tuple[Message, int]] = deque()
        self._bytes = 0
        # The page has gone, with this code.
        self._gone: int | None = None
        self._news = asyncio.Event()

    async def run(self, app: ASGIApp) -> None:
        """Let ``app`` serve it to its end; raises what that raises."""
        await app(self._scope, self._receive, self._send)

    def push(self, message: Message, size: int) -> bool:
        """Hand a message of the page on, of ``size`` bytes; False: too much waits, it ends."""
        if len(self._waiting) >= _MOST_WAITING or self._bytes + size > _MOST_BYTES:
            self.hang_up(_TRY_LATER)
            return False
        self._waiting.append((message, size))
        self._bytes += size
        self._news.set()
        return True

    def hang_up(self, code: int) -> None:
        """Say that the page has gone; what waits is not said any more."""
        if self._gone is None:
            self._gone = code
            self._waiting.clear()
            self._news.set()

    async def _receive(self) -> Message:
        if not self._opened:
            self._opened = True
            return {"type": "websocket.connect"}
        # Before it is let in, nothing more is said: whoever holds the opening may begin it anew.
        while self._gone is None and not (self.accepted and self._waiting):
            self._news.clear()
            await self._news.wait()
        if self._gone is not None:
            return {"type": "websocket.disconnect", "code": self._gone, "reason": ""}
        message, size = self._waiting.popleft()
        self._bytes -= size
        return message

    async def _send(self, message: Message) -> None:
        kind = message["type"]
        if kind == "websocket.close":
            self.close_code = message.get("code", 1000)
        elif kind == "websocket.http.response.start":
            self.denied = message["status"]
        await self._hear(self, message)
        if kind == "websocket.accept":
            self.accepted = True
            self._news.set()
