"""Parts that other packages and the administrator's folder bring to the hub."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from talaia.extensions.tile_folder import TileFolder, read_tiles
from talaia.hub.api.server.extensions import ExtensionPages
from talaia.hub.api.server.tiles import TilePages
from talaia.hub.errors import CannotStart
from talaia.hub.features.feature import Feature

if TYPE_CHECKING:
    from talaia.hub.features.feature import Core
    from talaia.hub.settings import Settings

__all__ = ["ExtensionsFeature", "tiles_of"]

_LOG = logging.getLogger(__name__)


class ExtensionsFeature(Feature):
    """Lists what is installed beside the hub, serves its tiles, and names what is broken."""

    name = "extensions"

    def __init__(self, core: Core) -> None:
        """Answer from what is installed, and from the folder that the settings name.

        Raises:
            CannotStart: the folder is not there, cannot be read, or is where uploads are kept.

        """
        folder = tiles_of(core.settings)
        self.routers = [ExtensionPages(folder).make_router(), TilePages(folder).make_router()]


def tiles_of(settings: Settings) -> TileFolder:
    """Read the folder of tiles that the settings name; the log names those that are broken.

    Raises:
        CannotStart: it is not there, cannot be read, or is where uploads are kept.

    """
    chosen = settings.extensions
    if chosen is None:
        return TileFolder()
    # Resolved, so that a link into the data folder is found, too.
    if chosen.resolve().is_relative_to(settings.data.resolve()):
        raise CannotStart(
            f"--extensions {chosen} is inside the data folder, where files of gateways are kept",
            "choose a folder that only the administrator of this machine fills",
        )
    try:
        found = read_tiles(chosen)
    except OSError as error:
        raise CannotStart(
            f"--extensions {chosen} cannot be read: {error.strerror or error}",
            "name a folder that has a folder for each tile",
        ) from error
    # Named here, too: on the page only admins see it, and nobody before somebody signs in.
    for tile in found.broken:
        _LOG.error("the tile %r in %s cannot be used: %s", tile.name, chosen, tile.problem)
    return found
