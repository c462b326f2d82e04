"""Waiting that cancellation does not cut short, for what must not run on unknown to anybody."""

from __future__ import annotations

import asyncio
from typing import Any

__all__ = ["outlast_cancellation"]


async def outlast_cancellation(task: asyncio.Future[Any]) -> asyncio.CancelledError | None:
    """Wait until a task is done, however often this one is cancelled meanwhile.

    Returns the last cancellation, for the caller to raise when it has cleaned up; none when there
    was none. The task's own result or error is left in it.
    """
    cancelled: asyncio.CancelledError | None = None
    while not task.done():
        try:
            # `wait` leaves the task alone when we are cancelled; awaiting it would cancel it, too.
            await asyncio.wait([task])
        except asyncio.CancelledError as error:
            cancelled = error
    return cancelled
