"""The folder of recordings: their files, what stands beside each, and what has not come whole.

Whole ones are in this folder or in a bucket, under the same names; see `talaia.hub.files`.

Everything here waits for the disk, so it is called in a thread.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from contextlib import suppress
from typing import TYPE_CHECKING

from talaia.hub.store.sites.recordings import Recorded, RecordingState

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from talaia.wire.frames import FilePiece

__all__ = [
    "FOLDER",
    "UNKNOWN_STREAM",
    "RecordingFiles",
    "about_key",
    "describe_recording",
    "file_key",
    "found_recording",
    "is_recording_id",
    "is_site_folder",
    "read_file_key",
]

FOLDER = "recordings"

_MESSAGES, _FILM, _PART, _ABOUT = ".mcap", ".mp4", ".part", ".json"
# Of a film beside which nothing says whose it is.
UNKNOWN_STREAM = "unknown"
# Ids become names of files: no dot and no slash, so none leaves its folder.
_ID = re.compile(r"[0-9A-Za-z]{1,32}(-[0-9a-z]{1,16})?", re.ASCII)
# Sites become names of folders, and the same holds.
_SITE = re.compile(r"[a-z][a-z0-9_]{0,62}", re.ASCII)
_SPARE_BYTES = 256 * 1024 * 1024


def is_recording_id(name: str) -> bool:
    """Tell whether a name may become a file's."""
    return _ID.fullmatch(name) is not None


def is_site_folder(site: str) -> bool:
    """Tell whether a site may become a folder's name."""
    return _SITE.fullmatch(site) is not None


def file_key(recorded: Recorded) -> str:
    """Name the file of a complete recording in a store of files."""
    return f"{FOLDER}/{recorded.site}/{recorded.id}{_file_ending(recorded)}"


def about_key(recorded: Recorded) -> str:
    """Name what stands beside it."""
    return f"{FOLDER}/{recorded.site}/{recorded.id}{_ABOUT}"


def read_file_key(key: str) -> tuple[str, str, bool] | None:
    """Read site, id, and whether it is a film from a file's key; None: it is no recording's."""
    match key.split("/"):
        case [folder, site, file] if folder == FOLDER and is_site_folder(site):
            name, ending = file[: -len(_FILM)], file[-len(_FILM) :]
            if file.endswith(_MESSAGES):
                name, ending = file.removesuffix(_MESSAGES), _MESSAGES
            if ending in (_MESSAGES, _FILM) and is_recording_id(name):
                return site, name, ending == _FILM
    return None


def describe_recording(about: bytes, known: Recorded) -> Recorded:
    """Say what a file is by the words beside it; where they say nothing, it is as ``known``.

    Of ``known`` what a file itself tells is right in any case: site, id, state, and size.
    """
    with suppress(ValueError, TypeError, KeyError):
        read = json.loads(about)
        told = Recorded(**{**read, "topics": tuple(read["topics"])})
        whole = known.state is RecordingState.COMPLETE
        known = told._replace(
            site=known.site,
            id=known.id,
            state=known.state,
            have=known.have,
            size=known.size if whole else told.size,
            stream=(told.stream or known.stream) if known.stream else "",
        )
    return known


