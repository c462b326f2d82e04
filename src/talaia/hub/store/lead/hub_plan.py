"""How sites are divided, written down: hubs that have it otherwise lead nothing meanwhile.

Two hubs whose files divide the sites in different ways would both have some of them. So one way is
written beside the accounts. A shard's lock is taken by hubs alone that have it so; the hub that has
the main shard's may write another, while nobody has any lock of what was written before. The words
also say the tables' version, for tables are changed only while no shard has a lead.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Any

from sqlalchemy import delete, insert, select, text, update
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from talaia.hub.errors import CannotStart, StoreDown
from talaia.hub.store.database import last_migration
from talaia.hub.store.dialects.choice import dialect_of
from talaia.hub.store.dialects.lead_words import MAIN_SHARD
from talaia.hub.store.history_servers.home_tables import OWN, history_homes
from talaia.hub.store.history_tables import boot, channel
from talaia.hub.store.lead.lead_table import hub_lead, hub_plan

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Collection

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.store.database import Database
    from talaia.hub.store.dialects.lead_words import LeadWords

__all__ = ["PlanCheck", "agree_on_plan", "read_shards"]

_LOG = logging.getLogger(__name__)
_ROW = 1
_READ = "SELECT agreed FROM hub_plan"
# A lead that has asked nothing for so long stands still (s).
_SILENT_S = 3.0
# Locks of what was written before may be in use for a moment (s).
_WAIT_S = 5.0
_LOOK_S = 0.05
_REMEDY = "end all hubs, then start all with the same file of --history-servers"


def _agreed_words(shards: Collection[str]) -> str:
    """Write down a division; of sites that are not divided, nothing."""
    return " ".join([last_migration(), *sorted(shards)]) if shards else ""


def _shards_in(agreed: str) -> list[str]:
    return agreed.split()[1:]


def _name_agreed(agreed: str) -> str:
    shards = _shards_in(agreed)
    if not shards:
        return "no shards"
    return f"the shards {', '.join(shards)} and tables of version {agreed.split()[0]}"


class PlanCheck:
    """Tells, in the thread of a hub's lock, whether it may have the lock of a shard."""

    def __init__(self, words: LeadWords, *, shard: str, shards: Collection[str]) -> None:
        """Be for ``shard``, where sites are divided into ``shards``; none: they are not."""
        self._words, self._shard = words, shard
        self._wanted = _agreed_words(shards)
        self.is_divided = bool(shards)
        self._said = ""

    def fits(self, ask: Callable[..., Any]) -> bool:
        """Tell whether it may; ``ask`` gives a statement's first value, of a session or not.

        Raises:
            SQLAlchemyError: the database does not answer.

        """
        found = _read_agreed(ask)
        if found == self._wanted:
            return True
        if self._shard != MAIN_SHARD:
            # The lead of the main shard writes it when it begins; until then it is not told.
            why = "" if not found else f"the hubs that lead have {_name_agreed(found)}"
        else:
            led = [shard for shard in _shards_in(found or "") if self._is_led(shard, ask)]
            if not led:
                return True
            why = f"hubs with {_name_agreed(found or '')} lead {', '.join(led)}"
        if why and why != self._said:
            self._said = why
            here = _name_agreed(self._wanted)
            _LOG.warning("this hub, with %s, does not lead %s: %s", here, self._shard, why)
        return False

    def _is_led(self, shard: str, ask: Callable[..., Any]) -> bool:
        holder = ask(self._words.divide(shard).holder)
        if holder is None:
            return False
        silent = ask(self._words.silent, int(holder))
        if silent is not None and float(silent) > _SILENT_S:
            _LOG.warning("the hub that leads %s has been silent for %.1f s", shard, silent)
            ask(self._words.end, int(holder))
        return True


def _read_agreed(ask: Callable[..., Any]) -> str | None:
    try:
        return str(ask(_READ) or "")
    except DBAPIError as error:
        if error.connection_invalidated:
            raise
        # The tables are not there yet, or of before.
        return None


async def read_shards(database: Database) -> list[str]:
    """Give the shards besides the main one, as the hubs that lead have agreed; none: no shards.

    Raises:
        StoreDown: the database does not answer.

    """
    async with database.read() as connection:
        found = await connection.scalar(select(hub_plan.c.agreed))
    return _shards_in(found or "")


