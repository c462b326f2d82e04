"""One server of histories: opened when it is there, and again and again until it is."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from sqlalchemy.exc import SQLAlchemyError

from talaia.hub.errors import HubError
from talaia.hub.history.engine import address_of, open_engine
from talaia.hub.history.errors import HistoryAway
from talaia.hub.history.servers.write_term import WriteTerm
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.store.history_servers.history_homes import HistoryHomes

__all__ = ["HistoryServer"]

_LOG = logging.getLogger(__name__)
_FAILS = (HubError, SQLAlchemyError, OSError)


class HistoryServer:
    """A database beside the hub's own; the hub goes on while it is away.

    Attributes:
        name: by which this hub knows it.
        why: it cannot be used, in words; empty while it can.

    """

    def __init__(
        self, name: str, url: str, *, clock: Clock, limits: HistoryLimits, homes: HistoryHomes
    ) -> None:
        """Prepare for a URL; nothing is opened yet. ``homes`` gives the terms.

        Raises:
            HistoryError: the URL cannot be read, or its driver is not installed.

        """
        self.name = name
        self._url = url
        self._clock, self._limits, self._homes = clock, limits, homes
        self._store: HistoryStore | None = None
        self.why = "it was not opened yet"
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
        try:
            # Tables first; this also gives up within seconds where nobody answers.
            database = Database(self._url)
            try:
                await database.migrate()
            finally:
                await database.close()
            term = WriteTerm(await self._homes.own_name(), self.name)
            await self._claim_term(term)
            store = HistoryStore(self._url, self._clock, self._limits, term=term)
            try:
                await store.open()
            except BaseException:
                await store.close()
                raise
        except _FAILS as error:
            why = getattr(error, "orig", None) or getattr(error, "problem", None) or error
            if str(why) != self.why:
                _LOG.error("the history server %s is away: %s", self.name, why)
            self.why = str(why)
            return False
        self._store, self.why = store, ""
        _LOG.info("the history server %s is there: %s", self.name, self._address)
        return True

    async def close(self) -> None:
        """Store what waits, and let go of it."""
        store, self._store = self._store, None
        self.why = "it is closed"
        if store is not None:
            await store.close()

    async def _claim_term(self, term: WriteTerm) -> None:
        engine = open_engine(self._url, writes=True)
        try:
            seen = await asyncio.to_thread(term.read_term, engine)
            # From the accounts' database, where only the hub that leads can write.
            number = await self._homes.raise_term(seen)
            await asyncio.to_thread(term.claim_term, engine, number)
        finally:
            engine.dispose()
