"""Follows which messages about alarms could not be delivered, where another hub delivers them."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.hub.live.followed_store import follow_store

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.hub.errors import StoreDown
    from talaia.hub.store.alarms.notification_outbox import NotificationOutbox

__all__ = ["follow_troubles"]

_LOG = logging.getLogger(__name__)
# Between two looks (s).
_LOOK_S = 1.0


async def follow_troubles(
    outbox: NotificationOutbox,
    refresh: Callable[[], Awaitable[None]],
    *,
    every_s: float = _LOOK_S,
) -> None:
    """Call ``refresh`` whenever something has changed in ``outbox``, until cancelled."""
    known: tuple[int, ...] = ()

    async def refresh_changed() -> None:
        nonlocal known
        mark = await outbox.trouble_mark()
        if mark != known:
            await refresh()
        known = mark

    def say_failed(error: StoreDown) -> None:
        _LOG.warning("which messages are not delivered is not known now: %s", error)

    await follow_store(refresh_changed, every_s=every_s, failed=say_failed)