class RecordingFiles:
    """See the module."""

    def __init__(self, folder: Path) -> None:
        """Keep files in ``folder``, by site."""
        self._folder = folder

    def _file_with(self, recorded: Recorded, ending: str) -> Path:
        return self._folder / recorded.site / (recorded.id + ending)

    def part_path(self, recorded: Recorded) -> Path:
        """Say where what has come of a recording is."""
        return self._file_with(recorded, _file_ending(recorded) + _PART)

    def begin_file(self, recorded: Recorded) -> int:
        """Begin a file, or go on with it; give what of it is here (bytes).

        Raises:
            OSError: there is no room for what is announced.

        """
        folder = self._folder / recorded.site
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        # The database and the rest of the machine need the last of the disk more.
        if shutil.disk_usage(folder).free < recorded.size + _SPARE_BYTES:
            raise OSError("the disk is full")
        about = self._file_with(recorded, _ABOUT)
        # Under another name first: a hub that is killed leaves no half of it.
        partial = about.with_suffix(".json.tmp")
        partial.write_text(json.dumps({**recorded._asdict(), "state": recorded.state.value}))
        partial.replace(about)
        part = self.part_path(recorded)
        have = part.stat().st_size if part.exists() else 0
        # Of another file with that name: it cannot be its beginning.
        if have > recorded.size:
            part.unlink()
            have = 0
        return have

    def write_piece(self, recorded: Recorded, piece: FilePiece) -> int:
        """Write what follows; give what of the file is here (bytes).

        Raises:
            OSError: the disk does not take it.

        """
        number = os.open(self.part_path(recorded), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            have = os.fstat(number).st_size
            # Only what follows: a piece that came twice is there already.
            if piece.at == have:
                done = os.pwrite(number, piece.data, piece.at)
                # A full disk may take a part of it: taken back, so that the file ends with a whole
                # piece.
                if done < len(piece.data):
                    os.ftruncate(number, have)
                    raise OSError("the disk is full")
                have += done
            return have
        finally:
            os.close(number)

    def check_part(self, recorded: Recorded) -> bool:
        """Tell whether what came is what was offered; what is not is deleted."""
        part = self.part_path(recorded)
        with part.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
            # On disk before it is called complete: the gateway need not keep its own after that.
            os.fsync(file.fileno())
        if digest != recorded.digest:
            part.unlink()
        return digest == recorded.digest

    def copy_about(self, recorded: Recorded) -> Path:
        """Copy what stands beside it; the copy may be moved away.

        Raises:
            OSError: the disk does not take it.

        """
        about = self._file_with(recorded, _ABOUT)
        copy = about.with_suffix(".json.copy")
        shutil.copyfile(about, copy)
        return copy

    def touched_s(self, recorded: Recorded) -> float:
        """Give when something of it was written last (s since the epoch, UTC)."""
        # What was only offered has nothing but the words beside it.
        for path in (self.part_path(recorded), self._file_with(recorded, _ABOUT)):
            with suppress(FileNotFoundError):
                return path.stat().st_mtime
        return 0.0

    def unlink_files(self, recorded: Recorded) -> None:
        """Delete what has come of it, and what stands beside it."""
        for path in (self.part_path(recorded), self._file_with(recorded, _ABOUT)):
            path.unlink(missing_ok=True)

    def scan_folder(self, has_site: Callable[[str], bool]) -> dict[tuple[str, str], Recorded]:
        """Find all recordings of sites that are looked after here, by site and id."""
        found = {}
        endings = {kind + state: kind for kind in (_MESSAGES, _FILM) for state in ("", _PART)}
        for path in sorted(self._folder.glob("*/*.m*")):
            site, name = path.parent.name, path.name.split(".", 1)[0]
            ending = path.name[len(name) :]
            # What others have may go while this looks.
            if not has_site(site):
                continue
            if ending in endings and _ID.fullmatch(name) and _SITE.fullmatch(site):
                described = self._describe_file(path, site, name, whole=ending == endings[ending])
                # What stands beside it may say nothing, but the ending tells a film.
                film = endings[ending] == _FILM
                stream = (described.stream or UNKNOWN_STREAM) if film else ""
                found[site, name] = described._replace(stream=stream)
        return found

    def _describe_file(self, path: Path, site: str, name: str, *, whole: bool) -> Recorded:
        """Say what a file is: by the words beside it, else by what the disk knows."""
        found = path.stat()
        state = RecordingState.COMPLETE if whole else RecordingState.UPLOADING
        known = found_recording(site, name, found.st_size, found.st_mtime_ns // 1000)
        # Whether it is a film, its ending tells.
        known = known._replace(state=state, stream=UNKNOWN_STREAM)
        about = b""
        with suppress(OSError):
            about = (path.parent / (name + _ABOUT)).read_bytes()
        return describe_recording(about, known)


def found_recording(site: str, name: str, size: int, changed_us: int) -> Recorded:
    """Describe a whole recording of which nothing is known but its file."""
    return Recorded(
        site=site,
        id=name,
        state=RecordingState.COMPLETE,
        why="found in the folder",
        who="",
        note="",
        begin_us=changed_us,
        end_us=changed_us,
        size=size,
        have=size,
        messages=0,
        digest="",
        topics=(),
    )


def _file_ending(recorded: Recorded) -> str:
    return _FILM if recorded.stream else _MESSAGES
