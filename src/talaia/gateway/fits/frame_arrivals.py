"""Hands the next FITS file of a camera to whoever waits for it, on its way into the outbox."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["FrameArrivals"]

_Value = TypeVar("_Value")
log = logging.getLogger(__name__)


class FrameArrivals:
    """One waits for each camera at the most; who asks later takes the place."""

    def __init__(self) -> None:
        """Wait for nothing yet."""
        self._waiting: dict[str, asyncio.Future[bytes]] = {}
        # The same for the names of files, which are in the outbox by then.
        self._unnamed: dict[str, asyncio.Future[str]] = {}

    def expect_frame(self, camera: str) -> asyncio.Future[bytes]:
        """Wait for the next file of a camera. On the event loop."""
        came: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._waiting[camera] = came
        return came

    def forget_frame(self, camera: str) -> None:
        """Wait no longer."""
        self._waiting.pop(camera, None)

    def expect_name(self, camera: str) -> asyncio.Future[str]:
        """Wait until the next file of a camera is in the outbox, for its SHA-256. On the loop."""
        came: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._unnamed[camera] = came
        return came

    def note_kept(self, camera: str, digest: str) -> None:
        """Take in that a file is in the outbox. On any thread."""
        came = self._unnamed.pop(camera, None)
        if came is not None:
            try:
                came.get_loop().call_soon_threadsafe(_settle_future, came, digest)
            except RuntimeError:
                # The gateway ends; nobody waits any more.
                return

    def notice_file(self, made: Path, camera: str) -> None:
        """Take in that a file is whole. On any thread; read only where somebody waits for it."""
        if camera not in self._waiting:
            return
        try:
            data = made.read_bytes()
        except OSError as error:
            log.warning("%s: a picture cannot be read again: %s", camera, error)
            return
        came = self._waiting.pop(camera, None)
        if came is not None:
            try:
                came.get_loop().call_soon_threadsafe(_settle_future, came, data)
            except RuntimeError:
                # The gateway ends; nobody waits any more.
                return


def _settle_future(came: asyncio.Future[_Value], data: _Value) -> None:
    if not came.done():
        came.set_result(data)
