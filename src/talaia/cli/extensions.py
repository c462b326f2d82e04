"""``talaia extensions``: list what packages and a folder of tiles bring, and what is broken."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.extensions.declarations import Declared, ExtensionKeys

__all__ = ["main"]


def main(argv: Sequence[str]) -> int:
    """List them; 0 when all can be used, 1 when one is broken, 2 without the folder of tiles."""
    parser = argparse.ArgumentParser(
        "talaia extensions",
        description="List the adapters, detectors, notifiers and importers that packages beside"
        " this one bring, with the keys that each takes, and the tiles of a hub's folder; and what"
        " of them is broken, with the reason.",
    )
    parser.add_argument(
        "--extensions",
        type=Path,
        metavar="FOLDER",
        help="also list the tiles in this folder, as the hub would read it",
    )
    folder: Path | None = parser.parse_args(argv).extensions
    # The whole model, which --help and wrong words do not wait for.
    from talaia.extend import API_VERSION
    from talaia.extensions.installed import installed_extensions
    from talaia.extensions.key_descriptions import keys_shown
    from talaia.extensions.tile_folder import TileFolder, read_tiles

    try:
        tiles = TileFolder() if folder is None else read_tiles(folder)
    # The folder itself; a tile in it that cannot be read is listed as broken.
    except OSError as error:
        print(f"{folder} cannot be read: {error.strerror or error}", file=sys.stderr)
        return 2
    found = installed_extensions()
    every = found.list_extensions()
    for extension in every:
        print(
            f"{extension.group.removeprefix('talaia.').removesuffix('s')} {extension.name}: "
            f"{extension.declared.summary} ({extension.package})"
        )
        for title, shape in _key_sets(extension.declared):
            for key in keys_shown(shape):
                must = "required" if key.required else f"default {key.default or 'empty'}"
                about = f": {key.about}" if key.about else ""
                print(f"  {title}{key.name} ({key.type}, {must}){about}")
    for tile in tiles.tiles:
        print(f"tile {tile.name}: {tile.manifest.title} (can be used)")
    if not every and not tiles.tiles:
        print(f"no extensions are installed here (talaia.extend version {API_VERSION})")
    # Errors' stream: a script that reads the list gets only what can be used.
    for broken in found.list_broken():
        print(broken, file=sys.stderr)
    for broken_tile in tiles.broken:
        print(f"tile {broken_tile.name}: broken: {broken_tile.problem}", file=sys.stderr)
    return 1 if found.list_broken() or tiles.broken else 0


def _key_sets(declared: Declared) -> Iterator[tuple[str, type[ExtensionKeys]]]:
    from talaia.extensions.declarations import (
        AdapterExtension,
        DetectorExtension,
        NotifierExtension,
    )

    match declared:
        case AdapterExtension():
            yield "connection.keys.", declared.connection
            yield "source.keys.", declared.source
            if declared.command is not None:
                yield "command: ", declared.command
        case DetectorExtension() | NotifierExtension():
            yield "keys.", declared.keys
        # Importers have none.
        case _:
            pass
