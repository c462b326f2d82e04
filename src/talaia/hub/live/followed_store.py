"""Follows what other hubs write into the database that all share."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

__all__ = ["follow_store"]


async def follow_store(
    look: Callable[[], Awaitable[None]], *, every_s: float, failed: Callable[[StoreDown], None]
) -> None:
    """Call ``look`` so often (s) until cancelled; ``failed`` is told of each loss once."""
    failing = False
    while True:
        await asyncio.sleep(every_s)
        try:
            await look()
        except StoreDown as error:
            # Once, and not at each look.
            if not failing:
                failed(error)
            failing = True
        else:
            failing = False
