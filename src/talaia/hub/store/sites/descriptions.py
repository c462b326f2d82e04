"""Every version of every site's description, in the order in which they counted."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import func, insert, select

from talaia.hub.store.tables import descriptions
from talaia.wire.sealing import digest_of

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["Descriptions", "Version"]

_table = descriptions
_LONGEST = 200


class Version(NamedTuple):
    """A description that counted from a moment on.

    Attributes:
        number: counts from 1 in each site.
        digest: SHA-256 of the text, hex.
        time_us: when the hub heard of it.
        gateway: the number of the gateway that goes by it.
        who: sent it through the hub; empty when it was changed at the gateway.
        note: in a few words, how it came about.

    """

    number: int
    digest: str
    time_us: int
    gateway: int
    who: str
    note: str


class Descriptions:
    """Rows of descriptions; none is ever changed or deleted."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is added."""
        self._database = database
        self._clock = clock

    async def add_version(
        self, site: str, text: str, *, gateway: int, who: str = "", note: str = ""
    ) -> int:
        """Write down what counts from now on, unless it is what counted before; give its number."""
        digest = digest_of(text)
        async with self._database.write() as connection:
            last = (
                await connection.execute(
                    select(_table.c.number, _table.c.digest)
                    .where(_table.c.site == site)
                    .order_by(_table.c.number.desc())
                    .limit(1)
                )
            ).first()
            if last is not None and last.digest == digest:
                return int(last.number)
            number = 1 if last is None else int(last.number) + 1
            await connection.execute(
                insert(_table).values(
                    site=site,
                    number=number,
                    digest=digest,
                    text=text,
                    time_us=self._clock.wall_ns() // 1000,
                    gateway=gateway,
                    who=who[:_LONGEST],
                    note=note[:_LONGEST],
                )
            )
        return number

    async def newest_digests(self) -> dict[str, str]:
        """Give the digest of each site's newest version."""
        newest = (
            select(_table.c.site, func.max(_table.c.number).label("number"))
            .group_by(_table.c.site)
            .subquery()
        )
        query = select(_table.c.site, _table.c.digest).join(
            newest, (newest.c.site == _table.c.site) & (newest.c.number == _table.c.number)
        )
        async with self._database.read() as connection:
            return {row.site: row.digest for row in await connection.execute(query)}

    async def versions_of(self, site: str, below: int = 2**62, most: int = 100) -> list[Version]:
        """List a site's versions below a number, the newest first."""
        columns = (_table.c[name] for name in Version._fields)
        query = (
            select(*columns)
            .where(_table.c.site == site, _table.c.number < below)
            .order_by(_table.c.number.desc())
            .limit(most)
        )
        async with self._database.read() as connection:
            return [Version(*row) for row in await connection.execute(query)]

    async def version_text(self, site: str, number: int) -> str | None:
        """Give the text of a version; None when there is no such version."""
        query = select(_table.c.text).where(_table.c.site == site, _table.c.number == number)
        async with self._database.read() as connection:
            found = (await connection.execute(query)).scalar()
        return None if found is None else str(found)

    async def count_versions(self, site: str) -> int:
        """Tell how many versions there are."""
        query = select(func.count()).where(_table.c.site == site)
        async with self._database.read() as connection:
            return int((await connection.execute(query)).scalar() or 0)
