"""Which sightings a person has looked at; each person's marks are their own."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import and_, delete, insert, select

from talaia.hub.store.tables import seen_sightings, sightings

if TYPE_CHECKING:
    from collections.abc import Collection

    from talaia.hub.store.database import Database

__all__ = ["ReviewRow", "SightingReviews"]

# Of one site, so many of the newest are counted: more than are kept unless a hub is told to.
_MOST_COUNTED = 50_000


class ReviewRow(NamedTuple):
    """When something was seen by which camera, and whether the person has looked at it."""

    camera: str
    began_us: int
    seen: bool


class SightingReviews:
    """Marks of people at sightings; a mark goes with its sighting, and with its person."""

    def __init__(self, database: Database) -> None:
        """Work on ``database``."""
        self._database = database

    async def mark_seen(self, user: int, numbers: Collection[int], *, seen: bool) -> None:
        """Mark sightings as looked at, or as not.

        Args:
            user: whose marks they are.
            numbers: of sightings that are there.
            seen: whether they have been looked at.

        Raises:
            StoreDown: nothing was marked.

        """
        column = seen_sightings.c
        mine = and_(column.user_id == user, column.sighting_id.in_(sorted(numbers)))
        async with self._database.write() as connection:
            # The same mark twice is one, in every kind of database.
            await connection.execute(delete(seen_sightings).where(mine))
            if seen and numbers:
                rows = [{"user_id": user, "sighting_id": number} for number in sorted(numbers)]
                await connection.execute(insert(seen_sightings), rows)

    async def find_seen(self, user: int, numbers: Collection[int]) -> frozenset[int]:
        """Find those of some sightings that the person has looked at."""
        if not numbers:
            return frozenset()
        column = seen_sightings.c
        asked = select(column.sighting_id).where(
            column.user_id == user, column.sighting_id.in_(sorted(numbers))
        )
        async with self._database.read() as connection:
            return frozenset((await connection.execute(asked)).scalars())

    async def find_cameras(self, site: str, numbers: Collection[int]) -> dict[int, str]:
        """Give the cameras of those sightings that a site has, by their numbers."""
        column = sightings.c
        asked = select(column.id, column.camera).where(
            column.site == site, column.id.in_(sorted(numbers))
        )
        async with self._database.read() as connection:
            return {row.id: row.camera for row in await connection.execute(asked)}

    async def list_rows(
        self, site: str, user: int, cameras: Collection[str], label: str = ""
    ) -> list[ReviewRow]:
        """List when each camera saw something, the newest first, to be counted by day."""
        column, mark = sightings.c, seen_sightings.c
        said = [column.site == site, column.camera.in_(sorted(cameras))]
        if label:
            said.append(column.label == label)
        joined = sightings.outerjoin(
            seen_sightings, and_(mark.sighting_id == column.id, mark.user_id == user)
        )
        asked = (
            select(column.camera, column.began_us, mark.user_id)
            .select_from(joined)
            .where(*said)
            .order_by(column.began_us.desc())
            .limit(_MOST_COUNTED)
        )
        async with self._database.read() as connection:
            rows = await connection.execute(asked)
            return [ReviewRow(row.camera, row.began_us, row.user_id is not None) for row in rows]
