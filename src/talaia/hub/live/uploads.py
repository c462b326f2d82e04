"""Files that gateways send: gathered on disk, checked, and given to who keeps their kind.

A file comes in small parts on the link, below everything that is urgent. What has come stays
when the link is lost, and the gateway is told from where on to go on.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
import os
import shutil
import time
from typing import TYPE_CHECKING, Protocol

from sqlalchemy.exc import SQLAlchemyError

from talaia.errors import TalaiaError
from talaia.wire.frames import UploadOffer, UploadPart, UploadState

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

__all__ = ["Keeper", "Refused", "Uploads"]

log = logging.getLogger(__name__)
_MOST_WAITING = 64
# Said after each so many bytes, so that the gateway goes on.
_SAY_EVERY = 64 * 1024
_SPARE_BYTES = 512 * 1024 * 1024
_FORGET_S = 14 * 86_400


class Refused(TalaiaError):
    """A file that its keeper does not want, with the reason."""


class Keeper(Protocol):
    """Who keeps files of one kind."""

    async def __call__(self, site: str, offer: UploadOffer, path: Path) -> None:
        """Take a whole file and move it away.

        Raises:
            Refused: it is not wanted, and never will be.
            OSError: not now.

        """
        ...


class Uploads:
    """The folder of what has not come whole, for all gateways."""

    def __init__(self, folder: Path, keepers: Mapping[str, Keeper], most_bytes: int) -> None:
        """Gather in ``folder``; a file of more than ``most_bytes`` is refused."""
        self._folder = folder
        self._keepers = keepers
        self._most = most_bytes

    def of(self, site: str, send: Callable[[UploadState], None]) -> Upload:
        """Serve one link."""
        return Upload(self._folder / site, self._keepers, self._most, site, send)


class Upload:
    """The files of one link. `put` never waits; `run` works."""

    def __init__(
        self,
        folder: Path,
        keepers: Mapping[str, Keeper],
        most_bytes: int,
        site: str,
        send: Callable[[UploadState], None],
    ) -> None:
        """Begin with nothing offered."""
        self._folder, self._keepers, self._most = folder, keepers, most_bytes
        self._site, self._send = site, send
        self._waiting: asyncio.Queue[UploadOffer | UploadPart] = asyncio.Queue(_MOST_WAITING)
        self._offer: UploadOffer | None = None
        self._below = 0
        self._said = 0
        self._again = False

    def put(self, message: UploadOffer | UploadPart) -> None:
        """Take a message; one too many is dropped, and asked for again."""
        try:
            self._waiting.put_nowait(message)
        except asyncio.QueueFull:
            log.debug("%s sends a file faster than it was told to", self._site)

    async def run(self) -> None:
        """Work until cancelled."""
        while True:
            message = await self._waiting.get()
            try:
                if isinstance(message, UploadOffer):
                    await self._begin(message)
                else:
                    await self._part(message)
            except Refused as error:
                self._refuse(message.file, str(error))
            except (OSError, TalaiaError, SQLAlchemyError) as error:
                # Nothing is said: the gateway offers it again after a while.
                log.warning("a file of %s must wait: %s", self._site, error)
                self._offer = None

    async def _begin(self, offer: UploadOffer) -> None:
        if offer.kind not in self._keepers:
            raise Refused(f"this hub keeps no files of the kind {offer.kind!r}")
        if offer.size > self._most:
            raise Refused(f"a file of {offer.size} bytes is more than the {self._most} allowed")
        self._offer = offer
        self._below = await asyncio.to_thread(self._found, offer)
        self._said, self._again = self._below, False
        if self._below >= offer.size:
            await self._finish(offer)
        else:
            self._send(UploadState(file=offer.file, below=self._below))

    async def _part(self, part: UploadPart) -> None:
        offer = self._offer
        if offer is None or part.file != offer.file:
            return
        if part.offset != self._below or self._below + len(part.data) > offer.size:
            # Said once; what is on its way meanwhile does not follow either.
            if not self._again:
                self._again = True
                self._send(UploadState(file=offer.file, below=self._below, again=True))
            return
        self._again = False
        await asyncio.to_thread(_append, self._path(offer), part)
        self._below += len(part.data)
        if self._below == offer.size:
            await self._finish(offer)
        elif self._below - self._said >= _SAY_EVERY:
            self._said = self._below
            self._send(UploadState(file=offer.file, below=self._below))

    async def _finish(self, offer: UploadOffer) -> None:
        path = self._path(offer)
        self._offer = None
        if await asyncio.to_thread(_digest, path) != offer.digest:
            path.unlink(missing_ok=True)
            log.warning("a file of %s came damaged; it is sent again", self._site)
            self._offer, self._below, self._said = offer, 0, 0
            self._send(UploadState(file=offer.file, below=0, again=True))
            return
        try:
            await self._keepers[offer.kind](self._site, offer, path)
        except Refused:
            path.unlink(missing_ok=True)
            raise
        self._send(UploadState(file=offer.file, below=offer.size, done=True))

    def _refuse(self, file: str, why: str) -> None:
        log.warning("a file of %s is refused: %s", self._site, why)
        self._offer = None
        self._send(UploadState(file=file, below=0, refused=why[:2000]))

    def _path(self, offer: UploadOffer) -> Path:
        return self._folder / f"{offer.file}.part"

    def _found(self, offer: UploadOffer) -> int:
        self._folder.mkdir(parents=True, exist_ok=True)
        self._forget_old()
        path = self._path(offer)
        size = path.stat().st_size if path.exists() else 0
        if shutil.disk_usage(self._folder).free < offer.size - size + _SPARE_BYTES:
            raise OSError("the hub's disk is full")
        if size > offer.size:
            path.unlink()
            return 0
        if not size:
            path.touch()
        return size

    def _forget_old(self) -> None:
        for path in self._folder.glob("*.part"):
            if time.time() - path.stat().st_mtime > _FORGET_S:
                path.unlink(missing_ok=True)


def _append(path: Path, part: UploadPart) -> None:
    # At its place, not at the end: what a crash has left there is written over.
    file = os.open(path, os.O_WRONLY | os.O_CREAT, 0o600)
    try:
        os.pwrite(file, part.data, part.offset)
    finally:
        os.close(file)


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while data := file.read(1024 * 1024):
            digest.update(data)
    return digest.hexdigest()
