"""Maps that a page may show: files of the hub's folder, and tile servers that an admin allowed."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING
from urllib.parse import quote, urlsplit

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse, Response

from talaia.hub.api.access import address_of, number_of, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.maps.google_sessions import SessionRefused
from talaia.hub.api.maps.map_schemas import (
    MapFile,
    MapOffer,
    MapSession,
    MapSourceAsk,
    MapSourceMade,
    MapSourceShape,
)
from talaia.hub.api.problems import ApiProblem
from talaia.hub.auth.passwords import check_name
from talaia.hub.errors import WeakPassword
from talaia.hub.store.sites.map_sources import MOST_SOURCES, MapSource, SourceKind, tile_origin

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.hub.api.maps.google_sessions import GoogleSessions
    from talaia.hub.store.audit import Audit
    from talaia.hub.store.sites.map_sources import MapSources

__all__ = ["MapPages"]

_SUFFIX = ".pmtiles"
# Google asks for its name, and for no other zoom than these.
_GOOGLE_ATTRIBUTION, _GOOGLE_ZOOM = "Map data © Google", 22
# A list in a menu.
_MOST_FILES = 100


class MapPages:
    """The routes of maps."""

    def __init__(
        self,
        *,
        folder: Path | None,
        sources: MapSources,
        sessions: GoogleSessions,
        audit: Audit,
    ) -> None:
        """Answer from the PMTiles files of ``folder``, and from ``sources``."""
        self._folder = folder
        self._sources = sources
        self._sessions = sessions
        self._audit = audit

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/maps")(self.overview)
        router.get("/api/maps/files/{name}", response_class=Response)(self.file)
        router.post("/api/maps/sources")(self.add)
        router.delete("/api/maps/sources/{source}", status_code=204)(self.remove)
        router.get("/api/maps/sources/{source}/session")(self.session)
        return router

    async def overview(self) -> MapOffer:
        """List the maps that may be shown; the pages bring a coarse world besides."""
        names = await asyncio.to_thread(self._list_files)
        return MapOffer(
            files=[
                MapFile(name=name.removesuffix(_SUFFIX), url=f"/api/maps/files/{quote(name)}")
                for name in names
            ],
            sources=[_source_schema(source) for source in await self._sources.list_sources()],
        )

    async def file(self, name: str) -> Response:
        """Give a part of a map's file (PMTiles); ranges may be asked for."""
        # By the list: no name leads out of the folder, and nothing else in it is given away.
        if self._folder is None or name not in await asyncio.to_thread(self._list_files):
            raise ApiProblem(404, "unknown", "there is no such map")
        return FileResponse(self._folder / name, media_type="application/vnd.pmtiles")

    async def add(self, asked: MapSourceAsk, request: Request) -> MapSourceMade:
        """Allow a tile server: whoever looks at its map tells it where, by the tiles they ask for.

        Pages that are loaded from then on may ask its host for pictures, and no other one.
        """
        source = _source_of(asked)
        made = await self._sources.add_source(source, asked.key)
        if made is None:
            raise ApiProblem(409, "busy", f"there are {MOST_SOURCES} sources; remove some first")
        self._append_record(request, "map source allowed", f"{source.name}, {source.origin}")
        return MapSourceMade(id=str(made))

    async def remove(self, source: str, request: Request) -> None:
        """Forbid a tile server again; pages that are loaded from then on do not ask it."""
        name = await self._sources.remove_source(number_of(source, "map"))
        if name is None:
            raise ApiProblem(404, "unknown", "there is no such map")
        self._append_record(request, "map source removed", name)

    async def session(self, source: str) -> MapSession:
        """Give the address of the tiles of a map that is asked by sessions, such as Google's."""
        key = await self._sources.find_key(number_of(source, "map"))
        if key is None:
            raise ApiProblem(404, "unknown", "there is no such map, or it takes no session")
        try:
            made = await self._sessions.open_session(key)
        except SessionRefused as refused:
            raise ApiProblem(502, "map", str(refused)) from refused
        return MapSession(tiles=made.tiles, ends_us=made.ends_us)

    def _list_files(self) -> list[str]:
        if self._folder is None:
            return []
        try:
            found = [
                path.name
                for path in self._folder.iterdir()
                if path.suffix == _SUFFIX and path.is_file() and path.name.isprintable()
            ]
        except OSError:
            # Unplugged, say: the world that pages bring is still there.
            return []
        return sorted(found)[:_MOST_FILES]

    def _append_record(self, request: Request, kind: str, message: str) -> None:
        name, address = who_of(request).name, address_of(request)
        self._audit.append_record(kind, who=name, address=address, message=message)


def _source_of(asked: MapSourceAsk) -> MapSource:
    """Give what is to be kept.

    Raises:
        ApiProblem: it cannot be.

    """
    google = asked.kind is SourceKind.GOOGLE
    problem = ""
    if google and (asked.address or not asked.key):
        problem = "Google is asked by a key, and its address is known"
    elif asked.key and not google:
        problem = "a key of another server stands in its address"
    elif not all(text.isprintable() for text in (asked.address, asked.attribution, asked.key)):
        problem = "there are control characters in it"
    if problem:
        raise ApiProblem(422, "invalid", problem)
    try:
        check_name(asked.name)
        if not google:
            tile_origin(asked.address)
    except (WeakPassword, ValueError) as error:
        raise ApiProblem(422, "invalid", str(error)) from error
    return MapSource(
        0,
        asked.name,
        asked.kind,
        asked.address,
        _GOOGLE_ATTRIBUTION if google else asked.attribution,
        _GOOGLE_ZOOM if google else asked.most_zoom,
    )


def _source_schema(source: MapSource) -> MapSourceShape:
    return MapSourceShape(
        id=str(source.id),
        name=source.name,
        kind=source.kind,
        host=urlsplit(source.origin).netloc,
        tiles=source.address,
        attribution=source.attribution,
        most_zoom=source.most_zoom,
    )
