"""What a hub writes down that has the lock: that it leads from now on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select, update

from talaia.hub.errors import CannotStart
from talaia.hub.store.dialects.lead_words import MAIN_SHARD
from talaia.hub.store.lead.lead_table import hub_lead

if TYPE_CHECKING:
    from talaia.hub.store.database import Database

__all__ = ["claim_lead"]


async def claim_lead(
    database: Database, *, name: str, seal_hash: str, shard: str = MAIN_SHARD
) -> int:
    """Write down that the hub ``name`` leads a shard; give the number of this lead of it.

    It is higher than any before.

    Raises:
        CannotStart: it has another key for secrets than the hubs before it.
        StoreDown: the database does not answer.

    """
    async with database.write() as connection:
        rows = (await connection.execute(select(hub_lead))).all()
        if any(row.seal_hash != seal_hash for row in rows):
            raise CannotStart(
                "this hub has another seal.key than the others on this database",
                "copy seal.key from the data folder of one of them, or give all the same folder",
            )
        found = next((row for row in rows if row.shard == shard), None)
        if found is None:
            row = {
                "id": max((row.id for row in rows), default=0) + 1,
                "epoch": 1,
                "seal_hash": seal_hash,
                "name": name,
                "shard": shard,
            }
            await connection.execute(insert(hub_lead).values(row))
            return 1
        epoch = int(found.epoch) + 1
        await connection.execute(
            update(hub_lead).where(hub_lead.c.id == found.id).values(epoch=epoch, name=name)
        )
        return epoch
