"""A file with a key: read, or made whole and readable by its owner only."""

from __future__ import annotations

import contextlib
import os
import secrets
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["read_or_make_key"]


def read_or_make_key(path: Path, key: bytes) -> bytes:
    """Give the key in a file; where there is none, ``key``, which is put there first.

    Raises:
        OSError: it cannot be read or made.

    """
    with contextlib.suppress(FileNotFoundError):
        return path.read_bytes()
    # Written aside and linked: of two that start at once one wins, and no half key is ever seen.
    # Named by chance, so that two do not write the same one: hubs in containers share a folder and
    # have the same process numbers.
    fresh = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(key)
        # On the disk before it has its name: after a power cut there is a whole key, or none.
        file.flush()
        os.fsync(file.fileno())
    try:
        # Unlike a rename, a link replaces nothing.
        os.link(fresh, path)
    except FileExistsError:
        return path.read_bytes()
    finally:
        fresh.unlink()
    return key
