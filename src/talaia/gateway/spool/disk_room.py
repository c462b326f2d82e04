"""Whether the disk has room for one more record, and why it did not take one."""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from talaia.gateway.persistence import NO_ROOM

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["DiskRoom"]

log = logging.getLogger(__name__)
# Of the whole disk, where that is less than what is to stay free.
MOST_SPARE = 0.05


class DiskRoom:
    """The disk that the spool is on.

    Attributes:
        full: it took nothing for want of room, so the oldest may give way. Of a disk that takes
            nothing at all nothing is dropped: that would lose what is there and make no room.

    """

    def __init__(self, folder: Path, spare: int) -> None:
        """Leave ``spare`` bytes free for what matters more."""
        # Any place on the disk will do for asking how much is free.
        self._folder = folder
        self._spare = spare  # Bytes; 0: no bound, and the disk is not asked.
        self.full = False

    def see_failure(self, error: OSError) -> None:
        """Tell a full disk, where the oldest gives way, from one that takes nothing at all."""
        # Not a warning: it comes with each record for as long as the disk is so.
        log.debug("spool: %s", error)
        self.full = error.errno in NO_ROOM

    def has_room(self, size: int) -> bool:
        """Tell whether so many bytes more leave free what is to stay free."""
        # Set before the disk is asked: too little room is a full disk, and dropping the oldest
        # helps.
        self.full = True
        if not self._spare:
            return True
        try:
            disk = os.statvfs(self._folder)
        except OSError as error:
            self.see_failure(error)
            return False
        # `f_bavail`, below: what root alone may use is no room for a gateway.
        spare = min(self._spare, disk.f_blocks * disk.f_frsize * MOST_SPARE)
        return disk.f_bavail * disk.f_frsize - size >= spare
