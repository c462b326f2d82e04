"""The web components that the hub's administrator put into its folder of extensions."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote

from fastapi import APIRouter, Request
from fastapi.responses import Response

from talaia.extensions.tile_folder import TILE_API_VERSION
from talaia.hub.api.access import who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import problem_response
from talaia.hub.api.schemas.tile_schemas import (
    TileList,
    TileShape,
    TileSignalShape,
)
from talaia.hub.policy import AccessNeed, allows

if TYPE_CHECKING:
    from talaia.extensions.tile_folder import Tile, TileFolder

__all__ = ["TilePages"]

# A new start of the hub may bring another version under the same path.
_FRESH = {"Cache-Control": "no-cache"}


class TilePages:
    """The routes of tiles: what there is, and the files, from memory."""

    def __init__(self, folder: TileFolder) -> None:
        """Serve what was read of ``folder``, and nothing else."""
        self._folder = folder

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/tiles")(self.overview)
        # Files for browsers are no part of the API's description.
        router.api_route(
            "/extensions/{tile}/{path:path}",
            methods=["GET", "HEAD"],
            response_model=None,
            include_in_schema=False,
        )(self.file)
        return router

    async def overview(self, request: Request) -> TileList:
        """List the tiles of this hub's administrator; an admin also learns what is broken."""
        # What is broken names paths and errors of this machine.
        admin = allows(AccessNeed.ADMIN, who_of(request).grants)
        return TileList(
            api=TILE_API_VERSION,
            tiles=[_tile_schema(found) for found in self._folder.tiles],
            broken=list(self._folder.broken) if admin else [],
        )

    async def file(self, tile: str, path: str) -> Response:
        """Give one file of a tile."""
        # Looked up among the names that were read at the start: no path reaches the disk.
        found = self._folder.find_file(tile, path)
        if found is None:
            return problem_response(404, "unknown", "there is no such file")
        return Response(found.content, media_type=found.media_type, headers=_FRESH)


def _tile_schema(tile: Tile) -> TileShape:
    manifest = tile.manifest
    return TileShape(
        name=tile.name,
        title=manifest.title,
        module=f"/extensions/{quote(tile.name)}/{quote(manifest.module)}",
        device=manifest.device or "",
        signals=[
            TileSignalShape(
                name=name,
                type=found.type or "",
                unit=found.unit or "",
                id=found.id or "",
                role=found.role or "",
            )
            for name, found in manifest.signals.items()
        ],
    )
