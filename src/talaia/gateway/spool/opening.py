"""What an earlier run of the gateway left on disk, taken up again."""

from __future__ import annotations

import contextlib
import logging
import os
from typing import TYPE_CHECKING

from talaia.gateway.spool.files import boot_of, ranges_of, remove_file, scan_segment, set_aside
from talaia.wire.frames import SampleGap

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.spool.files import Segment
    from talaia.gateway.spool.gaps import SpoolGaps
    from talaia.gateway.spool.progress_mark import ProgressMark

__all__ = ["DAMAGED", "TORN", "open_folder", "take_up", "tell_torn"]

log = logging.getLogger(__name__)
# Words for people: the hub shows them beside the gap in the history.
DAMAGED = "damaged on disk"
TORN = "the end of what waited on the gateway's disk is missing"


def open_folder(folder: Path, gaps: SpoolGaps, former: ProgressMark | None) -> list[Segment]:
    """Take up what an earlier run left, as far as the disk gives it; never raises for a disk.

    Args:
        folder: where the segments are; it is made.
        gaps: take what is lost.
        former: what the run before left of itself, if there was one.

    """
    found: list[Segment] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = take_up(folder, gaps, former)
    except OSError as error:
        # What a robot says waits in memory then; nothing that guards it waits for a disk.
        log.warning("the spool %s cannot be used now: %s", folder, error)
    # After the segments are read: what they hold is not torn.
    if former is not None:
        tell_torn(former, found, gaps)
    return found


def take_up(folder: Path, gaps: SpoolGaps, former: ProgressMark | None = None) -> list[Segment]:
    """Read every segment: torn tails are cut, what is damaged is set aside or told as a gap.

    Raises:
        OSError: the folder cannot be used.

    """
    # A rewriting (segments, gaps) that a crash cut short; the old file is still in its place.
    for half in folder.glob("*.new"):
        remove_file(half)
    # By boot: where its newest segment so far ends, and the latest time in it (µs).
    ends: dict[str, tuple[int, int]] = {}
    found: list[Segment] = []
    # Names are numbers of ten digits, so their order is that in which they were written.
    for path in sorted(folder.glob("*.seg")):
        segment = _read_segment(path, gaps, former)
        if segment is None:
            continue
        # Segments of one boot follow each other; the oldest may be gone, none between.
        # The first of a boot is compared with itself: what was before it may have been
        # acknowledged.
        end, end_us = ends.get(segment.head.boot, (segment.first, 0))
        if segment.first > end:
            gaps.add_unknown(
                SampleGap(
                    boot=segment.head.boot,
                    first=end,
                    last=segment.first - 1,
                    from_us=end_us,
                    to_us=segment.from_us,
                    reason=DAMAGED,
                )
            )
        ends[segment.head.boot] = (segment.end, segment.to_us)
        found.append(segment)
    return found


def tell_torn(former: ProgressMark, segments: list[Segment], gaps: SpoolGaps) -> None:
    """Tell what the run before had heard, and the hub has not stored, and is nowhere now."""
    mine = [segment for segment in segments if segment.head.boot == former.boot]
    # The mark ran ahead of the disk: what it counts beyond this was in memory, or torn off.
    first = max([former.acked, *(segment.end for segment in mine)])
    if first < former.end:
        from_us = max((gap.to_us for gap in mine), default=former.began_us)
        gaps.add_unknown(
            SampleGap(
                boot=former.boot,
                first=first,
                last=former.end - 1,
                # The wall clock may have been set back in that run; a span never ends before it
                # begins.
                from_us=min(from_us, former.heard_us),
                to_us=former.heard_us,
                reason=TORN,
            )
        )


def _read_segment(path: Path, gaps: SpoolGaps, former: ProgressMark | None) -> Segment | None:
    try:
        data = path.read_bytes()
    except OSError as error:
        # Not fatal: one bad file must not keep the gateway from the others.
        log.warning("%s cannot be read and is set aside: %s", path, error)
        _set_aside(path)
        return None
    scanned = scan_segment(path, data)
    if scanned is None:
        _set_damaged_aside(path, data, gaps)
        return None
    segment, holes, whole = scanned
    # Behind it is half a record, which a crash or a power cut left.
    if whole < len(data):
        # On a disk that takes nothing it stays; readers go by the size that is known here.
        with contextlib.suppress(OSError):
            os.truncate(path, whole)
    # What the hub has acknowledged past needs no word: a gap it was told of has a number, too.
    mine = former is not None and former.boot == segment.head.boot
    # Only the run before has left word of how far the hub had acknowledged.
    acked = former.acked if former is not None and mine else 0
    for hole, last, from_us, to_us in holes:
        first = max(hole, acked)
        if first > last:
            continue
        gaps.add_unknown(
            SampleGap(
                boot=segment.head.boot,
                first=first,
                last=last,
                from_us=from_us,
                to_us=to_us,
                reason=DAMAGED,
            )
        )
    # A head and nothing behind it: all was acknowledged, or nothing was heard.
    if segment.first < 0:
        remove_file(path)
        return None
    return segment


def _set_damaged_aside(path: Path, data: bytes, gaps: SpoolGaps) -> None:
    """Set a segment aside whose head cannot be read, and tell what was in it."""
    # Made and not written, or taken by a power cut; what is missing the mark tells of.
    if not data:
        remove_file(path)
        return
    log.warning("%s is damaged and is set aside", path)
    for record in ranges_of(data):
        # A record that cannot be read does not say whose it is; no gap can be told of it.
        boot = boot_of(record)
        if boot:
            gaps.add_unknown(
                SampleGap(
                    boot=boot,
                    first=record.first,
                    last=record.end - 1,
                    from_us=record.from_us,
                    to_us=record.to_us,
                    reason=DAMAGED,
                )
            )
    _set_aside(path)


def _set_aside(path: Path) -> None:
    try:
        set_aside(path)
    except OSError as error:
        log.warning("%s cannot be set aside: %s", path, error)
