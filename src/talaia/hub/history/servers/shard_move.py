"""A site's history comes from another shard's server: the lead that is to have it copies it.

Up to the last moment all is as in a move between two servers of one lead (`SiteMove`), but that the
old place is only read. For the last moment this lead asks the other one to write nothing of the
site, by words in the site's row; see `ShardHolds` for its side. The commit that says where the site
is happens only while the hold stands there.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.history.errors import HistoryError
from talaia.hub.history.servers.other_history import OtherHistory
from talaia.hub.history.servers.site_copy import GATE_S, SiteCopy
from talaia.hub.history.servers.write_term import WriteTerm
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.history_servers.shard_handover import HoldWord, word_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.history.servers.late_descriptions import LateDescriptions
    from talaia.hub.history.servers.server_file import HistoryServersFile
    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes
    from talaia.hub.store.history_servers.shard_handover import ShardHandover

__all__ = ["ANSWER_S", "ShardArrivals", "ShardMove"]

# Between two looks at what the other lead says (s), and how long it may take to answer.
_LOOK_S = 0.05
ANSWER_S = 20.0


class ShardMove:
    """One move from another shard, from wherever the one before it ended."""

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        home: HistoryHome,
        *,
        handover: ShardHandover,
        other: str,
        answer_s: float = ANSWER_S,
    ) -> None:
        """Do what ``home`` says.

        ``other`` names the shard that it comes from; its lead is waited for ``answer_s``.
        """
        self._places, self._homes = places, homes
        # What it waited for is over until it is seen again.
        self._copy = SiteCopy(places, descriptions, homes, home._replace(problem=""))
        self._handover, self._other = handover, other
        self._answer_s = answer_s

    async def run(self, source: OtherHistory) -> None:
        """Copy the site from ``source``, and let it be here.

        Raises:
            HistoryError: a server or the other lead is away; it goes on later.
            StoreDown: the accounts' database is.

        """
        copy, site = self._copy, self._copy.home.site
        if copy.home.erase_at == copy.home.moving_to:
            # Of when it was here before.
            await copy.erase_left()
        if copy.home.erase_at:
            raise HistoryError(f"what was left at {copy.home.erase_at!r} is to be erased before")
        target = self._places.store_named(copy.home.moving_to)
        await source.check_owner()
        await copy.begin_copy(target)
        async with copy.explain_failures(target):
            await copy.copy_hot(source, target.transfer)
            begun = await self._handover.begin_hold(copy.home)
            await self._hear(begun, HoldWord.SEALED)
            await copy.copy_more(source, target.transfer)
            await self._hear(
                await self._handover.write_word(copy.home, HoldWord.HOLD), HoldWord.HELD
            )
            async with asyncio.timeout(GATE_S):
                await copy.copy_rest(source, target)
            await copy.switch_home(led_by=copy.home.server)
            await target.transfer.clear_copied(site)

    async def _hear(self, said: HistoryHome | None, answer: HoldWord) -> None:
        """Wait until the other lead has answered what was said; none: the row is another one."""
        until_s = asyncio.get_running_loop().time() + self._answer_s
        while said is not None:
            found = await self._homes.find_home(said.site)
            if found is None or (found.move, found.server) != (said.move, said.server):
                break
            if found.hold != said.hold:
                if word_of(found.hold) != answer:
                    raise HistoryError(
                        f"the lead of the shard {self._other!r} took back what it held",
                        "it is tried again",
                    )
                self._copy.home = self._copy.home._replace(hold=found.hold)
                return
            if asyncio.get_running_loop().time() > until_s:
                await self._handover.end_hold(said)
                raise HistoryError(
                    f"the lead of the shard {self._other!r} does not answer", "it is tried again"
                )
            await asyncio.sleep(_LOOK_S)
        raise HistoryError(f"the move of {self._copy.home.site} was asked for otherwise meanwhile")


class ShardArrivals:
    """Brings sites of other shards to a lead's own servers."""

    def __init__(
        self,
        places: SitePlaces,
        descriptions: LateDescriptions,
        homes: HistoryHomes,
        *,
        handover: ShardHandover,
        named: HistoryServersFile,
        own_url: str,
        begin_anew: Callable[[], None],
        answer_s: float = ANSWER_S,
    ) -> None:
        """Bring them to ``places``.

        Args:
            places: of this lead.
            descriptions: what is known of sites.
            homes: which server has which site.
            handover: what the leads of two shards say to each other.
            named: the file of servers.
            own_url: of the hub's own database.
            begin_anew: called once a site is here: this lead closes, and opens with it.
            answer_s: another lead is waited for so long.

        """
        self._places, self._descriptions, self._homes = places, descriptions, homes
        self._handover, self._named, self._own_url = handover, named, own_url
        self._begin_anew, self._answer_s = begin_anew, answer_s

    async def bring_site(self, home: HistoryHome) -> None:
        """Bring one, as ``home`` says.

        Raises:
            HistoryError: a server or the other lead is away; it goes on later.
            StoreDown: the accounts' database is.

        """
        url, term = self._own_url, None
        if home.server != OWN:
            url = self._named.servers[home.server]
            term = WriteTerm(await self._homes.own_name(), home.server)
        move = ShardMove(
            self._places,
            self._descriptions,
            self._homes,
            home,
            handover=self._handover,
            other=self._named.plan.shard_of_server(home.server),
            answer_s=self._answer_s,
        )
        source = OtherHistory(url, term)
        try:
            await move.run(source)
        finally:
            await source.close()
        self._begin_anew()
