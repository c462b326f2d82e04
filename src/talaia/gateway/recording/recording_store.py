"""Recordings on the gateway's disk: begun, finished, waiting for the hub, gone.

A recording is ``<id>.mcap`` (of a camera ``<id>.mp4``) with ``<id>.json`` beside it. While it is
written its name ends in ``.part``; what a killed gateway has left so is made whole again at the
next start.
"""

from __future__ import annotations

import datetime as dt
import errno
import hashlib
import logging
import os
import secrets
import shutil
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.gateway.errors import GatewayError
from talaia.wire.frames import FileOffer, FilmOffer

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

__all__ = [
    "FILM",
    "NoRoom",
    "RecordingStore",
    "RecoveredFile",
    "StoredRecording",
    "new_id",
    "offer_of",
]

log = logging.getLogger(__name__)
# Errors of the disk and not of the file: full, read-only, broken, over quota.
_DISK_TROUBLE = {errno.ENOSPC, errno.EROFS, errno.EIO, errno.EDQUOT}
MESSAGES, FILM = ".mcap", ".mp4"


class NoRoom(GatewayError):
    """The disk has no room for a recording."""


class StoredRecording(msgspec.Struct, kw_only=True):
    """What is known of a recording.

    Attributes:
        digest: SHA-256 of the whole file; empty while it is written.
        note: what is missing in it.
        stream: the camera that it is a film of; empty where it holds messages.
        messages: how many it holds; of a film its pictures.

    """

    id: str
    why: str
    who: str = ""
    begin_us: int = 0
    end_us: int = 0
    messages: int = 0
    size: int = 0
    digest: str = ""
    topics: list[str] = []
    note: str = ""
    stream: str = ""


class RecoveredFile(NamedTuple):
    """What could be read of a file that was cut off.

    Attributes:
        number: of messages, or pictures.
        end_us: when the last of them came.

    """

    number: int
    end_us: int


def offer_of(kept: StoredRecording) -> FileOffer | FilmOffer:
    """Say what a recording is."""
    why, who, note = kept.why[:2000], kept.who[:200], kept.note[:2000]
    if kept.stream:
        return FilmOffer(
            id=kept.id,
            stream=kept.stream,
            size=kept.size,
            digest=kept.digest,
            begin_us=kept.begin_us,
            end_us=kept.end_us,
            pictures=kept.messages,
            why=why,
            who=who,
            note=note,
        )
    return FileOffer(
        id=kept.id,
        size=kept.size,
        digest=kept.digest,
        begin_us=kept.begin_us,
        end_us=kept.end_us,
        why=why,
        who=who,
        messages=kept.messages,
        topics=kept.topics[:1000],
        note=note,
    )


