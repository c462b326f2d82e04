"""The folder of releases: files that an admin has put there, and how the rollout stands.

Everything here waits for the disk, so it is called in a thread.
"""

from __future__ import annotations

import hashlib
import os
from typing import TYPE_CHECKING, NamedTuple
from zlib import crc32

import msgspec

from talaia.hub.live.releases.rollout import Rollout
from talaia.updates.errors import UpdateError
from talaia.updates.signed_release import read_unproven
from talaia.wire.frames import PIECE, ReleasePiece

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["KeptRelease", "ReleaseFolder"]

_ENDING = ".release"
_MOST_ROLLOUT = 8 << 20
# Of a folder into which somebody has copied everything.
_MOST_FILES = 200


class KeptRelease(NamedTuple):
    """A file in the folder.

    Attributes:
        name: of the file.
        version: of the release; empty where it cannot be read.
        site: the gateway it is for; empty for all.
        size: bytes.
        changed_us: when it was put there (UTC).
        problem: why it cannot be handed out; empty: it can.

    """

    name: str
    version: str
    site: str
    size: int
    changed_us: int
    problem: str = ""


class ReleaseFolder:
    """See the module."""

    def __init__(self, path: Path, suffix: str = "") -> None:
        """Look into ``path``, which need not be there.

        ``suffix`` is of the rollout's file: others may hand out what is in the same folder.
        """
        self._path = path
        self._rollout = f"rollout{suffix}.json"
        # Lists and digests of files by what they looked like: a file of 150 MB is read once.
        self._known: dict[tuple[str, int, int], KeptRelease] = {}
        self._digests: dict[tuple[str, int, int], str] = {}

    def list_releases(self) -> list[KeptRelease]:
        """List the files, newest first."""
        try:
            paths = sorted(self._path.glob(f"*{_ENDING}"))[:_MOST_FILES]
        except OSError:
            return []
        known = {}
        for path in paths:
            try:
                mark = _mark_of(path)
            except OSError:
                continue
            known[mark] = self._known.get(mark) or _read_release(path, mark)
        self._known = known
        # Of two files of one release only one can be handed out.
        seen: set[tuple[str, str]] = set()
        kept = []
        for release in sorted(known.values(), key=lambda one: -one.changed_us):
            if not release.problem and (release.version, release.site) in seen:
                release = release._replace(problem="another file holds the same release")
            seen.add((release.version, release.site))
            kept.append(release)
        return kept

    def find_release(self, version: str, site: str) -> KeptRelease | None:
        """Find what a site's gateway is offered: its own before the one for all."""
        fitting = [
            release
            for release in self.list_releases()
            if not release.problem and release.version == version and release.site in ("", site)
        ]
        return max(fitting, key=lambda release: release.site, default=None)

    def digest_of(self, release: KeptRelease) -> str:
        """Give the SHA-256 of a file.

        Raises:
            OSError: it is gone.

        """
        path = self._path / release.name
        mark = _mark_of(path)
        if mark not in self._digests:
            with path.open("rb") as file:
                self._digests[mark] = hashlib.file_digest(file, "sha256").hexdigest()
        return self._digests[mark]

    def read_piece(self, version: str, site: str, at: int) -> ReleasePiece:
        """Give the bytes of a release from ``at`` on; the answer says why if there are none."""
        release = self.find_release(version, site)
        if release is None:
            return ReleasePiece(version=version, at=at, refused="the hub has it no longer")
        if at >= release.size:
            return ReleasePiece(version=version, at=at, refused="it is not as long as that")
        try:
            with (self._path / release.name).open("rb") as file:
                data = os.pread(file.fileno(), PIECE, at)
        except OSError as error:
            return ReleasePiece(version=version, at=at, refused=f"it cannot be read: {error}")
        return ReleasePiece(version=version, at=at, check=crc32(data), data=data)

    def read_rollout(self) -> Rollout | None:
        """Read how the last rollout stood; none: there was none.

        Raises:
            OSError: it cannot be read.
            msgspec.DecodeError: it is damaged.

        """
        try:
            with (self._path / self._rollout).open("rb") as file:
                return msgspec.json.decode(file.read(_MOST_ROLLOUT), type=Rollout)
        except FileNotFoundError:
            return None

    def write_rollout(self, rollout: Rollout) -> None:
        """Write how it stands, whole.

        Raises:
            OSError: it cannot be written.

        """
        self._path.mkdir(mode=0o700, exist_ok=True)
        beside = self._path / f".{self._rollout}"
        with beside.open("wb") as file:
            file.write(msgspec.json.encode(rollout))
            file.flush()
            os.fsync(file.fileno())
        beside.replace(self._path / self._rollout)


def _mark_of(path: Path) -> tuple[str, int, int]:
    found = path.stat()
    return path.name, found.st_size, found.st_mtime_ns


def _read_release(path: Path, mark: tuple[str, int, int]) -> KeptRelease:
    name, size, changed_ns = mark
    version, site, problem = "", "", ""
    try:
        manifest = read_unproven(path)
        version, site = manifest.version, manifest.site
    except UpdateError as error:
        problem = str(error)[:500]
    return KeptRelease(name[:200], version, site, size, changed_ns // 1000, problem)
