"""Where each site is written and read now, and when it is not."""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import asynccontextmanager, contextmanager
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryAway
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Mapping

    from talaia.hub.history.servers.history_server import HistoryServer
    from talaia.hub.history.servers.server_file import HistoryServersFile
    from talaia.hub.history.store import HistoryStore
    from talaia.hub.store.history_servers.history_homes import HistoryHomes

__all__ = ["SitePlaces"]


class SitePlaces:
    """Each site on one server; on the event loop alone.

    Attributes:
        home_of: the server's name by site; a site that is not here was not asked for yet.

    """

    def __init__(
        self,
        own: HistoryStore,
        servers: Mapping[str, HistoryServer],
        named: HistoryServersFile,
        homes: HistoryHomes,
    ) -> None:
        """Have ``own``, the hub's own database, and ``servers``."""
        self._own, self._servers = own, servers
        # Where new sites are, and where that is written down.
        self._named, self._homes = named, homes
        self.home_of: dict[str, str] = {}
        # Sites of which nothing is written for a moment, each with what is set when it goes on.
        self._gates: dict[str, asyncio.Event] = {}
        # Descriptions and new names of a site come one after the other, and not within a move.
        self._describing: dict[str, asyncio.Lock] = {}
        # Who reads a site on a server now: what is there is not erased meanwhile.
        self._readers: Counter[tuple[str, str]] = Counter()
        # Set when one of them ends.
        self._unread = asyncio.Event()

    def store_named(self, name: str) -> HistoryStore:
        """Give a server's history.

        Raises:
            HistoryAway: it is away.

        """
        return self._own if name == OWN else self._servers[name].use_store()

    def open_stores(self) -> list[HistoryStore]:
        """Give the histories of all that are there."""
        opened = (server.opened for server in self._servers.values())
        return [self._own, *(store for store in opened if store is not None)]

    async def find_home(self, site: str) -> str:
        """Give the server of a site; of a new one it is written down first."""
        home = self.home_of.get(site)
        if home is not None:
            return home
        # Of before there were others, or of a restored backup: it stays where it is.
        known = self._own.transfer.has_site(site)
        first = OWN if known else self._named.first_home(site)
        if first != OWN:
            # Before anything is written there.
            first = (await self._homes.add_home(site, first)).server
        return self.home_of.setdefault(site, first)

    async def writing_store(self, site: str) -> HistoryStore:
        """Give where a site is written; nothing may be awaited until something is asked of it."""
        while True:
            home = await self.find_home(site)
            gate = self._gates.get(site)
            if gate is None:
                return self.store_named(home)
            await gate.wait()

    def store_of(self, site: str) -> HistoryStore:
        """Give where a site is read.

        Raises:
            HistoryAway: it is away.

        """
        return self.store_named(self.home_of.get(site, OWN))

    def opened_store(self, site: str) -> HistoryStore | None:
        """Give where a site is read; none: it is away."""
        try:
            return self.store_of(site)
        except HistoryAway:
            return None

    @contextmanager
    def reading(self, site: str) -> Iterator[HistoryStore]:
        """Read a site where it is now, to the end, though it move meanwhile.

        Raises:
            HistoryAway: it is away.

        """
        home = self.home_of.get(site, OWN)
        self._readers[site, home] += 1
        try:
            yield self.store_named(home)
        finally:
            self._readers[site, home] -= 1
            self._unread.set()

    async def wait_unread(self, site: str, server: str) -> None:
        """Wait until nobody reads a site where it was."""
        while self._readers[site, server]:
            self._unread.clear()
            await self._unread.wait()

    def describing_turn(self, site: str) -> asyncio.Lock:
        """Give what one has who describes a site, or moves it."""
        return self._describing.setdefault(site, asyncio.Lock())

    def is_held(self, site: str) -> bool:
        """Tell whether nothing of a site is written at present."""
        return site in self._gates

    @asynccontextmanager
    async def hold_writes(self, site: str) -> AsyncIterator[None]:
        """Let nothing of a site be written meanwhile; it waits."""
        async with self.describing_turn(site):
            gate = self._gates[site] = asyncio.Event()
            try:
                yield
            finally:
                # Whoever waits looks anew where to write.
                del self._gates[site]
                gate.set()
