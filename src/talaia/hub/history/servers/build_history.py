"""The history of the settings: one database, or several."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.errors import CannotStart
from talaia.hub.history.servers.history_servers import HistoryServers
from talaia.hub.history.servers.server_file import read_history_servers
from talaia.hub.history.servers.shard_passage import ShardPassage
from talaia.hub.history.store import HistoryStore
from talaia.hub.sharding.plan import MAIN, ShardPlan
from talaia.hub.store.history_servers.history_homes import HistoryHomes
from talaia.hub.store.history_servers.home_tables import OWN
from talaia.hub.store.history_servers.shard_handover import ShardHandover

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

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
    shard: str | None = None,
    plan: ShardPlan | None = None,
    begin_anew: Callable[[], None] | None = None,
) -> HistoryStore | HistoryServers:
    """Make it; nothing is opened yet.

    Args:
        settings: say where it is.
        database: has the accounts.
        clock: the time.
        limits: of each server.
        on_connect: looks at each new connection to the hub's own database; none: nobody need.
        shard: of the hub that has it; none: it is of a command, which has all shards.
        plan: which shards there are for that hub; none: its sites are not divided.
        begin_anew: lets that hub close and open again: sites have gone to another shard, or come.

    Raises:
        CannotStart: the file that names servers cannot be used.
        HistoryError: a URL cannot be read, or its driver is not installed.

    """
    file, divided = settings.history_servers, plan is not None and bool(plan.names)
    # A shard's lead has nothing to do with histories in the accounts' database.
    own = None
    if shard in (None, MAIN) or not divided:
        own = HistoryStore(settings.url, clock, limits, on_connect=on_connect)
        if file is None:
            return own
    if file is None:
        raise CannotStart(f"the shard {shard!r} needs --history-servers", "name the file")
    named = read_history_servers(file)
    if shard is not None:
        _check_plan(file, named.plan, plan or ShardPlan())
    passage = None
    if divided and begin_anew is not None:
        passage = ShardPassage(ShardHandover(database), settings.url, begin_anew)
    return HistoryServers(
        own,
        named,
        HistoryHomes(database),
        clock=clock,
        limits=limits,
        shard=shard if divided else None,
        passage=passage,
    )


def _check_plan(file: Path, said: ShardPlan, plan: ShardPlan) -> None:
    if said.names and not plan.names:
        raise CannotStart(
            f"--history-servers {file}: shards: are of several hubs",
            "start it with --cluster nats://…, or take shards: out",
        )
    if said != plan:
        raise CannotStart(
            f"--history-servers {file}: shards: have changed within the start", "start anew"
        )


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
