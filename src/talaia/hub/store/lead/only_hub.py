"""One hub alone on a server's database: a second one is refused, unless both say ``--cluster``."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart
from talaia.hub.store.dialects.lead_words import MAIN_SHARD
from talaia.hub.store.lead.lead_lock import LeadLock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence

__all__ = ["WAIT_S", "hold_only_hub"]

# The server may not have seen yet that the hub before this one has ended (s).
WAIT_S = 5.0
# Nobody waits for the lock of a hub that is alone (s).
_LOOK_S = 1.0


@contextlib.asynccontextmanager
async def hold_only_hub(
    url: str,
    lost: Callable[[], None],
    *,
    shards: Sequence[str] = (),
    wait_s: float = WAIT_S,
) -> AsyncIterator[None]:
    """Have a server's database alone; ``lost`` is called, in a thread, when another one has it.

    Another one that is about to end is waited for ``wait_s``.

    ``shards``: those that hubs have agreed on, for a command that has them all.

    Raises:
        CannotStart: another hub uses it.

    """
    async with contextlib.AsyncExitStack() as held:
        for shard in (MAIN_SHARD, *shards):
            lock = _hold_lock(url, lost, shard=shard, shards=shards, wait_s=wait_s)
            await held.enter_async_context(lock)
        yield


@contextlib.asynccontextmanager
async def _hold_lock(
    url: str, lost: Callable[[], None], *, shard: str, shards: Sequence[str], wait_s: float
) -> AsyncIterator[None]:
    taken = threading.Event()
    lock = LeadLock(
        url,
        taken=taken.set,
        lost=lost,
        look_s=_LOOK_S,
        shard=shard,
        shards=shards,
        # Who has the main one's keeps all others from being led by another plan.
        any_plan=shard != MAIN_SHARD,
    )
    lock.start_looking()
    try:
        await asyncio.to_thread(lock.tried.wait)
        # A database that does not answer is told of by whoever opens it.
        if lock.answered_ms:
            await asyncio.to_thread(taken.wait, wait_s)
        if lock.answered_ms and not taken.is_set():
            raise CannotStart(
                "another hub uses this database",
                "end it, or start both with --cluster to make them one",
            )
        yield
    finally:
        await asyncio.to_thread(lock.stop_looking)
