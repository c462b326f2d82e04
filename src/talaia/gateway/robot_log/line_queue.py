"""Lines of a robot's log that the hub does not have yet: numbered, and bounded in bytes. Pure.

Lines of former runs of the gateway stand before those of this one, under the names of their runs.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.wire.frames import LogLine

__all__ = ["MOST_BYTES", "SEGMENT_BYTES", "LineQueue", "WaitingLine"]

# About twenty thousand lines of 200 characters: so much is held in memory and on disk.
MOST_BYTES = 4 * 1024 * 1024
# Of one file; it goes when all of its lines have gone.
SEGMENT_BYTES = 64 * 1024
# Of one message to the hub: a driving frame never waits behind more.
_BATCH_BYTES, _BATCH_LINES = 16 * 1024, 100


class WaitingLine(NamedTuple):
    """A line with its place.

    Attributes:
        segment: number of the first line of the file it lies in.
        size: bytes that it is counted for.

    """

    boot: str
    number: int
    segment: int
    size: int
    line: LogLine


class LineQueue:
    """Lines in the order in which they came.

    Attributes:
        dropped: so many lines went for want of room since that was asked last.
        dropped_us: when the newest of them was said.

    """

    def __init__(
        self, boot: str, left: Iterable[WaitingLine] = (), most_bytes: int = MOST_BYTES
    ) -> None:
        """Number lines of this run, ``boot``; ``left`` are those of former ones."""
        self._boot = boot
        self._waiting = deque(left)
        self._bytes = sum(one.size for one in self._waiting)
        self._most_bytes = most_bytes
        self._next = self._segment = self._segment_bytes = 0
        self.dropped = self.dropped_us = 0

    def __len__(self) -> int:
        """Give how many wait."""
        return len(self._waiting)

    def add_line(self, line: LogLine) -> WaitingLine:
        """Number a line; where there is no room, the oldest file goes for it, and is counted."""
        # What it takes is nearly all text; the rest is about the same for each.
        size = 100 + len(line.text) + len(line.file) + len(line.function) + len(line.node)
        if self._segment_bytes >= SEGMENT_BYTES:
            self._segment, self._segment_bytes = self._next, 0
        waiting = WaitingLine(self._boot, self._next, self._segment, size, line)
        self._next += 1
        self._segment_bytes += size
        self._waiting.append(waiting)
        self._bytes += size
        while self._bytes > self._most_bytes and self._drop_oldest():
            pass
        return waiting

    def next_batch(self) -> list[WaitingLine]:
        """Give the oldest lines of one run, as many as fit one message; they stay."""
        batch: list[WaitingLine] = []
        size = 0
        for one in self._waiting:
            if batch and (
                one.boot != batch[0].boot
                # A damaged file may lack lines.
                or one.number != batch[-1].number + 1
                or size + one.size > _BATCH_BYTES
                or len(batch) >= _BATCH_LINES
            ):
                break
            batch.append(one)
            size += one.size
        return batch

    def acknowledge(self, boot: str, below: int) -> None:
        """Forget lines of a run that the hub has."""
        while self._waiting and self._waiting[0].boot == boot and self._waiting[0].number < below:
            self._bytes -= self._waiting.popleft().size

    def segments(self) -> set[tuple[str, int]]:
        """Name the files that are still needed, by run and first line."""
        return {(one.boot, one.segment) for one in self._waiting}

    def collect_dropped(self) -> tuple[int, int]:
        """Give how many lines went for want of room since the last call, and when the last was."""
        dropped, self.dropped = self.dropped, 0
        return dropped, self.dropped_us

    def _drop_oldest(self) -> bool:
        """Let the oldest file go; False: there is only the one that is written to."""
        oldest = self._waiting[0]
        if (oldest.boot, oldest.segment) == (self._boot, self._segment):
            return False
        while (self._waiting[0].boot, self._waiting[0].segment) == (oldest.boot, oldest.segment):
            gone = self._waiting.popleft()
            self._bytes -= gone.size
            # What stood for others stands for them all.
            self.dropped += gone.line.left_out or 1
            self.dropped_us = max(self.dropped_us, gone.line.time_us)
        return True
