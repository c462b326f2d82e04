"""What sites of other shards are, for what one hub does for all of them: boards, displays, units.

They are read from the database that all shards share, and are not among the hub's own sites: it
neither shows how they stand, nor judges or drives anything there.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from sqlalchemy import func, select

from talaia.hub.live.followed_store import follow_store
from talaia.hub.store.tables import descriptions, sites
from talaia.model.errors import DescriptionError
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from sqlalchemy.ext.asyncio import AsyncConnection

    from talaia.hub.errors import StoreDown
    from talaia.hub.live.sites import Sites
    from talaia.hub.ports import DescribedSite, Shard
    from talaia.hub.store.database import Database
    from talaia.model.site import Site

__all__ = ["SiteMirror"]

_LOG = logging.getLogger(__name__)
# Between two looks for what other hubs have written (s).
_LOOK_S = 1.0
# Sites in one query; more would be more parameters than some engines take.
_AT_ONCE = 500


class _OtherSite(NamedTuple):
    """A site of another shard."""

    name: str
    description: Site


class SiteMirror:
    """All sites: the own ones as they are now, the others as they were described a second ago."""

    def __init__(self, own: Sites, shard: Shard, database: Database) -> None:
        """Add to ``own`` what ``database`` has of sites that are not of ``shard``."""
        self._own = own
        self._shard = shard
        self._database = database
        self._others: dict[str, _OtherSite] = {}
        # By site: the version that was read.
        self._read: dict[str, int] = {}
        # How many sites there were, and the last version: nothing is new while these stay.
        self._mark: tuple[int, int] | None = None

    def __iter__(self) -> Iterator[DescribedSite]:
        """Go through them in the order of their names."""
        every: dict[str, DescribedSite] = {**self._others}
        every.update((live.name, live) for live in self._own)
        return iter([every[name] for name in sorted(every)])

    def find_site(self, name: str) -> DescribedSite | None:
        """Find one by its short name."""
        return self._own.find_site(name) or self._others.get(name)

    async def run(self) -> None:
        """Follow what other hubs write, until cancelled."""

        def say_failed(error: StoreDown) -> None:
            _LOG.warning("sites of other shards are known as they were: %s", error)

        await follow_store(self.refresh, every_s=_LOOK_S, failed=say_failed)

    async def refresh(self) -> None:
        """Read what is new.

        Raises:
            StoreDown: the database does not answer.

        """
        async with self._database.read() as connection:
            mark = await _read_mark(connection)
        if mark == self._mark:
            return
        # Whose a site is stands there before it is described.
        await self._shard.refresh()
        async with self._database.read() as connection:
            numbers = await _read_numbers(connection)
            changed = [
                site
                for site, number in numbers.items()
                if self._read.get(site) != number and not self._shard.has_site(site)
            ]
            texts = await _read_texts(connection, changed)
        # A thousand of them take a second.
        self._others |= await asyncio.to_thread(_read_sites, texts)
        self._read.update((site, numbers[site]) for site in changed)
        self._mark = mark


async def _read_mark(connection: AsyncConnection) -> tuple[int, int]:
    # Neither sites nor versions are ever deleted, and one turn to write has them in order.
    count = select(func.count()).select_from(sites).scalar_subquery()
    last = select(func.max(descriptions.c.id)).scalar_subquery()
    row = (await connection.execute(select(count, last))).one()
    return int(row[0]), int(row[1] or 0)


async def _read_numbers(connection: AsyncConnection) -> dict[str, int]:
    """Give the newest version of each site; 0 where only recordings of it were imported."""
    newest = func.coalesce(func.max(descriptions.c.number), 0)
    query = (
        select(sites.c.site, newest)
        .outerjoin(descriptions, descriptions.c.site == sites.c.site)
        .group_by(sites.c.site)
    )
    return {site: int(number) for site, number in (await connection.execute(query)).all()}


async def _read_texts(connection: AsyncConnection, names: Collection[str]) -> dict[str, str]:
    asked, found = list(names), dict[str, str]()
    query = select(sites.c.site, sites.c.description)
    for first in range(0, len(asked), _AT_ONCE):
        some = query.where(sites.c.site.in_(asked[first : first + _AT_ONCE]))
        found |= {row.site: row.description for row in await connection.execute(some)}
    return found


def _read_sites(texts: Mapping[str, str]) -> dict[str, _OtherSite]:
    found = {}
    for name, text in texts.items():
        try:
            found[name] = _OtherSite(name, load_site(text))
        except DescriptionError as error:
            # One that this version cannot read must not keep the others away.
            _LOG.warning("the kept description of %s is set aside: %s", name, error)
    return found
