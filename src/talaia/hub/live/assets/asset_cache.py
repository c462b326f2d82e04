"""Files of robots that gateways have handed over, by their content, on the hub's disk. Blocks."""

from __future__ import annotations

import hashlib
import os
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["AssetCache"]

# Of one site: bytes, and names of files.
_MOST_BYTES, _MOST_NAMES = 512 * 1024 * 1024, 5_000
_DIGEST = re.compile(r"[0-9a-f]{64}", re.ASCII)


class AssetCache:
    """A folder for each site: in ``files`` each content once, in ``names`` which name has which.

    Each site for itself: no gateway pushes another's files out, and none learns by a digest what
    another has.
    """

    def __init__(self, folder: Path, most_bytes: int = _MOST_BYTES) -> None:
        """Keep in ``folder``; of a site above ``most_bytes`` go what was read longest ago."""
        self._folder = folder
        self._most_bytes = most_bytes

    def has_file(self, site: str, digest: str) -> bool:
        """Tell whether a content is there."""
        return self._file(site, digest).is_file()

    def find_digest(self, site: str, uri: str) -> str:
        """Give the digest of the content that a name had last; empty: it is not here."""
        try:
            digest = self._name(site, uri).read_text("ascii")
        except (OSError, ValueError):
            return ""
        return digest if _DIGEST.fullmatch(digest) and self.has_file(site, digest) else ""

    def read_file(self, site: str, digest: str) -> bytes | None:
        """Read a content; None: it is not here, or not what it was."""
        path = self._file(site, digest)
        try:
            data = path.read_bytes()
            if hashlib.sha256(data).hexdigest() != digest:
                path.unlink(missing_ok=True)
                return None
            # What is used stays.
            os.utime(path)
        except OSError:
            return None
        return data

    def keep_file(self, site: str, digest: str, source: Path) -> None:
        """Move a file here, whose content was checked; the oldest give way.

        Raises:
            OSError: the disk does not take it.

        """
        path = self._file(site, digest)
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        source.replace(path)
        os.utime(path)
        _drop_oldest(path.parent, keep=path, most_bytes=self._most_bytes)

    def name_file(self, site: str, uri: str, digest: str) -> None:
        """Write down which content a name has now.

        Raises:
            OSError: the disk does not take it.

        """
        path = self._name(site, uri)
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        part = path.with_suffix(".part")
        part.write_text(digest, "ascii")
        part.replace(path)
        _drop_oldest(path.parent, keep=path, most_files=_MOST_NAMES)

    def _file(self, site: str, digest: str) -> Path:
        return self._folder / site / "files" / digest

    def _name(self, site: str, uri: str) -> Path:
        return self._folder / site / "names" / hashlib.sha256(uri.encode()).hexdigest()


def _drop_oldest(
    folder: Path, *, keep: Path, most_bytes: int = 2**62, most_files: int = 2**62
) -> None:
    """Remove what was used longest ago, until the rest is within both; ``keep`` stays."""
    with os.scandir(folder) as entries:
        stats = [(entry.path, entry.stat()) for entry in entries]
    found = sorted((about.st_mtime_ns, about.st_size, path) for path, about in stats)
    total, count = sum(size for _, size, _ in found), len(found)
    for _, size, path in found:
        if total <= most_bytes and count <= most_files:
            return
        if path != str(keep):
            os.unlink(path)
            total, count = total - size, count - 1
