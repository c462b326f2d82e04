"""Accounts and a history in a file, and another server, of each kind that is there."""

import dataclasses
import shutil
from contextlib import asynccontextmanager

import pytest

from talaia.clock import SystemClock
from talaia.hub.history.servers.history_server import STILL_S
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import HistoryServersFile
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.database import Database
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN

from ...databases import origin_of
from ..conftest import SMALL

# Nearly every commit seals, saves a slow channel or empties the journal.
TINY = SMALL._replace(block=8, largest=8, recent=4, journal=8, delete=1, tidy_s=0)


@dataclasses.dataclass
class Place:
    """Where a hub's databases are."""

    accounts: str
    east: str
    default: str = OWN

    @asynccontextmanager
    async def opened(self, limits=TINY, still_s=STILL_S):
        """Open what a hub has open; give its history, and the homes."""
        database = Database(self.accounts)
        await database.migrate()
        homes = HistoryHomes(database)
        named = HistoryServersFile(servers={"east": self.east}, default=self.default)
        own = HistoryStore(self.accounts, SystemClock(), limits)
        servers = HistoryServers(
            own, named, homes, clock=SystemClock(), limits=limits, still_s=still_s
        )
        try:
            await servers.open()
            yield servers, homes
        finally:
            await servers.close()
            await database.close()


@pytest.fixture
def place(tmp_path, database_url):
    """Give two databases: a file with the accounts, and another one that is empty."""
    folder = tmp_path / "hub"
    folder.mkdir()
    shutil.copy(origin_of("sqlite"), folder / "talaia.db")
    return Place(f"sqlite:///{folder}/talaia.db", database_url)
