"""A move is asked for in the accounts' database; the hub does it, or this where none runs."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING

from talaia.cli.errors import CliError
from talaia.clock import SystemClock
from talaia.hub.accounts import append_audit_record
from talaia.hub.errors import CannotStart
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.servers.build_history import build_history
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.lock import HubRuns, hub_lock
from talaia.hub.sharding.plan import ShardPlan
from talaia.hub.store.database import open_migrated
from talaia.hub.store.database_url import parse_database_url
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.lead.hub_plan import read_shards
from talaia.hub.store.lead.only_hub import WAIT_S, hold_only_hub
from talaia.hub.store.sites.site_registry import SiteRegistry

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from talaia.hub.settings import Settings
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.history_homes import HistoryHome

__all__ = ["list_histories", "move_history"]

# Between two looks at how far it is (s).
_LOOK_S = 1.0


async def list_histories(settings: Settings, tell: Callable[[str], None]) -> None:
    """Tell which server has which site's history, and which shard that is.

    Raises:
        HubError: the database cannot be opened.

    """
    async with open_migrated(settings.url) as database:
        plan = await _read_plan(database)
        homes = {home.site: home for home in await HistoryHomes(database).list_homes()}
        sites = {known.site for known in await SiteRegistry(database, SystemClock()).list_sites()}
    for site in sorted(sites | homes.keys()):
        home = homes.get(site)
        line = f"{site}: {OWN}" if home is None else _line_of(home)
        shard = plan.shard_of_server(OWN if home is None else home.server)
        tell(f"{line} (shard {shard})" if plan.names else line)


async def move_history(
    settings: Settings,
    site: str,
    server: str,
    tell: Callable[[str], None],
    *,
    wait_s: float = WAIT_S,
) -> None:
    """Move a site's history, and tell how far it is.

    A hub that is about to end is waited for ``wait_s``, where none may run.

    Raises:
        HubError: the database cannot be opened.
        CliError: there is no such site.

    """
    async with open_migrated(settings.url) as database:
        homes = HistoryHomes(database)
        known = {known.site for known in await SiteRegistry(database, SystemClock()).list_sites()}
        before = await homes.find_home(site)
        if site not in known and before is None:
            raise CliError(f"there is no site {site!r}; talaia history list names them")
        asked = await homes.ask_move(site, server, own=OWN)
        if before is None or before.moving_to != asked.moving_to:
            said = f"the history of {site} from {asked.server} to {server}"
            await append_audit_record(database, "history moved", said, site)
        line = ""
        while await _find_move(homes, site):
            # Where no hub runs, none begins before it is done; else the hubs do it.
            async with _without_hubs(settings, database, wait_s) as alone:
                while home := await _find_move(homes, site):
                    if (now := _line_of(home)) != line:
                        line = now
                        tell(line)
                    if not alone:
                        break
                    await _move_once(settings, database)
                    await asyncio.sleep(_LOOK_S)
            # Whoever is about to end has ended: a lock that is free now is another hub's to take.
            wait_s = 0.0
            await asyncio.sleep(_LOOK_S)
    tell(f"{site}: {server}")


async def _read_plan(database: Database) -> ShardPlan:
    """Give the shards that hubs have agreed on; a file may say otherwise from their next start."""
    return ShardPlan(tuple(await read_shards(database)))


async def _find_move(homes: HistoryHomes, site: str) -> HistoryHome | None:
    """Give a site's row while something is to be done of its move."""
    home = await homes.find_home(site)
    return home if home is not None and (home.moving_to or home.erase_at) else None


async def _move_once(settings: Settings, database: Database) -> None:
    limits = HistoryLimits(show_s=0, tidy_s=0)
    history = build_history(settings, database, SystemClock(), limits)
    if not isinstance(history, HistoryServers):
        raise CliError("--history-servers: name the file that names them, as for the hub")
    await history.open()
    try:
        await history.move_sites()
    finally:
        await history.close()


@contextlib.asynccontextmanager
async def _without_hubs(
    settings: Settings, database: Database, wait_s: float
) -> AsyncIterator[bool]:
    """Keep hubs from starting meanwhile; gives False where one runs."""
    async with contextlib.AsyncExitStack() as held:
        alone = True
        try:
            held.enter_context(hub_lock(settings.data))
            if parse_database_url(settings.url).dialect.is_server:
                shards = await read_shards(database)
                only = hold_only_hub(settings.url, lambda: None, shards=shards, wait_s=wait_s)
                await held.enter_async_context(only)
        # Of this folder, or on another machine.
        except (HubRuns, CannotStart):
            alone = False
        yield alone


def _line_of(home: HistoryHome) -> str:
    said = f"{home.site}: {home.server}"
    if home.moving_to:
        said += f", on its way to {home.moving_to}"
        if home.all_blocks:
            said += f": {home.done_blocks} of {home.all_blocks} blocks"
    elif home.led_by:
        said += ", its shard changes"
    elif home.erase_at:
        said += f", what was left at {home.erase_at} is being erased"
    return f"{said}; it waits: {home.problem}" if home.problem else said
