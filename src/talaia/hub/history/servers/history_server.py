"""One server of histories: opened when it is there, and again and again until it is."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import HubError
from talaia.hub.history.connection_cut import ConnectionCut
from talaia.hub.history.engine import address_of, open_engine
from talaia.hub.history.errors import HistoryAway
from talaia.hub.history.servers.server_pulse import ServerPulse
from talaia.hub.history.servers.write_term import WriteTerm
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.store.history_servers.history_homes import HistoryHomes

__all__ = ["HistoryServer"]

_LOG = logging.getLogger(__name__)
# A server that has not answered for so long stands still (s).
STILL_S = 8.0
# To open one takes no longer than this (s), beside that.
_OPENING_S = 30.0
_FAREWELL_S = 2.0
_UNOPENED = "it was not opened yet"
_FAILS = (HubError, SQLAlchemyError, OSError)


class HistoryServer:
    """A database beside the hub's own; the hub goes on while it is away.

    Attributes:
        name: by which this hub knows it.
        why: it cannot be used, in words; empty while it can.

    """

    def __init__(
        self,
        name: str,
        url: str,
        *,
        clock: Clock,
        limits: HistoryLimits,
        homes: HistoryHomes,
        still_s: float = STILL_S,
    ) -> None:
        """Prepare for a URL; nothing is opened yet. ``homes`` gives the terms.

        A server that does not answer for ``still_s`` is away.

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        self.name = name
        self._url = url
        self._clock, self._limits, self._homes = clock, limits, homes
        self._store: HistoryStore | None = None
        self._still_s = still_s
        # Of what is open now: tells whether the server answers, and ends all that waits for it.
        self._pulse: ServerPulse | None = None
        self._cut = ConnectionCut()
        # Stores of a server that stood still, on their way to their end.
        self._ending: set[asyncio.Task[None]] = set()
        self.why = _UNOPENED
        # For messages; also refuses a URL that cannot be read.
        self._address = address_of(url)

    @property
    def opened(self) -> HistoryStore | None:
        """Its history; none while it is away."""
        return self._store

    def use_store(self) -> HistoryStore:
        """Give its history.

        Raises:
            HistoryAway: it is away.

        """
        if self._store is None:
            raise HistoryAway(
                f"the server {self.name!r} is away: {self.why}",
                "what gateways have waits there; it comes by itself",
            )
        return self._store

    async def try_open(self) -> bool:
        """Open it unless it is open; tell whether it was opened now."""
        if self._store is not None:
            return False
        cut, pulse = ConnectionCut(), ServerPulse(self._url, self._still_s)
        if not await pulse.beats():
            pulse.end()
            self._be_away(f"it has not answered for {self._still_s:g} s")
            return False
        try:
            async with asyncio.timeout(self._still_s + _OPENING_S):
                self._store = await self._open_store(cut)
        except (*_FAILS, TimeoutError) as error:
            # Whatever waits for it in a thread is over, too.
            cut.cut_all()
            pulse.end()
            why = getattr(error, "orig", None) or getattr(error, "problem", None) or error
            self._be_away(str(why) or "it does not answer")
            return False
        self._cut, self._pulse = cut, pulse
        if self.why not in ("", _UNOPENED):
            _LOG.warning("the history server %s is there again", self.name)
        self.why = ""
        _LOG.info("the history server %s is there: %s", self.name, self._address)
        return True

    async def check_pulse(self) -> None:
        """See that it answers; one that stands still is away, and whoever waits for it is told."""
        if self._pulse is None or await self._pulse.beats() or self._store is None:
            return
        self._be_away(f"it has not answered for {self._still_s:g} s")
        self._begin_ending()

    async def close(self) -> None:
        """Store what waits, unless the server stands still, and let go of it."""
        if self._pulse is not None and not await self._pulse.beats():
            self._begin_ending()
        store, self._store = self._store, None
        self.why = "it is closed"
        if store is not None:
            await store.close()
        if self._pulse is not None:
            self._pulse.end()
        await asyncio.gather(*self._ending, return_exceptions=True)

    def _be_away(self, why: str) -> None:
        if why != self.why:
            _LOG.error("the history server %s is away: %s", self.name, why)
        self.why = why

    def _begin_ending(self) -> None:
        """End what is open without the server: it is opened anew, under a term of its own.

        So a commit that is on its way yet comes before that, or never.
        """
        store, self._store = self._store, None
        pulse, self._pulse = self._pulse, None
        self._cut.cut_all()
        if pulse is not None:
            pulse.end()
        if store is not None:
            ending = asyncio.create_task(store.close(), name=f"end {self.name}")
            self._ending.add(ending)
            ending.add_done_callback(self._ending.discard)

    async def _open_store(self, cut: ConnectionCut) -> HistoryStore:
        # Tables first; this also gives up within seconds where nobody answers.
        database = Database(self._url)
        try:
            await database.migrate()
        finally:
            # One that stands still does not answer a farewell either.
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_FAREWELL_S):
                    await database.close()
        term = WriteTerm(await self._homes.own_name(), self.name)
        await self._claim_term(term, cut)
        store = HistoryStore(self._url, self._clock, self._limits, term=term, cut=cut)
        try:
            await store.open()
        except BaseException:
            # Whatever it waits for in a thread is over first.
            cut.cut_all()
            await store.close()
            raise
        return store

    async def _claim_term(self, term: WriteTerm, cut: ConnectionCut) -> None:
        engine = open_engine(self._url, writes=True, cut=cut)
        try:
            seen = await asyncio.to_thread(term.read_term, engine)
            # From the accounts' database, where only the hub that leads can write.
            number = await self._homes.raise_term(seen)
            await asyncio.to_thread(term.claim_term, engine, number)
        finally:
            engine.dispose()