async def agree_on_plan(
    database: Database,
    shards: Collection[str],
    *,
    shard: str = MAIN_SHARD,
    wait_s: float = _WAIT_S,
) -> None:
    """See that this hub, which has a shard's lock, divides the sites as all that lead do.

    Called with the tables up to date, before anything else is read. The main shard's lead writes
    down how they are divided from now on; whoever led a shard until now leads none any more.

    Args:
        database: of the accounts.
        shards: besides the main one; none: the sites are not divided.
        shard: whose lock this hub has.
        wait_s: so long a shard of before is waited for that has a lead yet.

    Raises:
        CannotStart: hubs that divide them in another way lead yet.
        StoreDown: the database does not answer.

    """
    async with database.read() as connection:
        found = await connection.scalar(select(hub_plan.c.agreed)) or ""
    wanted = _agreed_words(shards)
    if found == wanted:
        return
    if shard != MAIN_SHARD:
        theirs, mine = _name_agreed(found), _name_agreed(wanted)
        raise CannotStart(f"the hubs that lead have {theirs}, and this one has {mine}", _REMEDY)
    held = _locks_held(database, _shards_in(found), wait_s)
    async with held, database.write() as connection:
        await connection.execute(delete(hub_plan))
        await connection.execute(insert(hub_plan).values(id=_ROW, agreed=wanted))
        # One that lost its lock for a moment sees by it that it leads no more.
        await connection.execute(
            update(hub_lead)
            .where(hub_lead.c.shard != MAIN_SHARD)
            .values(epoch=hub_lead.c.epoch + 1)
        )
        if shards:
            await _settle_sites(connection)
    _LOG.info("the hubs have %s from now on", _name_agreed(wanted))


async def _settle_sites(connection: AsyncConnection) -> None:
    """Write down of each site whose history is here that it is: one without a row is new."""
    settled = set(await connection.scalars(select(history_homes.c.site)))
    here = {
        *await connection.scalars(select(channel.c.site).distinct()),
        *await connection.scalars(select(boot.c.site).distinct()),
    }
    rest = {"moving_to": "", "move": "", "erase_at": "", "problem": ""}
    rows = [
        {"site": site, "server": OWN, "done_blocks": 0, "all_blocks": 0, **rest}
        for site in sorted(here - settled)
    ]
    if rows:
        await connection.execute(insert(history_homes), rows)


@contextlib.asynccontextmanager
async def _locks_held(
    database: Database, shards: Collection[str], wait_s: float
) -> AsyncIterator[None]:
    """Have the locks of shards meanwhile, with nothing of their former leads open.

    Raises:
        CannotStart: another hub has one, and keeps it.

    """
    async with database.read() as connection:
        lead = dialect_of(connection.engine.sync_engine).lead
        held: list[LeadWords] = []
        try:
            for shard in shards:
                # A file has no locks: one that was copied from a server's database.
                if lead is None:
                    break
                words = lead.divide(shard)
                if not await _take_lock(connection, words, wait_s):
                    raise CannotStart(f"a hub with other shards leads {shard!r} yet", _REMEDY)
                held.append(words)
                await _end_others(connection, words)
            yield
        finally:
            for words in held:
                # A connection that is gone has none.
                with contextlib.suppress(SQLAlchemyError):
                    await connection.execute(text(words.give_back))


async def _take_lock(connection: AsyncConnection, words: LeadWords, wait_s: float) -> bool:
    until_s = asyncio.get_running_loop().time() + wait_s
    while not await connection.scalar(text(words.take)):
        if asyncio.get_running_loop().time() > until_s:
            return False
        await asyncio.sleep(_LOOK_S)
    return True


async def _end_others(connection: AsyncConnection, words: LeadWords) -> None:
    until_s = asyncio.get_running_loop().time() + _WAIT_S
    while True:
        # PostgreSQL shows sessions as they were when a transaction first looked.
        await connection.rollback()
        others = (await connection.scalars(text(words.others))).all()
        if not others:
            return
        if asyncio.get_running_loop().time() > until_s:
            raise StoreDown("sessions of a former lead do not end", "try again soon")
        for session in others:
            # It may have gone by itself meanwhile.
            with contextlib.suppress(SQLAlchemyError):
                await connection.execute(text(words.end), {"session": session})
        await asyncio.sleep(_LOOK_S)
