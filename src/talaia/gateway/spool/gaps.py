"""Samples that are gone for good: which, when and why, until the hub has written it down too."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from talaia.gateway.persistence import write_whole
from talaia.wire.frames import SampleGap

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

__all__ = ["DroppedSamples", "SpoolGaps"]

log = logging.getLogger(__name__)


class SpoolGaps:
    """A short list, kept on disk whole."""

    def __init__(self, path: Path) -> None:
        """Read what an earlier run left. A damaged file is left aside: it holds no samples."""
        self._path = path  # `gaps.json`; replaced whole at each change.
        self._gaps: list[SampleGap] = []  # Until the hub has acknowledged past them; in no order.
        # They differ from the file; set by every change, cleared when it is written.
        self._dirty = False
        try:
            self._gaps = msgspec.json.decode(path.read_bytes(), type=list[SampleGap])
        # The usual first start; nothing to say.
        except FileNotFoundError:
            return
        except (OSError, msgspec.DecodeError) as error:
            log.warning("%s is damaged and is left aside: %s", path, error)

    def list_gaps(self) -> list[SampleGap]:
        """Give them."""
        return list(self._gaps)

    def add_gap(self, lost: SampleGap) -> None:
        """Record one; it grows a gap that it follows for the same reason."""
        log.warning(
            "samples %d to %d of %s are lost: %s", lost.first, lost.last, lost.boot, lost.reason
        )
        self._dirty = True
        for index, gap in enumerate(self._gaps):
            # The same gap told again, as after damage that is read twice: the newer words count.
            if (gap.boot, gap.first, gap.last) == (lost.boot, lost.first, lost.last):
                del self._gaps[index]
                break
            # A robot that is cut off for hours is one gap, not one for each batch.
            follows = gap.boot == lost.boot and gap.last + 1 == lost.first
            if follows and gap.reason == lost.reason:
                lost = replace(
                    lost,
                    first=gap.first,
                    from_us=min(gap.from_us, lost.from_us),
                    to_us=max(gap.to_us, lost.to_us),
                )
                del self._gaps[index]
                break
        self._gaps.append(lost)

    def add_unknown(self, lost: SampleGap) -> None:
        """Record what of a range is in no gap yet."""
        first = lost.first
        # By rising number, so that what is between two known gaps is found in one walk.
        for gap in sorted(self._gaps, key=lambda known: known.first):
            if gap.boot == lost.boot and gap.last >= first and gap.first <= lost.last:
                if gap.first > first:
                    self.add_gap(replace(lost, first=first, last=gap.first - 1))
                first = max(first, gap.last + 1)
        if first <= lost.last:
            self.add_gap(replace(lost, first=first))

    def forget_acked(self, acked: Mapping[str, int]) -> None:
        """Drop those that the hub has acknowledged past, by boot."""
        kept = [gap for gap in self._gaps if gap.last >= acked.get(gap.boot, 0)]
        if len(kept) != len(self._gaps):
            self._gaps, self._dirty = kept, True

    @property
    def dirty(self) -> bool:
        """Whether they are not on disk as they are here."""
        return self._dirty

    def write_gaps(self) -> None:
        """Write them if they changed. While the disk is full they stay in memory."""
        if not self._dirty:
            return
        try:
            write_whole(self._path, msgspec.json.encode(self._gaps))
            self._dirty = False
        # Tried again with the next `sync`: they are kept in memory meanwhile.
        except OSError as error:
            log.debug("%s: %s", self._path, error)


class DroppedSamples:
    """Samples of this boot that are here no more since the hub has them: which, and when. Pure.

    Asked only when a hub comes back with an older database than it had. Bounded: beyond
    `MOST` stretches, neighbours become one.
    """

    # Bounds the memory: only a hub that lost its database ever asks.
    MOST = 4096

    def __init__(self) -> None:
        """Begin with none."""
        # First, end, earliest and latest time (µs); rising, and never overlapping.
        self._spans: list[tuple[int, int, int, int]] = []

    def add_range(self, first: int, end: int, from_us: int, to_us: int) -> None:
        """Note samples ``first`` to ``end`` - 1, in rising order; none for a negative first."""
        if not 0 <= first < end:
            return
        self._spans.append((first, end, from_us, to_us))
        if len(self._spans) > self.MOST:
            # Halved by joining pairs: coarser times, but no number is forgotten.
            pairs = zip(self._spans[::2], self._spans[1::2], strict=False)
            joined = [(a[0], b[1], min(a[2], b[2]), max(a[3], b[3])) for a, b in pairs]
            # With an odd number of spans the last has no neighbour and stays as it is.
            self._spans = joined + self._spans[len(joined) * 2 :]

    def dropped_since(self, below: int) -> list[tuple[int, int, int, int]]:
        """Give what is gone from sample ``below`` on."""
        return [
            (max(first, below), end, from_us, to_us)
            for first, end, from_us, to_us in self._spans
            if end > below
        ]
