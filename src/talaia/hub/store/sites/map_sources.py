"""Tile servers that admins allowed, and the hosts that pages may therefore ask for pictures."""

from __future__ import annotations

import re
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from sqlalchemy import delete, func, insert, select

from talaia.hub.store.map_tables import map_sources

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.hub.auth.secret_box import Seal
    from talaia.hub.store.database import Database

__all__ = ["GOOGLE_HOST", "MOST_SOURCES", "MapSource", "MapSources", "SourceKind", "tile_origin"]

MOST_SOURCES = 20
GOOGLE_HOST = "https://tile.googleapis.com"
# A name or address and a port: it becomes a part of the Content-Security-Policy.
_HOST = re.compile(r"[A-Za-z0-9.-]{1,253}(:[0-9]{1,5})?", re.ASCII)
_LOCAL = frozenset({"localhost", "127.0.0.1"})
_PLACES = ("{z}", "{x}", "{y}")


class SourceKind(StrEnum):
    """``tiles``: pictures by column and row; ``google``: the same, by a session of a key."""

    TILES = "tiles"
    GOOGLE = "google"


class MapSource(NamedTuple):
    """A tile server."""

    id: int
    name: str
    kind: SourceKind
    address: str
    attribution: str
    most_zoom: int

    @property
    def origin(self) -> str:
        """Scheme and host that browsers ask."""
        return GOOGLE_HOST if self.kind is SourceKind.GOOGLE else tile_origin(self.address)


def tile_origin(address: str) -> str:
    """Give scheme and host of a tile server's address.

    Raises:
        ValueError: it is none that a page may be given, and why.

    """
    try:
        parts = urlsplit(address)
        name, user = parts.hostname, parts.username
    except ValueError as error:
        raise ValueError("this is no address") from error
    if any(place not in parts.path + parts.query for place in _PLACES):
        raise ValueError("it needs {z}, {x} and {y} where zoom, column and row stand")
    if user is not None or _HOST.fullmatch(parts.netloc) is None:
        raise ValueError("it needs a plain host, as in https://tiles.example.org/{z}/{x}/{y}.png")
    if parts.scheme != "https" and not (parts.scheme == "http" and name in _LOCAL):
        raise ValueError("it must begin with https://, for pages take no pictures in the clear")
    return f"{parts.scheme}://{parts.netloc.lower()}"


class MapSources:
    """Keeps them. Its `origins` are at hand without asking the database.

    Attributes:
        origins: of all sources, each once; read by each answer's Content-Security-Policy.

    """

    def __init__(self, database: Database, clock: Clock, seal: Callable[[], Seal]) -> None:
        """Work on ``database``; keys are sealed by ``seal``."""
        self._database = database
        self._clock = clock
        self._seal = seal
        self.origins: tuple[str, ...] = ()

    async def list_sources(self) -> list[MapSource]:
        """List them, the first one first; what pages may ask follows from it."""
        asked = select(map_sources).order_by(map_sources.c.id)
        async with self._database.read() as connection:
            found = [
                MapSource(
                    row.id,
                    row.name,
                    SourceKind(row.kind),
                    row.address,
                    row.attribution,
                    row.most_zoom,
                )
                for row in await connection.execute(asked)
            ]
        self.origins = tuple(dict.fromkeys(source.origin for source in found))
        return found

    async def add_source(self, source: MapSource, key: str) -> int | None:
        """Keep one; its ``id`` is not looked at.

        Returns:
            Its id; None when there are as many as may be.

        """
        sealed = self._seal().seal_text(key, "map source") if key else ""
        async with self._database.write() as connection:
            count = await connection.execute(select(func.count()).select_from(map_sources))
            if count.scalar_one() >= MOST_SOURCES:
                return None
            added = await connection.execute(
                insert(map_sources).values(
                    name=source.name,
                    kind=source.kind.value,
                    address=source.address,
                    attribution=source.attribution,
                    most_zoom=source.most_zoom,
                    sealed_key=sealed,
                    created_us=self._clock.wall_ns() // 1000,
                )
            )
            made = added.inserted_primary_key
        await self.list_sources()
        return int(made[0]) if made else 0

    async def remove_source(self, number: int) -> str | None:
        """Forget one; give the name it had, None when there is none such."""
        mine = map_sources.c.id == number
        async with self._database.write() as connection:
            name = (await connection.execute(select(map_sources.c.name).where(mine))).scalar()
            await connection.execute(delete(map_sources).where(mine))
        await self.list_sources()
        return name

    async def find_key(self, number: int) -> str | None:
        """Give the key of one; None when there is none, or it cannot be read any more."""
        asked = select(map_sources.c.sealed_key).where(map_sources.c.id == number)
        async with self._database.read() as connection:
            sealed = (await connection.execute(asked)).scalar()
        return self._seal().open_text(sealed, "map source") if sealed else None