def new_id(wall_ns: int) -> str:
    """Name a recording by the time it begins (UTC) and some chance."""
    moment = dt.datetime.fromtimestamp(wall_ns // 1_000_000_000, dt.UTC)
    return f"{moment:%Y%m%dT%H%M%SZ}-{secrets.token_hex(3)}"


class RecordingStore:
    """The folder of recordings. Its methods block; each may be called from any thread."""

    def __init__(self, folder: Path, max_bytes: int, spare: int, ending: str = MESSAGES) -> None:
        """Use ``folder`` up to ``max_bytes``, and leave ``spare`` bytes of the disk alone.

        All recordings in it end in ``ending``.
        """
        self._folder = folder  # Its own; nobody else writes in it.
        # A recording's names by suffix: done, and being written.
        self._whole, self._part = ending, f"{ending}.part"
        self._max_bytes = max_bytes  # Of all finished ones together.
        self._spare = spare  # Bytes of the disk that must stay free.
        # Ids that the hub refused in this run; a restart offers them again.
        self._refused: set[str] = set()

    def open(self, recover: Callable[[Path, Path], RecoveredFile]) -> None:
        """Make the folder, and make whole what a killed gateway left.

        Args:
            recover: copies what can be read of a broken file into a whole one.

        Raises:
            OSError: the disk cannot be used.

        """
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        for part in self._folder.glob(f"*{self._part}"):
            name = part.name.removesuffix(self._part)
            # Its description may not have been written before the kill.
            kept = self._read_about(name) or StoredRecording(id=name, why="cut off")
            try:
                saved = recover(part, self.whole_path(name))
                kept.messages, kept.end_us = saved.number, max(kept.begin_us, saved.end_us)
                kept.note = "the gateway was ended in the middle of it"
                self.finish_recording(kept)
                log.info("the recording %s was cut off, and is whole again", name)
            except Exception as error:  # noqa: BLE001 - a broken file must not keep us from starting
                if _is_disk_trouble(error):
                    # It says nothing of the recording: a later start tries.
                    log.warning("the recording %s is not made whole now: %s", name, error)
                    continue
                log.warning("the recording %s cannot be made whole: %s", name, error)
                self.remove(name)
            part.unlink(missing_ok=True)

    def part_path(self, name: str) -> Path:
        """Give the file that is being written."""
        return self._folder / (name + self._part)

    def whole_path(self, name: str) -> Path:
        """Give the file of a finished recording."""
        return self._folder / (name + self._whole)

    def check_room(self) -> None:
        """See that the disk has room beside what must be left free.

        Raises:
            NoRoom: it has not.

        """
        found = shutil.disk_usage(self._folder)
        # A twentieth of a small disk, the stated bytes of a large one.
        if found.free < min(self._spare, found.total // 20):
            raise NoRoom(f"the disk of {self._folder} has only {found.free // 2**20} MiB left")

    def begin_recording(self, kept: StoredRecording, size: int) -> list[StoredRecording]:
        """Note a recording that begins and may become ``size`` bytes; give those that had to go.

        Raises:
            NoRoom: the disk is full.
            OSError: it cannot be written.

        """
        self.check_room()
        gone = []
        waiting = self.list_waiting(refused=True)
        # Oldest first: what is recorded now is worth more than what nobody has fetched.
        while waiting and sum(waiter.size for waiter in waiting) + size > self._max_bytes:
            gone.append(waiting.pop(0))
            self.remove(gone[-1].id)
        self._write(kept)
        return gone

    def finish_recording(self, kept: StoredRecording) -> None:
        """Note that ``whole(kept.id)`` is complete.

        Raises:
            OSError: it cannot be written.

        """
        path = self.whole_path(kept.id)
        # Read once more from the disk: the digest is of what is there, not of what was meant.
        with path.open("rb") as file:
            kept.digest = hashlib.file_digest(file, "sha256").hexdigest()
        kept.size = path.stat().st_size
        self._write(kept)

    def list_waiting(self, *, refused: bool = False) -> list[StoredRecording]:
        """List the finished recordings, oldest first; those that the hub refused only if asked."""
        found = []
        for path in sorted(self._folder.glob(f"*{self._whole}")):
            kept = self._read_about(path.name.removesuffix(self._whole))
            if kept is not None and kept.digest and (refused or kept.id not in self._refused):
                found.append(kept)
        return found

    def offers(self) -> list[FileOffer | FilmOffer]:
        """Say of each that waits what it is, oldest first."""
        return [offer_of(waiter) for waiter in self.list_waiting()]

    def refuse(self, name: str) -> None:
        """Do not offer it again in this run."""
        self._refused.add(name)

    def remove(self, name: str) -> None:
        """Forget a recording."""
        for path in (self.part_path(name), self.whole_path(name), self._about_path(name)):
            path.unlink(missing_ok=True)

    def read_part(self, name: str, at: int, size: int) -> bytes:
        """Read a part of a finished recording; shorter at its end.

        Raises:
            OSError: it cannot be read.

        """
        with self.whole_path(name).open("rb") as file:
            return os.pread(file.fileno(), size, at)

    def _about_path(self, name: str) -> Path:
        return self._folder / f"{name}.json"

    def _write(self, kept: StoredRecording) -> None:
        # Beside it and renamed: a kill leaves the old one or the new one, never half.
        partial = self._folder / f"{kept.id}.json.tmp"
        partial.write_bytes(msgspec.json.encode(kept))
        partial.replace(self._about_path(kept.id))

    def _read_about(self, name: str) -> StoredRecording | None:
        try:
            return msgspec.json.decode(self._about_path(name).read_bytes(), type=StoredRecording)
        except (OSError, msgspec.MsgspecError):
            return None


def _is_disk_trouble(error: BaseException | None) -> bool:
    """Tell whether a disk that takes nothing is behind an error, and not what is in the file."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _DISK_TROUBLE:
            return True
        error = error.__cause__
    return False
