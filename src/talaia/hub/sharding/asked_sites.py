"""Which shard what a page says goes to, where that has to be looked up first."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.sharding.page_frames import data_of
from talaia.hub.sharding.plan import MAIN

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from starlette.types import Message

    from talaia.hub.sharding.page_frames import AskedAbout

__all__ = ["AskedSites"]

_LOG = logging.getLogger(__name__)
# So long a site is looked up (s); then the main shard says what is to be said of it.
_LOOK_UP_S = 2.0
_MOST_WAITING, _MOST_BYTES = 500, 2 * 1024 * 1024


class _Waiting(NamedTuple):
    asked: AskedAbout
    message: Message
    shard: Awaitable[str] | str
    size: int


class AskedSites:
    """Hands on what one page says, in its order for each site and for subscriptions.

    What it says of one site does not wait for another site to be looked up: STOP is never behind a
    database that does not answer.
    """

    def __init__(
        self,
        shard_of: Callable[[str], Awaitable[str] | str],
        hand_on: Callable[[AskedAbout, Message, str], None],
        *,
        limit_reached: Callable[[], None],
    ) -> None:
        """Look up by ``shard_of``, and hand each message with its shard to ``hand_on``."""
        self._shard_of = shard_of
        self._hand_on = hand_on
        self._limit_reached = limit_reached
        self._waiting: deque[_Waiting] = deque()
        self._bytes = 0
        self._looking: asyncio.Task[None] | None = None

    def lead(self, asked: AskedAbout, message: Message, known: str | None) -> None:
        """Hand a message on, or let it wait; ``known`` is its site's shard, where that is known."""
        shard: Awaitable[str] | str = known or (self._shard_of(asked.site) if asked.site else MAIN)
        if isinstance(shard, str) and not self._waits_behind(asked):
            self._hand_on(asked, message, shard)
            return
        size = len(data_of(message))
        self._waiting.append(_Waiting(asked, message, shard, size))
        self._bytes += size
        if len(self._waiting) > _MOST_WAITING or self._bytes > _MOST_BYTES:
            self._limit_reached()
        if self._looking is None:
            self._looking = asyncio.create_task(self._look_up(), name="look sites of a page up")

    def close(self) -> None:
        """Look for nothing more."""
        if self._looking is not None:
            self._looking.cancel()

    def _waits_behind(self, asked: AskedAbout) -> bool:
        """Tell whether something that waits is to be handed on before this."""
        if not self._waiting:
            return False
        numbered = asked.sub >= 0
        return any(
            waiting.asked.site == asked.site or (numbered and waiting.asked.sub >= 0)
            for waiting in self._waiting
        )

    async def _look_up(self) -> None:
        try:
            while self._waiting:
                # It stays first until it is handed on: what follows for its site sees it.
                first = self._waiting[0]
                shard = await self._find_shard(first)
                self._waiting.popleft()
                self._bytes -= first.size
                self._hand_on(first.asked, first.message, shard)
        finally:
            self._looking = None
            for waiting in self._waiting:
                if asyncio.iscoroutine(waiting.shard):
                    # Python warns of those that nobody has waited for.
                    waiting.shard.close()

    async def _find_shard(self, first: _Waiting) -> str:
        if isinstance(first.shard, str):
            return first.shard
        try:
            async with asyncio.timeout(_LOOK_UP_S):
                return await first.shard
        except Exception as error:  # noqa: BLE001 - whatever keeps it from being known
            _LOG.warning("the shard of %s cannot be looked up: %r", first.asked.site[:100], error)
            return MAIN
