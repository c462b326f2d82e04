"""Gateway keys, and the sites that have ever said hello."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from sqlalchemy import func, insert, select, update

from talaia.hub.auth.tokens import hash_token, new_token
from talaia.hub.store.history_servers.own_rows import every_row
from talaia.hub.store.sites.gateway_presence import GatewayPresence
from talaia.hub.store.sites.shared_lookup import SharedLookup
from talaia.hub.store.tables import gateways, sites

if TYPE_CHECKING:
    from collections.abc import Collection

    from sqlalchemy import ColumnElement
    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.clock import Clock
    from talaia.hub.store.database import Database
    from talaia.hub.store.history_servers.own_rows import OwnRows
    from talaia.wire.gateway_proof import ResumeToken

# Keys in one query; more would be more parameters than some engines take.
_AT_ONCE = 500
__all__ = ["GatewayKey", "KnownGateway", "KnownSite", "SiteRegistry", "add_key"]


class KnownSite(NamedTuple):
    """What is kept of a site between two starts of the hub."""

    site: str
    description: str
    catalogue: str
    last_seen_us: int


class GatewayKey(NamedTuple):
    """Whose key it is, and for which site it speaks.

    Attributes:
        challenged: the key was proved by our challenge; a gateway of before says it.
        resumed: which place the gateway has shown that it had; None: it has shown none.

    """

    id: int
    site: str
    challenged: bool = False
    resumed: ResumeToken | None = None

    @property
    def lineage(self) -> int:
        """Of the place that it has shown; 0: it has shown none."""
        return 0 if self.resumed is None else self.resumed.lineage


class KnownGateway(NamedTuple):
    """What is known of a gateway.

    Attributes:
        revoked_us: 0 while its key is good.
        seen_us: end of its last link as far as it was kept; 0 before its first.
        address: of its last link.

    """

    id: int
    site: str
    name: str
    created_us: int
    revoked_us: int
    seen_us: int
    address: str
    version: str


class SiteRegistry:
    """Which gateway may speak for which site, and what each site said it is.

    Attributes:
        attendance: when each was there; what it remembers is part of every answer here.

    """

    def __init__(self, database: Database, clock: Clock) -> None:
        """Work on ``database``; ``clock`` stamps what is added."""
        self._database = database
        self._clock = clock
        self.attendance = GatewayPresence(database, clock)
        # After a hub was away hundreds show their keys within a second.
        self._by_hash = SharedLookup(self._keys_by_hash)
        self._by_site = SharedLookup(self._keys_by_site)

    async def new_key(self, site: str, name: str = "") -> str:
        """Make a key for a site's gateway; the keys it had before are revoked."""
        async with self._database.write() as connection:
            _, key, _ = await add_key(connection, site, name, self._now_us())
        return key

    async def gateway_of(self, key: str) -> GatewayKey | None:
        """Tell whose key this is; None when it is unknown or revoked."""
        return await self._by_hash.look_up(hash_token(key))

    async def keys_of_site(self, site: str) -> list[tuple[int, str]]:
        """Give number and hash of the good keys of a site: one, or none."""
        return await self._by_site.look_up(site) or []

    async def _keys_by_hash(self, hashes: Collection[str]) -> dict[str, GatewayKey]:
        rows = await self._good_rows(gateways.c.key_hash, hashes)
        return {row.key_hash: GatewayKey(row.id, row.site) for row in rows}

    async def _keys_by_site(self, names: Collection[str]) -> dict[str, list[tuple[int, str]]]:
        found: dict[str, list[tuple[int, str]]] = {}
        for row in await self._good_rows(gateways.c.site, names):
            found.setdefault(row.site, []).append((row.id, row.key_hash))
        return found

    async def _good_rows(self, column: ColumnElement[str], values: Collection[str]) -> list[Any]:
        asked, columns = list(values), (gateways.c.id, gateways.c.site, gateways.c.key_hash)
        query = select(*columns).where(gateways.c.revoked_us == 0)
        found: list[Any] = []
        async with self._database.read() as connection:
            for first in range(0, len(asked), _AT_ONCE):
                some = query.where(column.in_(asked[first : first + _AT_ONCE]))
                found += (await connection.execute(some)).all()
        return found

    async def key_hash(self, number: int) -> str | None:
        """Give what is kept of a gateway's key: its hash; None when it is unknown or revoked."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(gateways.c.key_hash).where(
                    gateways.c.id == number, gateways.c.revoked_us == 0
                )
            )
            return rows.scalar()

    async def list_gateways(self, own: OwnRows = every_row) -> list[KnownGateway]:
        """List every gateway of ``own`` sites that ever had a key, the newest of each first."""
        columns = (gateways.c[name] for name in KnownGateway._fields)
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(*columns)
                .where(*own(gateways.c.site))
                .order_by(gateways.c.site, gateways.c.id.desc())
            )
            return [self._with_presence(KnownGateway(*row)) for row in rows]

    async def find_gateway(self, number: int) -> KnownGateway | None:
        """Find one gateway."""
        columns = (gateways.c[name] for name in KnownGateway._fields)
        async with self._database.read() as connection:
            rows = await connection.execute(select(*columns).where(gateways.c.id == number))
            row = rows.first()
        return None if row is None else self._with_presence(KnownGateway(*row))

    async def revoke_key(self, number: int) -> bool:
        """Make a gateway's key void; False when it was void already, or there is none."""
        async with self._database.write() as connection:
            done = await connection.execute(
                update(gateways)
                .where(gateways.c.id == number, gateways.c.revoked_us == 0)
                .values(revoked_us=self._now_us())
            )
        return done.rowcount == 1

    async def good_keys(self, numbers: Collection[int]) -> set[int]:
        """Give those of the gateways whose key is still good."""
        query = select(gateways.c.id).where(gateways.c.id.in_(numbers), gateways.c.revoked_us == 0)
        return set(await self._database.fetch_scalars(query))

    async def count_void_keys(self) -> int:
        """Count void keys: one more whenever one becomes so, for no row is ever deleted."""
        query = select(func.count()).select_from(gateways).where(gateways.c.revoked_us != 0)
        return (await self._database.fetch_scalars(query))[0]

    def _with_presence(self, row: KnownGateway) -> KnownGateway:
        return row._replace(**self.attendance.pending_columns(row.id))

    async def list_sites(self) -> list[KnownSite]:
        """List every site that has ever said hello."""
        async with self._database.read() as connection:
            rows = await connection.execute(
                select(
                    sites.c.site, sites.c.description, sites.c.catalogue, sites.c.last_seen_us
                ).order_by(sites.c.site)
            )
            return [KnownSite(*row) for row in rows]

    async def said_hello(
        self, site: str, description: str, catalogue: str, version: str | None = None
    ) -> None:
        """Keep what a site said of itself; without a ``version`` its gateway's is as it was."""
        now = self._now_us()
        said = {
            "description": description,
            "catalogue": catalogue,
            "last_seen_us": now,
        }
        async with self._database.write() as connection:
            known = await connection.execute(select(sites.c.site).where(sites.c.site == site))
            if known.first() is None:
                await connection.execute(
                    insert(sites).values(site=site, first_seen_us=now, version="", **said)
                )
            else:
                await connection.execute(update(sites).where(sites.c.site == site).values(**said))
            if version is not None:
                known_as = update(sites).where(sites.c.site == site)
                await connection.execute(known_as.values(version=version[:200]))

    def _now_us(self) -> int:
        return self._clock.wall_ns() // 1000


async def add_key(
    connection: AsyncConnection, site: str, name: str, now_us: int
) -> tuple[int, str, list[int]]:
    """Make a key for a site's gateway, as a part of a transaction that writes.

    Returns:
        The gateway's number, the key, and the numbers of those whose keys are void from now on.

    """
    good = (gateways.c.site == site, gateways.c.revoked_us == 0)
    before = list((await connection.execute(select(gateways.c.id).where(*good))).scalars())
    await connection.execute(update(gateways).where(*good).values(revoked_us=now_us))
    key = new_token()
    made = await connection.execute(
        insert(gateways).values(
            site=site,
            name=name[:200],
            key_hash=hash_token(key),
            created_us=now_us,
            revoked_us=0,
            version="",
            address="",
            seen_us=0,
        )
    )
    number = made.inserted_primary_key
    return int(number[0]) if number else 0, key, before
