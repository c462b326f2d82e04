"""What a hub writes down that has the lock: that it leads from now on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select, update

from talaia.hub.errors import CannotStart
from talaia.hub.store.lead.lead_table import hub_lead

if TYPE_CHECKING:
    from talaia.hub.store.database import Database

__all__ = ["claim_lead"]

_ROW = 1


async def claim_lead(database: Database, *, name: str, seal_hash: str) -> int:
    """Write down that the hub ``name`` leads; give the number of this lead, higher than any before.

    Raises:
        CannotStart: it has another key for secrets than the hubs before it.
        StoreDown: the database does not answer.

    """
    async with database.write() as connection:
        found = (
            await connection.execute(select(hub_lead.c.epoch, hub_lead.c.seal_hash))
        ).one_or_none()
        if found is None:
            row = {"id": _ROW, "epoch": 1, "seal_hash": seal_hash, "name": name}
            await connection.execute(insert(hub_lead).values(row))
            return 1
        if found.seal_hash != seal_hash:
            raise CannotStart(
                "this hub has another seal.key than the others on this database",
                "copy seal.key from the data folder of one of them, or give all the same folder",
            )
        epoch = int(found.epoch) + 1
        await connection.execute(
            update(hub_lead).where(hub_lead.c.id == _ROW).values(epoch=epoch, name=name)
        )
        return epoch
