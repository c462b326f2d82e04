"""Dialling the hub for as long as the gateway runs, and saying each loss once."""

from __future__ import annotations

import asyncio
import logging
import random
from typing import TYPE_CHECKING

from talaia.gateway.errors import KeyRefused, LinkLost, RetryLater
from talaia.gateway.uplink.backoff import Backoff
from talaia.gateway.uplink.heartbeat import HeartbeatMonitor

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.clock import Clock

__all__ = ["OutageLog", "beside_link", "first_to_end", "keep_dialling"]

log = logging.getLogger(__name__)
# The link and what runs beside it are struck by one blow, but find out up to a beat apart.
GRACE_S = 1.25 * HeartbeatMonitor.PERIOD_S


class OutageLog:
    """What is said of a connection: its loss once, and that it is back once. Pure.

    A hub that dies is seen in several ways, one after another (closed, refused, no route): that
    is one loss. That it is there and turns our key down is another matter, and said besides.
    """

    def __init__(self) -> None:
        """Begin with nothing said."""
        # None: nothing was said since it was up. Else whether "refused" was what was said.
        self._said: bool | None = None

    def lost(self, *, refused: bool) -> bool:
        """Tell whether this loss is to be said."""
        fresh = self._said is None or (refused and not self._said)
        self._said = refused if fresh else self._said
        return fresh

    def back(self) -> bool:
        """Tell whether that it is back is to be said: a loss was."""
        was, self._said = self._said, None
        return was is not None


async def keep_dialling(
    what: str, once: Callable[[], Awaitable[None]], outage: OutageLog, clock: Clock
) -> None:
    """Dial for ever, waiting in between. An ``once`` that returns has nothing to be said of it."""
    # Not seeded: gateways that start together must not wait alike.
    backoff = Backoff(random.SystemRandom().random)
    while True:
        began = clock.monotonic_ns()
        refused, sent_away_s = False, None
        try:
            await once()
        except (KeyRefused, LinkLost) as error:
            refused = isinstance(error, KeyRefused)
            sent_away_s = error.after_s if isinstance(error, RetryLater) else None
            say = log.warning if outage.lost(refused=refused) else log.debug
            say("%s: %s; trying again", what, error)
        # The whole attempt counts; a handshake alone is far below `STABLE_S`.
        lasted = (clock.monotonic_ns() - began) / 1e9
        await asyncio.sleep(backoff.after(lasted, refused=refused, sent_away_s=sent_away_s))


async def beside_link(
    linked: asyncio.Event, number: Callable[[], int], once: Callable[[], Awaitable[None]]
) -> None:
    """Run ``once`` while there is a link; a loss is raised only if that link outlives it.

    What hinders both is tried once and said once, by the link.

    Args:
        linked: set while there is a link.
        number: counts the links.
        once: what runs beside it.

    """
    await linked.wait()
    ours = number()
    try:
        await once()
    except LinkLost:
        # If the link dies as well, it says the loss; only a link that outlives this makes it ours.
        await asyncio.sleep(GRACE_S)
        if linked.is_set() and number() == ours:
            raise


async def first_to_end(tasks: list[asyncio.Task[None]]) -> None:
    # Gathered before the results are read, so that no task outlives its socket.
    """Wait for the first to end, cancel the others, and raise what it raised."""
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    for task in done:
        task.result()
