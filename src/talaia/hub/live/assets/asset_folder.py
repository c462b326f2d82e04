"""Files of robots, such as meshes, in the folder that the hub's owner fills.

The folder has one folder for each site, and in it one for each package: ``package://arm/a.stl`` of
the site ``agv`` is ``agv/arm/a.stl``. Nothing else is ever read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.errors import AssetMissing, AssetRefused
from talaia.wire.asset_uris import is_asset_name, parse_asset_uri

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["AssetFolder"]

# Bytes of a file; it is one message.
_MOST_BYTES = 64 * 1024 * 1024


class AssetFolder:
    """Files by site and URI."""

    def __init__(self, folder: Path | None) -> None:
        """Serve from ``folder``; None: there are no files."""
        self._folder = folder

    def has_site(self, site: str) -> bool:
        """Tell whether there is a folder for a site."""
        return self._folder is not None and (self._folder / site).is_dir()

    def read_file(self, site: str, uri: str) -> bytes:
        """Read the file that a URI names; what is not for everybody looks as if it were missing.

        Raises:
            AssetMissing: there is none.
            AssetRefused: it may not be sent.

        """
        name = parse_asset_uri(uri)
        # Told as of a file that is missing: which folders there are is nobody's matter.
        if name is None or not name.package or self._folder is None:
            raise AssetMissing
        folder = self._folder.resolve()
        base = (folder / site).resolve()
        # A page names the site: `..` is none, and would be the folder above.
        if base.parent != folder:
            raise AssetMissing
        # Where links lead counts: none leads out of the site's folder.
        path = base.joinpath(name.package, *name.parts).resolve()
        if not path.is_relative_to(base) or not path.is_file():
            raise AssetMissing
        if not is_asset_name(path.name):
            raise AssetRefused(f"files that end in {path.suffix!r} are not sent")
        try:
            # One byte more than may be sent tells that there is more.
            with path.open("rb") as file:
                data = file.read(_MOST_BYTES + 1)
        except OSError as error:
            raise AssetRefused(f"the file cannot be read: {error.strerror}") from error
        if len(data) > _MOST_BYTES:
            raise AssetRefused(f"files over {_MOST_BYTES} bytes are not sent")
        return data
