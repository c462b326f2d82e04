"""Live values of some signals: as they come, for as long as somebody reads them.

A connection that is lost is made again, and that is told: by a word to whoever wants to know, and
by every value as stale until it is known anew.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from talaia.client.addresses import channels_of
from talaia.client.errors import HubNotReached, NotFound, TooManyRequests
from talaia.client.value_board import ValueBoard
from talaia.wire.browser import PagePing, PagePong, SiteUpdate, Subscribe, Subscribed, Values

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Callable, Sequence

    from talaia.client.hub_api import HubApi
    from talaia.client.page_socket import PageSocket
    from talaia.client.values import Reading, SiteInfo
    from talaia.wire.browser import ToBrowser

__all__ = ["ValueWatch"]

# Between two tries to connect (s): the first, and the longest.
_RETRY_S, _LONGEST_RETRY_S = 0.5, 10.0
# What waits for a script that reads slowly; then the oldest is left out.
_MOST_WAITING = 10_000
# A description that changes all the time must not make us ask all the time (s).
_CHANGED_S = 0.5


class _DescriptionChanged(Exception):
    """What is watched has to be found out anew."""


class ValueWatch:
    """One watch. Use `readings` once.

    Attributes:
        dropped: readings that were left out, since the script reads too slowly.

    """

    def __init__(
        self,
        api: HubApi,
        addresses: Sequence[str],
        *,
        every_ms: int,
        report: Callable[[str], None] | None = None,
    ) -> None:
        """Watch what qualified ``addresses`` mean.

        Args:
            api: the hub.
            addresses: with their sites.
            every_ms: at most so often for each channel; 0: every sample.
            report: is told in words when the connection is lost, and when it is back.

        """
        self.dropped = 0
        self._api = api
        self._addresses = addresses
        self._every_ms = every_ms
        self._report = report or (lambda _text: None)
        # By site, and by the number of its subscription.
        self._boards: dict[str, ValueBoard] = {}
        self._order: list[str] = []
        self._catalogues: dict[str, str] = {}
        self._waiting: deque[Reading] = deque()
        self._news = asyncio.Event()

    async def readings(self) -> AsyncGenerator[Reading]:
        """Give each reading as it comes, and what becomes stale, until no longer wanted.

        Raises:
            ClientError: the hub says no for good, at the beginning or later.

        """
        pump = asyncio.create_task(self._pump())
        # The end of the pump, by an error, has to wake whoever waits.
        pump.add_done_callback(lambda _task: self._news.set())
        try:
            while True:
                while self._waiting:
                    yield self._waiting.popleft()
                if pump.done():
                    pump.result()
                    return
                await self._news.wait()
                self._news.clear()
        finally:
            pump.cancel()
            with suppress(asyncio.CancelledError, Exception):
                await pump

    async def read_once(self) -> list[Reading]:
        """Give what is known now, in the order of the addresses, and end.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        async with self._api.open_socket("/ws") as socket:
            sizes = await self._subscribe(socket)
            await self._hear_known(socket, sizes)
        now_s = time.monotonic()
        return [
            reading for site in self._order for reading in self._boards[site].newest_readings(now_s)
        ]

    async def _pump(self) -> None:
        retry_s, lost = _RETRY_S, False
        while True:
            began_s = time.monotonic()
            try:
                await self._follow(greeted=lost)
            except _DescriptionChanged:
                await asyncio.sleep(_CHANGED_S)
                continue
            except (HubNotReached, TooManyRequests) as error:
                # The first time there is nothing to go on with: the script is to know at once.
                if not self._boards:
                    raise
                self._enqueue_stale(str(error))
                if not lost or time.monotonic() - began_s > _LONGEST_RETRY_S:
                    self._report(f"{error}; trying again")
                    retry_s = _RETRY_S
                lost = True
            await asyncio.sleep(retry_s)
            retry_s = min(2 * retry_s, _LONGEST_RETRY_S)

    async def _follow(self, *, greeted: bool) -> None:
        """Watch over one connection, until it is lost."""
        async with self._api.open_socket("/ws") as socket:
            await self._subscribe(socket)
            if greeted:
                self._report("connected again")
            while True:
                now_s = time.monotonic()
                due_s = min(board.due_s() for board in self._boards.values())
                try:
                    async with asyncio.timeout(max(0.0, due_s - now_s) if due_s < 1e15 else None):
                        message = await socket.receive_message()
                except TimeoutError:
                    now_s = time.monotonic()
                    for board in self._boards.values():
                        self._enqueue(board.find_overdue(now_s))
                else:
                    self._observe(message)

    async def _subscribe(self, socket: PageSocket) -> int:
        """Ask for all channels; give how many sites they are of."""
        # After the socket is open: a description that changes from here on is told.
        sites = await self._api.describe_sites_of(self._addresses)
        self._order = [site.site for site in sites]
        self._catalogues = {site.site: site.catalogue for site in sites}
        found = 0
        for number, site in enumerate(sites):
            found += await self._subscribe_site(socket, number, site)
        if not found:
            asked = " ".join(self._addresses)
            raise NotFound("unknown", f"there is no signal {asked!r} that this token may see")
        return len(sites)

    async def _subscribe_site(self, socket: PageSocket, number: int, site: SiteInfo) -> int:
        channels = channels_of(site, self._addresses)
        self._boards.setdefault(site.site, ValueBoard(site.site)).change_channels(channels)
        await socket.send_message(
            Subscribe(
                sub=number,
                site=site.site,
                channels=[channel.channel for channel in channels],
                every_ms=self._every_ms,
            )
        )
        return len(channels)

    async def _hear_known(self, socket: PageSocket, subscribed: int) -> None:
        """Hear the newest known value of each channel."""
        waiting = set(range(subscribed))
        pongs = 0
        if not waiting:
            return
        while True:
            message = await socket.receive_message()
            self._observe(message)
            if isinstance(message, Subscribed):
                waiting.discard(message.sub)
                # Asked twice: a short answer may overtake the first values once, not again.
                if not waiting:
                    await socket.send_message(PagePing(n=1, at_ms=0.0))
            elif isinstance(message, PagePong) and not waiting:
                pongs += 1
                if pongs == 2:
                    return
                await socket.send_message(PagePing(n=2, at_ms=0.0))

    def _observe(self, message: ToBrowser) -> None:
        now_s = time.monotonic()
        if isinstance(message, Values):
            if message.sub < len(self._order):
                board = self._boards[self._order[message.sub]]
                self._enqueue(board.observe_message(message, now_s))
            return
        if isinstance(message, SiteUpdate) and message.site in self._catalogues:
            known = self._catalogues[message.site]
            if message.catalogue and message.catalogue != known:
                raise _DescriptionChanged
        for board in self._boards.values():
            self._enqueue(board.observe_message(message, now_s))

    def _enqueue_stale(self, why: str) -> None:
        now_s = time.monotonic()
        for board in self._boards.values():
            self._enqueue(board.lose_hub(why, now_s))

    def _enqueue(self, readings: Sequence[Reading]) -> None:
        if not readings:
            return
        self._waiting.extend(readings)
        while len(self._waiting) > _MOST_WAITING:
            self._waiting.popleft()
            self.dropped += 1
        self._news.set()
