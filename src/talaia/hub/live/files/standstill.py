"""Ends uploads that stand still, also those of gateways that never come again."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import StoreDown

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

__all__ = ["STANDSTILL_S", "end_standing_for_ever"]

_LOG = logging.getLogger(__name__)
# An upload that nobody has gone on with for so long ends (s): a robot may be away for days.
STANDSTILL_S = 14 * 86_400
_EVERY_S = 3_600.0


async def end_standing_for_ever(
    ends: Sequence[Callable[[], Awaitable[None]]], every_s: float = _EVERY_S
) -> None:
    """Call each of ``ends`` now and then, until cancelled."""
    while True:
        for end in ends:
            try:
                await end()
            # The next turn finds what is left.
            except (StoreDown, OSError) as error:
                _LOG.warning("uploads that stand still are looked at later: %s", error)
        await asyncio.sleep(every_s)
