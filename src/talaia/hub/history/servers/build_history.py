"""The history of the settings: one database, or several."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import read_history_servers
from talaia.hub.history.store import HistoryStore
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.history.limits import HistoryLimits
    from talaia.hub.settings import Settings
    from talaia.hub.store.database import Database
    from talaia.hub.store.database_url import OnConnect

__all__ = ["build_history", "check_homes"]


def build_history(
    settings: Settings,
    database: Database,
    clock: Clock,
    limits: HistoryLimits,
    *,
    on_connect: OnConnect | None = None,
) -> HistoryStore | HistoryServers:
    """Make it; nothing is opened yet. ``database`` has the accounts.

    Raises:
        CannotStart: the file that names servers cannot be used.
        HistoryError: a URL cannot be read, or its driver is not installed.

    """
    own = HistoryStore(settings.url, clock, limits, on_connect=on_connect)
    if settings.history_servers is None:
        return own
    named = read_history_servers(settings.history_servers)
    return HistoryServers(own, named, HistoryHomes(database), clock=clock, limits=limits)


async def check_homes(database: Database) -> None:
    """See that all histories are in the hub's own database, where no others are named.

    Raises:
        CannotStart: one is elsewhere; what came would be stored in two places.

    """
    for home in await HistoryHomes(database).list_homes():
        for name in (home.server, home.moving_to, home.erase_at):
            if name not in {"", OWN}:
                raise CannotStart(
                    f"the history of {home.site} is on the server {name!r}",
                    "name it with --history-servers, as before",
                )
