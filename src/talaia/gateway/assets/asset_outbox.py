"""Files of the robot that the hub wants, as a `FileSource` of the connection for files."""

from __future__ import annotations

import hashlib
import threading
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.errors import AssetUnavailable
from talaia.wire.frames import ASSET_KIND, ArchiveOffer, asset_file_id

if TYPE_CHECKING:
    from talaia.gateway.assets.asset_reader import AssetReader, ReadAsset
    from talaia.wire.asset_uris import AssetUri

__all__ = ["AssetOutbox"]


class _WaitingAsset(NamedTuple):
    name: AssetUri
    offer: ArchiveOffer


class AssetOutbox:
    """What waits, and the bytes of the one that is on its way. Any thread."""

    def __init__(self, reader: AssetReader) -> None:
        """Read by ``reader``, which no other thread uses meanwhile."""
        self._reader = reader
        self._lock = threading.Lock()
        # By the offer's id, in the order in which they were asked for.
        self._waiting: dict[str, _WaitingAsset] = {}
        # Read at one blow: what goes is what its digest says, whatever is written meanwhile.
        self._open: tuple[str, bytes] = "", b""

    def add_asset(self, name: AssetUri, found: ReadAsset) -> None:
        """Let a file wait; one of the same content that waits already stays."""
        file_id = asset_file_id(found.digest)
        offer = ArchiveOffer(id=file_id, kind=ASSET_KIND, size=found.size, digest=found.digest)
        with self._lock:
            self._waiting.setdefault(file_id, _WaitingAsset(name, offer))

    def clear(self) -> None:
        """Forget all: nobody asks for it any more."""
        with self._lock:
            self._waiting.clear()

    def offers(self) -> list[ArchiveOffer]:
        """See `FileSource`."""
        with self._lock:
            return [waiting.offer for waiting in self._waiting.values()]

    def read_part(self, name: str, at: int, size: int) -> bytes:
        """See `FileSource`."""
        if self._open[0] != name:
            with self._lock:
                waiting = self._waiting.get(name)
            if waiting is None:
                raise OSError("nobody asks for it any more")
            try:
                data = self._reader.read_whole(waiting.name)
            except (AssetUnavailable, OSError) as error:
                self.remove(name)
                raise OSError(str(error)) from error
            if hashlib.sha256(data).hexdigest() != waiting.offer.digest:
                self.remove(name)
                raise OSError("it was changed while it was sent")
            self._open = name, data
        return self._open[1][at : at + size]

    def remove(self, name: str) -> None:
        """See `FileSource`; what it has read is forgotten, too."""
        with self._lock:
            self._waiting.pop(name, None)
        if self._open[0] == name:
            self._open = "", b""

    def refuse(self, name: str) -> None:
        """See `FileSource`."""
        self.remove(name)
