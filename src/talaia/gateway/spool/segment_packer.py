"""Packs a segment that is full while the hub is away."""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from talaia.gateway.persistence import write_whole
from talaia.gateway.spool.files import remove_file
from talaia.gateway.spool.packing import pack_records
from talaia.gateway.spool.segment import pack_record, read_records

if TYPE_CHECKING:
    from talaia.gateway.spool.files import Segment

__all__ = ["pack_segment"]

log = logging.getLogger(__name__)


def pack_segment(segment: Segment) -> None:
    """Write a closed segment anew, smaller; a crash leaves the old or the new.

    Either is forced to disk: nobody else forces a segment that is closed.
    """
    try:
        # Into memory whole: a segment is bounded by its size, and only one is packed at a time.
        kept = [record for _, record in read_records(segment.path.read_bytes())]
        # The head goes first and unpacked: without it nobody knows whose the rest is.
        whole = b"".join(pack_record(record) for record in [kept[0], *pack_records(kept[1:])])
        write_whole(segment.path, whole)
    # IndexError: not even the head could be read. Packing only saves room, so nothing is lost.
    except (OSError, IndexError) as error:
        log.debug("%s stays as it is: %s", segment.path, error)
        remove_file(segment.path.with_name(segment.path.name + ".new"))
        _force_to_disk(segment)
        return
    # After the file is in its place, on the same thread as all readers.
    segment.size = len(whole)
    # Offsets that readers hold were of the old file.
    segment.turn += 1


def _force_to_disk(segment: Segment) -> None:
    try:
        # Opened anew, as its writer has closed it: what is forced is the file, whoever wrote it.
        file = os.open(segment.path, os.O_RDONLY | os.O_CLOEXEC)
        try:
            os.fdatasync(file)
        finally:
            os.close(file)
    # As in `SegmentWriter.sync_file`: the disk is not asked again.
    except OSError as error:
        log.warning("%s cannot be forced to disk: %s", segment.path, error)
