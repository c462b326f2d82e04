"""Many who ask the database at once are answered by one query."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Mapping

__all__ = ["SharedLookup"]

KeyT = TypeVar("KeyT")
FoundT = TypeVar("FoundT")


class SharedLookup(Generic[KeyT, FoundT]):
    """Asks for all that wait, one query after the other.

    Nobody is answered by a query that began before they asked: what was revoked by then is not
    found.
    """

    def __init__(
        self, fetch: Callable[[Collection[KeyT]], Awaitable[Mapping[KeyT, FoundT]]]
    ) -> None:
        """Ask by ``fetch``, which leaves out what is not there."""
        self._fetch = fetch
        # Of the next query; the one that is under way has those of before.
        self._waiting: dict[KeyT, asyncio.Future[FoundT | None]] = {}
        self._asking: asyncio.Task[None] | None = None

    async def look_up(self, key: KeyT) -> FoundT | None:
        """Give what is found for ``key``; None: nothing is.

        Raises:
            Exception: what ``fetch`` raises.

        """
        answer = self._waiting.get(key)
        if answer is None:
            answer = self._waiting[key] = asyncio.get_running_loop().create_future()
        if self._asking is None:
            self._asking = asyncio.create_task(self._ask_for_all(), name="shared look-up")
        # Whoever goes away takes nothing from others who ask for the same.
        return await asyncio.shield(answer)

    async def _ask_for_all(self) -> None:
        try:
            while self._waiting:
                asked, self._waiting = self._waiting, {}
                await self._answer(asked)
        finally:
            self._asking = None

    async def _answer(self, asked: Mapping[KeyT, asyncio.Future[FoundT | None]]) -> None:
        try:
            found = await self._fetch(asked.keys())
        except Exception as error:  # noqa: BLE001 - told to all who wait
            for answer in asked.values():
                answer.set_exception(error)
                # Read here: whoever waited may have gone.
                answer.exception()
            return
        except BaseException:
            for answer in asked.values():
                answer.cancel()
            raise
        for key, answer in asked.items():
            answer.set_result(found.get(key))
