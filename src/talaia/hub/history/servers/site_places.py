"""Where each site is written and read now, and when it is not.

A hub that is the lead of a shard has that shard's servers alone: what is on another one is refused.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from contextlib import asynccontextmanager, contextmanager
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryAway, HistoryElsewhere
from talaia.hub.sharding.plan import MAIN
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
        own: HistoryStore | None,
        servers: Mapping[str, HistoryServer],
        named: HistoryServersFile,
        homes: HistoryHomes,
        *,
        shard: str | None = None,
    ) -> None:
        """Have ``own``, the hub's own database, and ``servers``.

        ``shard``: whose these are, of a hub that has no others; none: these are all.
        """
        self._own, self._servers, self._shard = own, servers, shard
        # Where new sites are, and where that is written down.
        self._named, self._homes = named, homes
        self.home_of: dict[str, str] = {}
        # Sites of which nothing is written for a moment, each with what is set when it goes on.
        self._gates: dict[str, asyncio.Event] = {}
        # Sites that another lead may have by now: nothing of them is written before it is known.
        self._shut: set[str] = set()
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
        if name == OWN and self._own is not None:
            return self._own
        if name not in self._servers:
            shard = self._named.plan.shard_of_server(name)
            said = f"histories on {name!r} are of the shard {shard!r}"
            raise HistoryElsewhere(said, "ask its lead")
        return self._servers[name].use_store()

    def has_server(self, name: str) -> bool:
        """Tell whether a server is one of these, there or away."""
        return name in self._servers or (name == OWN and self._own is not None)

    def list_servers(self) -> list[str]:
        """Name these servers, there or away."""
        return list(self._servers) if self._own is None else [OWN, *self._servers]

    def open_stores(self) -> list[HistoryStore]:
        """Give the histories of all that are there."""
        opened = (self._own, *(server.opened for server in self._servers.values()))
        return [store for store in opened if store is not None]

    async def find_home(self, site: str) -> str:
        """Give the server of a site; of a new one it is written down first.

        Raises:
            HistoryAway: it is another shard's.
            StoreDown: the accounts' database does not answer.

        """
        home = self.home_of.get(site)
        if home is not None:
            return home
        if self._own is None:
            return await self._ask_home(site)
        first = OWN
        # Of before there were others, or of a restored backup: it stays where it is.
        if not self._own.transfer.has_site(site):
            # What another shard is to have gets its row before it is led there.
            without = self._named.shards if self._shard else ()
            counts = Counter(self.home_of.values())
            first = self._named.first_home(site, counts, without=without)
        # Before anything is written there. Where sites are divided, one without a row may be given
        # to another shard at any moment.
        if first != OWN or self._named.shards:
            first = (await self._homes.add_home(site, first)).server
        return self.home_of.setdefault(site, first)

    async def _ask_home(self, site: str) -> str:
        found = await self._homes.find_home(site)
        if found is None:
            raise HistoryElsewhere(f"{site} is of the shard {MAIN!r}", "ask its lead")
        return self.home_of.setdefault(site, found.server)

    async def writing_store(self, site: str) -> HistoryStore:
        """Give where a site is written; nothing may be awaited until something is asked of it.

        Raises:
            HistoryAway: it is away, or another shard's.
            StoreDown: the accounts' database does not answer.

        """
        while True:
            home = await self.find_home(site)
            gate = self._gates.get(site)
            if gate is None:
                if site in self._shut:
                    said = f"the history of {site} goes to another shard"
                    raise HistoryElsewhere(said, "come again")
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
        return site in self._gates or site in self._shut

    def shut_site(self, site: str) -> None:
        """Write nothing of a site any more, whatever becomes of who holds it."""
        self._shut.add(site)

    def unshut_site(self, site: str) -> None:
        """Write a site again: it is known whose it is."""
        self._shut.discard(site)

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
