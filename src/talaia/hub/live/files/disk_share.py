"""Whose files may have the last of the disk: no site fills it, so that the others' still come."""

from __future__ import annotations

import asyncio
import shutil
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

__all__ = ["DiskShare", "DiskUse", "may_take"]

# So much of the disk (of 1) is for sites that hold less than their share.
_LAST_PART = 0.1


class DiskUse(NamedTuple):
    """How full a disk is (bytes); ``held`` is by the site that asks, of so many sites."""

    total: int
    free: int
    held: int
    sites: int


def may_take(use: DiskUse, size: int) -> bool:
    """Tell whether a site may have so many bytes more."""
    if use.free - size >= use.total * _LAST_PART:
        return True
    return use.held + size <= use.total / max(1, use.sites)


class DiskShare:
    """Asks the disk of the archive, and what of it a site has."""

    def __init__(
        self, folder: Path, *, held: Callable[[str], Awaitable[int]], sites: Callable[[], int]
    ) -> None:
        """Look at the disk of ``folder``; a site holds ``held`` bytes, and there are ``sites``."""
        self._folder = folder
        self._held = held
        self._sites = sites

    async def may_take(self, site: str, size: int) -> bool:
        """See the function of that name."""
        disk = await asyncio.to_thread(shutil.disk_usage, self._folder)
        use = DiskUse(disk.total, disk.free, held=0, sites=self._sites())
        # The database is asked only where it matters.
        if may_take(use._replace(held=disk.total), size):
            return True
        return may_take(use._replace(held=await self._held(site)), size)
