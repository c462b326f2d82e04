"""The file of the segment that is being written."""

from __future__ import annotations

import contextlib
import logging
import os
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.spool.files import remove_file, write_all
from talaia.gateway.spool.segment import RecordKind, SampleRecord, pack_record

if TYPE_CHECKING:
    from talaia.gateway.spool.disk_room import DiskRoom
    from talaia.gateway.spool.files import Segment

__all__ = ["SegmentWriter"]

log = logging.getLogger(__name__)


class SegmentWriter:
    """Writes whole records: up to ``segment.size`` there is never half of one.

    While the disk takes nothing the file is not there; `open_file` is tried again with each
    record.
    """

    def __init__(self, room: DiskRoom) -> None:
        """Write where ``room`` is; `begin_segment` comes first."""
        # Is told why the disk did not take something.
        self._room = room
        # Negative while the disk has no room for the file.
        self._file = -1
        # Something was written since it was forced to disk.
        self._dirty = False

    @property
    def is_open(self) -> bool:
        """Whether the disk has taken the file."""
        return self._file >= 0

    def begin_segment(self) -> None:
        """Close the file of the segment before; the next one is not there yet."""
        # Not forced to disk here: `pack_segment` forces a closed segment that the hub has not.
        if self._file >= 0:
            os.close(self._file)
        self._file = -1

    def open_file(self, segment: Segment) -> bool:
        """Make the file of a segment, with its head in it; tell whether the disk took it."""
        data = pack_record(
            SampleRecord(0, 0, 0, 0, msgspec.msgpack.encode(segment.head), RecordKind.SEGMENT)
        )
        file = -1
        try:
            # Made here: a disk that takes something again may have come up without the folder.
            segment.path.parent.mkdir(parents=True, exist_ok=True)
            # Read by its owner only: what a robot says is nobody else's on this machine.
            file = os.open(segment.path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
            write_all(file, data)
        except OSError as error:
            self._room.see_failure(error)
            if file >= 0:
                os.close(file)
                # Half a head is no segment; without the file the next try begins anew.
                remove_file(segment.path)
            return False
        self._file = file
        segment.size = segment.start = len(data)
        return True

    def write_record(self, segment: Segment, data: bytes) -> bool:
        """Write a record behind the others; tell whether the disk took all of it."""
        try:
            write_all(self._file, data)
        except OSError as error:
            self._room.see_failure(error)
            # Where even that fails, a later record is written over what is half there.
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, segment.size)
            os.lseek(self._file, segment.size, os.SEEK_SET)
            return False
        segment.size += len(data)
        self._dirty = True
        return True

    def empty_file(self, segment: Segment) -> bool:
        """Cut a segment off behind its head; tell whether the disk did so."""
        try:
            # The head stays: the same segment goes on behind it.
            os.ftruncate(self._file, segment.start)
        except OSError as error:
            log.debug("%s is not emptied: %s", segment.path, error)
            return False
        # Truncating does not move the place of writing; without this a hole of zeros would follow.
        os.lseek(self._file, segment.start, os.SEEK_SET)
        segment.size = segment.start
        return True

    def sync_file(self) -> None:
        """Force to disk what was written since the last time; never raises."""
        if not self._dirty or self._file < 0:
            return
        # Before it is tried: a disk that cannot is not asked again until there is more.
        self._dirty = False
        try:
            # Data and length only: nobody asks for the time of change.
            os.fdatasync(self._file)
        except OSError as error:
            log.warning("the spool cannot be forced to disk: %s", error)

    def close(self) -> None:
        """Force to disk and close.

        Raises:
            OSError: the disk does not take it.

        """
        if self._file >= 0:
            # Closed in any case: the error goes to the caller.
            try:
                os.fdatasync(self._file)
            finally:
                os.close(self._file)
