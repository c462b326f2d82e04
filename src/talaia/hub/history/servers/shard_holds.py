"""The side of a shard's lead whose sites go to other shards: it holds their last moment.

Once it has said that nothing of a site is written, it writes nothing of it until it has taken that
back; and that, and the commit by which the site is elsewhere, exclude each other. So a sample that
it acknowledges is copied, or stays.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.hub.errors import HubError, StoreDown
from talaia.hub.history.errors import HistoryError
from talaia.hub.history.servers.site_copy import GATE_S
from talaia.hub.store.history_servers.home_tables import NOBODY
from talaia.hub.store.history_servers.shard_handover import HoldWord, with_word, word_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.hub.history.servers.site_places import SitePlaces
    from talaia.hub.store.history_servers.history_homes import HistoryHome, HistoryHomes
    from talaia.hub.store.history_servers.shard_handover import ShardHandover

__all__ = ["ShardHolds"]

_LOG = logging.getLogger(__name__)
# Between two looks: while nothing changes its shard, while something does, and while a site is
# held (s).
_LOOK_S, _SOON_S, _AT_ONCE_S = 1.0, 0.2, 0.05
# Between two questions whether a commit happened (s).
_ASK_S = 1.0


class ShardHolds:
    """Answers the leads of other shards, of sites that go to them."""

    def __init__(
        self,
        places: SitePlaces,
        homes: HistoryHomes,
        handover: ShardHandover,
        *,
        begin_anew: Callable[[], None],
        gate_s: float = GATE_S,
    ) -> None:
        """Hold sites of ``places``, each ``gate_s`` at most.

        ``begin_anew`` is called when a site has gone to another shard, or has come from one: this
        lead is to close and to open again.
        """
        self._places, self._homes, self._handover = places, homes, handover
        self._begin_anew = begin_anew
        self._gate_s = gate_s

    async def run(self) -> None:
        """Answer until cancelled."""
        while True:
            pause_s = _LOOK_S
            try:
                pause_s = await self._answer_all()
            except StoreDown as error:
                _LOG.debug("what other shards ask is not known: %s", error)
            await asyncio.sleep(pause_s)

    async def _answer_all(self) -> float:
        """Answer all that is asked now; give when to look again (s)."""
        changing = await self._handover.list_changing()
        pause_s = _LOOK_S
        for home in changing:
            if self._is_other_shards(home):
                self._begin_anew()
            elif not self._places.has_server(home.server):
                continue
            elif home.hold:
                pause_s = _SOON_S
                try:
                    await self._answer_asked(home)
                except HubError as error:
                    _LOG.warning("%s cannot go to another shard yet: %s", home.site, error)
            elif home.moving_to and not self._places.has_server(home.moving_to):
                pause_s = min(pause_s, _SOON_S)
        return pause_s

    def _is_other_shards(self, home: HistoryHome) -> bool:
        """Tell whether a site has gone, or is to be taken, and this lead has it otherwise."""
        if not home.led_by:
            return False
        mine = self._places.has_server(home.server)
        if home.led_by == NOBODY:
            return mine
        return self._places.has_server(home.led_by) and not mine

    async def _answer_asked(self, home: HistoryHome) -> None:
        match word_of(home.hold):
            case HoldWord.SEAL:
                transfer = self._places.store_named(home.server).transfer
                await transfer.seal_site(home.site)
                await self._handover.write_word(home, HoldWord.SEALED)
            case HoldWord.HOLD:
                await self._hold_site(home)
            case HoldWord.HELD:
                # Of a hold that was broken off here.
                self._places.shut_site(home.site)
                await self._end_hold(home)
            case _:
                # What it has answered: the other lead goes on.
                pass

    async def _hold_site(self, home: HistoryHome) -> None:
        site = home.site
        began_s = asyncio.get_running_loop().time()
        async with self._places.hold_writes(site):
            transfer = self._places.store_named(home.server).transfer
            try:
                async with asyncio.timeout(self._gate_s):
                    await transfer.seal_all(site)
                    await transfer.write_runs(site)
            except TimeoutError:
                await self._handover.end_hold(home)
                raise HistoryError(f"{site} could not be held: its server stands still") from None
            # From here on another lead may have it, whatever becomes of this one.
            self._places.shut_site(site)
            held = home._replace(hold=with_word(home.hold, HoldWord.HELD))
            try:
                if await self._handover.write_word(home, HoldWord.HELD) is None:
                    self._places.unshut_site(site)
                    return
            except StoreDown:
                # It may be said yet, until it is taken back.
                _LOG.warning("it is not known whether %s is held; nothing of it is written", site)
                await self._end_hold(held)
                return
            await self._wait_for_end(held, began_s + self._gate_s)

    async def _wait_for_end(self, held: HistoryHome, until_s: float) -> None:
        """Wait until the site has moved, or the hold is over; it is taken back in time."""
        clock = asyncio.get_running_loop()
        while clock.time() < until_s:
            try:
                found = await self._homes.find_home(held.site)
            except StoreDown:
                await asyncio.sleep(_ASK_S)
                continue
            if found is None or found.hold != held.hold:
                self._end_here(held, found)
                return
            await asyncio.sleep(_AT_ONCE_S)
        await self._end_hold(held)

    async def _end_hold(self, held: HistoryHome) -> None:
        while True:
            try:
                found = await self._handover.end_hold(held)
            except StoreDown:
                # The other lead may have it: nothing is written before that is known.
                await asyncio.sleep(_ASK_S)
            else:
                self._end_here(held, found)
                return

    def _end_here(self, held: HistoryHome, found: HistoryHome | None) -> None:
        """Write again where the site is; where it is another lead's, nothing more."""
        if found is not None:
            self._places.home_of[held.site] = found.server
            if found.server != held.server:
                _LOG.info("%s is of another shard from now on", held.site)
                self._begin_anew()
            elif word_of(found.hold) == HoldWord.HELD:
                return
        self._places.unshut_site(held.site)
