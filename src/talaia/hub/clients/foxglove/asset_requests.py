"""Files of robots, such as meshes, that clients fetch: from one folder that the hub may serve.

The folder has one folder for each site, and in it one for each package: ``package://arm/a.stl`` of
the site ``agv`` is ``agv/arm/a.stl``. Nothing else is ever read.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING
from urllib.parse import unquote

from talaia.hub.auth.permissions import Right
from talaia.hub.errors import HubError
from talaia.wire.foxglove.codec import encode_asset

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from talaia.hub.auth.permissions import Grants
    from talaia.wire.foxglove.client_messages import FoxgloveFetchAsset

__all__ = ["AssetFolder", "AssetRefused", "AssetRequests"]

_SCHEME = "package://"
# Of meshes, what they are painted with, and robot descriptions.
_SUFFIXES = frozenset(
    {".bin", ".bmp", ".dae", ".glb", ".gltf", ".jpeg", ".jpg", ".mtl", ".obj", ".ply", ".png"}
    | {".sdf", ".srdf", ".stl", ".tga", ".tif", ".tiff", ".urdf", ".webp", ".xacro", ".xml"}
)
# Bytes of a file; it is one message.
_MOST_BYTES = 64 * 1024 * 1024
# Requests of one client that wait.
_MOST_WAITING = 1000
_MISSING = "there is no such file"


class AssetRefused(HubError):
    """A file that is not sent; a sentence for people."""


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
            AssetRefused: there is none that may be sent.

        """
        # Told as of a file that is missing: which folders there are is nobody's matter.
        if self._folder is None:
            raise AssetRefused(_MISSING)
        folder = self._folder.resolve()
        base = (folder / site).resolve()
        # A page names the site: `..` is none, and would be the folder above.
        if base.parent != folder:
            raise AssetRefused(_MISSING)
        # Where links lead counts: none leads out of the site's folder.
        path = base.joinpath(*_path_parts(uri)).resolve()
        if not path.is_relative_to(base) or not path.is_file():
            raise AssetRefused(_MISSING)
        if path.suffix.lower() not in _SUFFIXES:
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


def _path_parts(uri: str) -> list[str]:
    """Take a URI apart into the names of folders and the file.

    Raises:
        AssetRefused: it is no name of a file of a package.

    """
    if not uri.startswith(_SCHEME):
        raise AssetRefused(f"files are named {_SCHEME}<package>/<path>")
    # Taken apart first: a slash that is written %2F separates nothing.
    parts = [unquote(part) for part in uri.removeprefix(_SCHEME).split("/")]
    for part in parts:
        # Also what is hidden, and what another system would take for a way up or a drive.
        if part.startswith(".") or not part.isprintable() or not part or set(part) & set("/\\:"):
            raise AssetRefused(_MISSING)
    return parts


class AssetRequests:
    """The requests of one client: one after the other, beside all else that it is sent.

    Attributes:
        capabilities: what the client is told of it.

    """

    def __init__(
        self,
        folder: AssetFolder,
        site: str,
        grants: Grants,
        *,
        send: Callable[[bytes], Awaitable[None]],
    ) -> None:
        """Answer by ``send``; who may view no device of the site gets no file of its robots."""
        self._folder = folder
        self._site = site
        # None stands for all devices.
        devices = grants.devices(Right.VIEW, site)
        self._allowed = devices is None or bool(devices)
        self._send = send
        # Beside the session: a large file on a slow line must not hold up STOP.
        self._waiting: asyncio.Queue[FoxgloveFetchAsset] = asyncio.Queue(_MOST_WAITING)
        self.capabilities = ["assets"] if self._allowed and folder.has_site(site) else []

    async def fetch_asset(self, asked: FoxgloveFetchAsset) -> None:
        """Answer a request when those before it are answered."""
        try:
            self._waiting.put_nowait(asked)
        except asyncio.QueueFull:
            why = f"at most {_MOST_WAITING} files at once"
            await self._send(encode_asset(asked.request_id, None, why))

    async def serve_requests(self) -> None:
        """Answer what is asked, until cancelled."""
        while True:
            asked = await self._waiting.get()
            await self._send(await self._answer(asked))

    async def _answer(self, asked: FoxgloveFetchAsset) -> bytes:
        if not self._allowed:
            return encode_asset(asked.request_id, None, _MISSING)
        try:
            # A disk may take its time.
            data = await asyncio.to_thread(self._folder.read_file, self._site, asked.uri)
        except AssetRefused as refused:
            return encode_asset(asked.request_id, None, str(refused))
        return encode_asset(asked.request_id, data)
