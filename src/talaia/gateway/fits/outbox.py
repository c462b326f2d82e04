"""Files that wait for the hub, on disk: each with a note beside it that says what it is.

Kinds are open (``fits`` today): whatever a gateway makes that is too large for a message goes
this way, one file after the other, and is forgotten when the hub has it whole.
"""

from __future__ import annotations

import hashlib
import logging
import secrets
import threading
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.persistence import write_whole
from talaia.wire.frames import ArchiveOffer

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = ["ArchiveOutbox"]

log = logging.getLogger(__name__)


class ArchiveOutbox:
    """The folder. Its methods block; each may be called from any thread."""

    def __init__(
        self,
        folder: Path,
        most_bytes: int,
        wake: Callable[[], None],
        notice: Callable[[Path, str], None] = lambda _made, _device: None,
        *,
        kept: Callable[[str, str], None] = lambda _device, _digest: None,
    ) -> None:
        """Keep at most so many bytes; the oldest give way, and that is logged.

        Args:
            folder: made if it is not there.
            most_bytes: see above.
            wake: called, from the thread that puts, when there is something new.
            notice: called before that, with each file and its device, while the file is there.
            kept: called, from the same thread, with the device and SHA-256 of each that is kept.

        """
        self._folder = folder
        self._most = most_bytes
        self._wake, self._notice, self._kept = wake, notice, kept
        # Files are added, dropped and counted by one thread at a time.
        self._turn = threading.Lock()

    def add_file(self, made: Path, kind: str, device: str, time_us: int) -> None:
        """Take a file over.

        Raises:
            OSError: it cannot be taken.

        """
        self._folder.mkdir(parents=True, exist_ok=True)
        digest, size = _digest_file(made)
        self._notice(made, device)
        # Names sort by time, so that the oldest goes first.
        name = f"{time_us:016x}{secrets.token_hex(8)}"
        offer = ArchiveOffer(
            id=name, kind=kind, device=device, size=size, digest=digest, time_us=time_us
        )
        with self._turn:
            self._make_room(size)
            made.replace(self._folder / f"{name}.bin")
            write_whole(self._folder / f"{name}.json", msgspec.json.encode(offer))
        self._kept(device, digest)
        self._wake()

    def offers(self) -> list[ArchiveOffer]:
        """List what waits, oldest first."""
        with self._turn:
            return [
                offer
                for path in sorted(self._folder.glob("*.json"))
                if (offer := _read_offer(path))
            ]

    def file_path(self, file: str) -> Path:
        """Say where a file is."""
        return self._folder / f"{file}.bin"

    def read_part(self, file: str, offset: int, size: int) -> bytes:
        """Read a part.

        Raises:
            OSError: it cannot be read.

        """
        with self.file_path(file).open("rb") as data:
            data.seek(offset)
            return data.read(size)

    def remove(self, file: str) -> None:
        """Forget a file: the hub has it."""
        with self._turn:
            self._delete_file(file)

    def refuse(self, file: str) -> None:
        """Keep a file that the hub does not take, but offer it no more."""
        with self._turn:
            note = self._folder / f"{file}.json"
            if note.exists():
                note.rename(note.with_suffix(".refused"))

    def _delete_file(self, file: str) -> None:
        (self._folder / f"{file}.json").unlink(missing_ok=True)
        self.file_path(file).unlink(missing_ok=True)

    def _make_room(self, wanted: int) -> None:
        waiting = sorted(self._folder.glob("*.bin"))
        taken = sum(path.stat().st_size for path in waiting) + wanted
        for path in waiting:
            if taken <= self._most:
                return
            taken -= path.stat().st_size
            log.warning("the outbox is full: %s is dropped before the hub had it", path.stem)
            self._delete_file(path.stem)
            path.with_suffix(".refused").unlink(missing_ok=True)


def _read_offer(path: Path) -> ArchiveOffer | None:
    try:
        offer = msgspec.json.decode(path.read_bytes(), type=ArchiveOffer)
    except (OSError, msgspec.DecodeError) as error:
        log.warning("%s is set aside: %s", path, error)
        path.rename(path.with_suffix(".bad"))
        return None
    whole = offer.id == path.stem and path.with_suffix(".bin").exists()
    return offer if whole else None


def _digest_file(path: Path) -> tuple[str, int]:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while data := file.read(1024 * 1024):
            digest.update(data)
        return digest.hexdigest(), file.tell()
