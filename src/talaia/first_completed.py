"""Side by side until the first ends."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Coroutine

__all__ = ["until_first"]


async def until_first(*parts: Coroutine[Any, Any, object]) -> list[object]:
    """Run all parts until one returns or raises, then cancel the rest.

    Returns:
        What each part returned or raised, in order; the cancelled ones a `CancelledError`.

    """
    tasks = [asyncio.create_task(part) for part in parts]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    # Also when whoever waits here is cancelled: no part runs on without it.
    finally:
        for task in tasks:
            task.cancel()
        # Until each has run its `finally`; failures come back as values, so none hides another.
        results = await asyncio.gather(*tasks, return_exceptions=True)
    return results
