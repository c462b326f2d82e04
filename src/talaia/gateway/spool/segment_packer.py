"""Packs a segment that is full while the hub is away."""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from talaia.gateway.spool.files import unlinked
from talaia.gateway.spool.packing import packed
from talaia.gateway.spool.segment import pack_record, records

if TYPE_CHECKING:
    from talaia.gateway.spool.files import Segment

__all__ = ["pack_segment"]

log = logging.getLogger(__name__)


def pack_segment(segment: Segment) -> None:
    """Write a closed segment anew, smaller; a crash leaves the old or the new."""
    beside = segment.path.with_suffix(".new")
    try:
        kept = [record for _, record in records(segment.path.read_bytes())]
        whole = b"".join(pack_record(record) for record in [kept[0], *packed(kept[1:])])
        with beside.open("wb") as file:
            file.write(whole)
            file.flush()
            os.fdatasync(file.fileno())
        beside.replace(segment.path)
    except (OSError, IndexError) as error:
        log.debug("%s stays as it is: %s", segment.path, error)
        unlinked(beside)
        return
    segment.size = len(whole)
    segment.turn += 1
