"""The number of the newest set of requests of each site; see `RequestSync`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sqlalchemy import insert, select, update

from talaia.hub.store.observing_tables import observing_revisions

if TYPE_CHECKING:
    from sqlalchemy.ext.asyncio import AsyncConnection

__all__ = ["raise_revision", "read_revision"]


async def read_revision(connection: AsyncConnection, site: str) -> int:
    """Give the revision of a site's requests; 0: nothing was ever asked."""
    found = await connection.execute(
        select(observing_revisions.c.revision).where(observing_revisions.c.site == site)
    )
    return int(found.scalar() or 0)


async def raise_revision(connection: AsyncConnection, site: str, beyond: int = 0) -> int:
    """Raise it by one, and above ``beyond``; in the transaction that writes the change itself."""
    before = await read_revision(connection, site)
    revision = max(before, beyond) + 1
    if before:
        await connection.execute(
            update(observing_revisions)
            .where(observing_revisions.c.site == site)
            .values(revision=revision)
        )
    else:
        await connection.execute(insert(observing_revisions).values(site=site, revision=revision))
    return revision
