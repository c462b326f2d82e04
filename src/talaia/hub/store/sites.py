"""Gateway keys, and the sites that have ever said hello."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import insert, select, update

from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.store.tables import gateways, sites

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.store.database import Database

__all__ = ["KnownSite", "SiteRegistry"]


class KnownSite(NamedTuple):
    """What is kept of a site between two starts of the hub."""

    site: str
    description: str
    catalogue: str
    last_seen_us: int


class SiteRegistry:
    """Which gateway may speak for which site, and what each site said it is."""

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is added."""
        self._database = database
        self._clock = clock

    async def new_key(self, site: str) -> str:
        """Make a key for a site's gateway; the keys it had before are revoked."""
        key = new_token()
        now = self._now_us()
        async with self._database.write() as connection:
            await connection.execute(
                update(gateways)
                .where(gateways.c.site == site, gateways.c.revoked_us == 0)
                .values(revoked_us=now)
            )
            await connection.execute(
                insert(gateways).values(
                    site=site, key_hash=hash_token(key), created_us=now, revoked_us=0
                )
            )
        return key

    async def site_of(self, key: str) -> str | None:
        """Tell which site a gateway's key speaks for; None when it is unknown or revoked."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(gateways.c.site).where(
                    gateways.c.key_hash == hash_token(key), gateways.c.revoked_us == 0
                )
            )
            return rows.scalar()

    async def all(self) -> list[KnownSite]:
        """List every site that has ever said hello."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(
                    sites.c.site, sites.c.description, sites.c.catalogue, sites.c.last_seen_us
                ).order_by(sites.c.site)
            )
            return [KnownSite(*row) for row in rows]

    async def said_hello(self, site: str, description: str, catalogue: str, version: str) -> None:
        """Keep what a site said of itself."""
        now = self._now_us()
        said = {
            "description": description,
            "catalogue": catalogue,
            "version": version[:200],
            "last_seen_us": now,
        }
        async with self._database.write() as connection:
            known = await connection.execute(select(sites.c.site).where(sites.c.site == site))
            if known.first() is None:
                await connection.execute(insert(sites).values(site=site, first_seen_us=now, **said))
            else:
                await connection.execute(update(sites).where(sites.c.site == site).values(**said))

    async def seen(self, site: str) -> None:
        """Keep that a site was there until now."""
        async with self._database.write() as connection:
            await connection.execute(
                update(sites).where(sites.c.site == site).values(last_seen_us=self._now_us())
            )

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000
