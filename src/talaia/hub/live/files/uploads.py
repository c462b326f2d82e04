"""Files for the archive: gathered on disk, checked, and given to who keeps their kind.

They come on the gateway's socket for files, piece by piece, each answered. What has come stays
when the connection is lost, and the gateway is told from where on to go on.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
import os
import shutil
import time
from typing import TYPE_CHECKING, Protocol
from zlib import crc32

from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.hub.errors import StoreDown
from talaia.hub.live.files.site_turns import SiteTurns
from talaia.hub.live.files.standstill import STANDSTILL_S
from talaia.wire.errors import PeerError
from talaia.wire.frames import FileProgress

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping
    from pathlib import Path

    from talaia.wire.frames import ArchiveOffer, FilePiece

__all__ = ["Keeper", "UploadRefused", "Uploads"]

log = logging.getLogger(__name__)
# Stays free on the disk for the database and the rest of the machine.
_SPARE_BYTES = 512 * 1024 * 1024
# Parts of one site together may take the room of so many files of the largest size, so that no
# gateway fills the disk of all.
_MOST_PARTS = 4


class UploadRefused(TalaiaError):
    """A file that its keeper does not want, with the reason."""


class Keeper(Protocol):
    """Who keeps files of one kind."""

    async def __call__(self, site: str, offer: ArchiveOffer, path: Path) -> None:
        """Take a whole file and move it away.

        Raises:
            Refused: it is not wanted, and never will be.
            OSError: not now.

        """
        ...


class Uploads:
    """The folder of what has not come whole, for all gateways."""

    def __init__(
        self,
        folder: Path,
        keepers: Mapping[str, Keeper],
        *,
        most_bytes: int,
        share: Callable[[str, int], Awaitable[bool]],
        has_site: Callable[[str], bool] = lambda _site: True,
    ) -> None:
        """Gather in ``folder``; a file of more than ``most_bytes`` is refused.

        ``share`` tells whether a site may have so many bytes more of the disk, and ``has_site``
        whether it is looked after here: others may gather theirs in the same folder.
        """
        self._has_site = has_site
        # One folder for each site; parts of files by the id of their offer.
        self._folder = folder
        # Who keeps a file that is whole, by its kind.
        self._keepers = keepers
        # Largest file (bytes).
        self._most = most_bytes
        self._share = share
        # One thing at a time for each site: two connections may bring the same.
        self._turns = SiteTurns()

    async def answer_offer(self, site: str, offer: ArchiveOffer) -> FileProgress:
        """Answer an offer: how much of it is here.

        Raises:
            StoreDown: it cannot be taken now.

        """
        async with self._turns.wait_turn(site):
            return await self._answer_piece(site, offer, None)

    async def append_piece(self, site: str, offer: ArchiveOffer, piece: FilePiece) -> FileProgress:
        """Take a piece of an offered file.

        Raises:
            PeerError: it does not fit.
            StoreDown: it cannot be taken now.

        """
        # The sum is of this piece alone; the whole has its SHA-256 in the offer.
        if crc32(piece.data) != piece.check:
            raise PeerError("a piece that is not what its sum says")
        # The size was checked when it was offered: pieces must not get around that.
        if piece.at + len(piece.data) > offer.size or not piece.data:
            raise PeerError("a piece that does not lie inside its file")
        async with self._turns.wait_turn(site):
            return await self._answer_piece(site, offer, piece)

    async def end_standing_uploads(self) -> None:
        """End uploads of any site that nobody has gone on with for long."""
        folders = await asyncio.to_thread(lambda: list(self._folder.glob("*/")))
        for folder in filter(lambda folder: self._has_site(folder.name), folders):
            async with self._turns.wait_turn(folder.name):
                await asyncio.to_thread(_forget_standing, folder)

    async def _answer_piece(
        self, site: str, offer: ArchiveOffer, piece: FilePiece | None
    ) -> FileProgress:
        try:
            if piece is None:
                have = await self._begin_upload(site, offer)
            else:
                have = await asyncio.to_thread(_append_piece, self._part_path(site, offer), piece)
            if have < offer.size:
                return FileProgress(id=offer.id, have=have)
            return await self._finish_upload(site, offer)
        except UploadRefused as error:
            log.warning("a file of %s is refused: %s", site, error)
            return FileProgress(id=offer.id, refused=str(error)[:2000])
        except (OSError, TalaiaError, SQLAlchemyError) as error:
            # The gateway offers it again after a while.
            log.warning("a file of %s must wait: %s", site, error)
            raise StoreDown(f"a file must wait: {error}") from error

    async def _begin_upload(self, site: str, offer: ArchiveOffer) -> int:
        if offer.kind not in self._keepers:
            raise UploadRefused(f"this hub keeps no files of the kind {offer.kind!r}")
        if offer.size > self._most:
            raise UploadRefused(
                f"a file of {offer.size} bytes is more than the {self._most} allowed"
            )
        if not await self._share(site, offer.size):
            raise OSError("the last of the hub's disk is for sites that hold less of it")
        return await asyncio.to_thread(self._found_bytes, site, offer)

    async def _finish_upload(self, site: str, offer: ArchiveOffer) -> FileProgress:
        path = self._part_path(site, offer)
        if await asyncio.to_thread(_file_digest, path) != offer.digest:
            # Which piece is wrong cannot be told, so all of it comes once more.
            path.unlink(missing_ok=True)
            log.warning("a file of %s came damaged; it is sent again", site)
            return FileProgress(id=offer.id)
        try:
            await self._keepers[offer.kind](site, offer, path)
        except UploadRefused:
            # Refused for good: it would only fill the disk.
            path.unlink(missing_ok=True)
            raise
        return FileProgress(id=offer.id, have=offer.size, done=True)

    def _part_path(self, site: str, offer: ArchiveOffer) -> Path:
        return self._folder / site / f"{offer.id}.part"

    def _found_bytes(self, site: str, offer: ArchiveOffer) -> int:
        path = self._part_path(site, offer)
        path.parent.mkdir(parents=True, exist_ok=True)
        _forget_standing(path.parent)
        size = path.stat().st_size if path.exists() else 0
        others = sum(part.stat().st_size for part in path.parent.glob("*.part") if part != path)
        if others + offer.size > _MOST_PARTS * self._most:
            raise OSError("too much of this site is on its way already")
        if shutil.disk_usage(path.parent).free < offer.size - size + _SPARE_BYTES:
            raise OSError("the hub's disk is full")
        # Longer than what is offered: it was another file.
        if size > offer.size:
            path.unlink()
            size = 0
        if not size:
            path.touch()
        return size


def _forget_standing(folder: Path) -> None:
    for old in folder.glob("*.part"):
        if time.time() - old.stat().st_mtime > STANDSTILL_S:
            old.unlink(missing_ok=True)


def _append_piece(path: Path, piece: FilePiece) -> int:
    # Readable by the hub's own account only.
    number = os.open(path, os.O_WRONLY | os.O_CREAT, 0o600)
    try:
        have = os.fstat(number).st_size
        # Only what follows: a piece that came twice is there already.
        if piece.at == have:
            have += os.pwrite(number, piece.data, piece.at)
        return have
    finally:
        os.close(number)


def _file_digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
