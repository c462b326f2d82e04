"""What other packages bring to this hub, and what of it is broken."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter

from talaia.extensions.declarations import (
    AdapterExtension,
    Declared,
    DetectorExtension,
    ExtensionKeys,
    NotifierExtension,
)
from talaia.extensions.installed import BrokenExtension, installed_extensions
from talaia.extensions.key_descriptions import keys_shown
from talaia.extensions.tile_folder import TILE_GROUP
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.schemas.extension_schemas import (
    ExtensionKeyShape,
    ExtensionList,
    ExtensionShape,
)

if TYPE_CHECKING:
    from talaia.extensions.tile_folder import TileFolder

__all__ = ["ExtensionPages"]


class ExtensionPages:
    """The routes of extensions."""

    def __init__(self, tiles: TileFolder) -> None:
        """List what is installed, and ``tiles`` beside it."""
        self._tiles = tiles

    def make_router(self) -> APIRouter:
        """Give the routes."""
        router = APIRouter(route_class=GuardedRoute)
        router.get("/api/extensions")(self.overview)
        return router

    async def overview(self) -> ExtensionList:
        """List the extensions that are installed at the hub, and what is wrong with them."""
        extensions = [
            ExtensionShape(
                group=found.group,
                name=found.name,
                package=found.package,
                summary=found.declared.summary,
                keys=_key_schemas(found.declared),
            )
            for found in installed_extensions().list_extensions()
        ]
        broken = installed_extensions().list_broken()
        extensions += [
            ExtensionShape(
                group=TILE_GROUP,
                name=found.name,
                package="",
                summary=found.manifest.title,
                keys=[],
            )
            for found in self._tiles.tiles
        ]
        broken += [
            BrokenExtension(group=TILE_GROUP, name=found.name, package="", problem=found.problem)
            for found in self._tiles.broken
        ]
        return ExtensionList(extensions=extensions, broken=broken)


def _key_schemas(declared: Declared) -> list[ExtensionKeyShape]:
    # Has no keys: what an extension of another kind is shown with.
    shape: type[ExtensionKeys] = ExtensionKeys
    secret: frozenset[str] = frozenset()
    match declared:
        case AdapterExtension():
            shape = declared.connection
        case NotifierExtension():
            shape, secret = declared.keys, declared.secret
        case DetectorExtension():
            shape = declared.keys
        case _:
            pass
    return [
        ExtensionKeyShape(**key._asdict(), secret=key.name in secret) for key in keys_shown(shape)
    ]
