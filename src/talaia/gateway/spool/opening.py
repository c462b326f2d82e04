"""What an earlier run of the gateway left on disk, taken up again."""

from __future__ import annotations

import logging
import os
from typing import TYPE_CHECKING

from talaia.gateway.spool.files import boot_of, ranges_of, scan, set_aside

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.spool.files import Segment
    from talaia.gateway.spool.gaps import Gaps

__all__ = ["DAMAGED", "take_up"]

log = logging.getLogger(__name__)
DAMAGED = "damaged on disk"


def take_up(folder: Path, gaps: Gaps) -> list[Segment]:
    """Read every segment: torn tails are cut, what is damaged is set aside or told as a gap.

    Raises:
        OSError: the folder cannot be used.

    """
    for half in folder.glob("*.new"):
        half.unlink()
    ends: dict[str, tuple[int, int]] = {}
    found: list[Segment] = []
    for path in sorted(folder.glob("*.seg")):
        segment = _read(path, gaps)
        if segment is None:
            continue
        # Segments of one boot follow each other; the oldest may be gone, none between.
        end, end_us = ends.get(segment.head.boot, (segment.first, 0))
        if segment.first > end:
            lost = (end, segment.first - 1, end_us, segment.from_us)
            gaps.add_unknown(segment.head.boot, *lost, DAMAGED)
        ends[segment.head.boot] = (segment.end, segment.to_us)
        found.append(segment)
    return found


def _read(path: Path, gaps: Gaps) -> Segment | None:
    try:
        data = path.read_bytes()
    except OSError as error:
        log.warning("%s cannot be read and is set aside: %s", path, error)
        set_aside(path)
        return None
    scanned = scan(path, data)
    if scanned is None:
        _leave(path, data, gaps)
        return None
    segment, holes, whole = scanned
    if whole < len(data):
        os.truncate(path, whole)
    for first, last, from_us, to_us in holes:
        gaps.add_unknown(segment.head.boot, first, last, from_us, to_us, DAMAGED)
    if segment.first < 0:
        path.unlink()
        return None
    return segment


def _leave(path: Path, data: bytes, gaps: Gaps) -> None:
    """Set a segment aside whose head cannot be read, and tell what was in it."""
    if not data:
        path.unlink()
        return
    log.warning("%s is damaged and is set aside", path)
    for record in ranges_of(data):
        boot = boot_of(record)
        if boot:
            gaps.add_unknown(
                boot, record.first, record.end - 1, record.from_us, record.to_us, DAMAGED
            )
    set_aside(path)
