"""Segment files: what is known of one, and how one from an earlier run is read back."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.spool.segment import Kind, Record, records

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["Head", "Segment", "scan", "write_all"]


class Head(msgspec.Struct, frozen=True):
    """What all records of a segment share."""

    boot: str
    catalogue: str
    addresses: list[str]


@dataclass(slots=True)
class Segment:
    """A file and the range it holds. ``turn`` counts how often it was emptied and used again."""

    number: int
    path: Path
    head: Head
    size: int
    start: int
    first: int = -1
    end: int = 0
    from_us: int = 0
    to_us: int = 0
    turn: int = 0

    def add(self, record: Record) -> None:
        """Count a record in."""
        if self.first < 0:
            self.first, self.from_us, self.to_us = record.first, record.from_us, record.to_us
        self.end = max(self.end, record.end)
        self.from_us = min(self.from_us, record.from_us)
        self.to_us = max(self.to_us, record.to_us)


def scan(path: Path, data: bytes) -> tuple[Segment, list[tuple[int, int, int, int]], int] | None:
    """Read a segment from an earlier run: its range, its holes, and where whole data end."""
    segment: Segment | None = None
    holes: list[tuple[int, int, int, int]] = []
    whole = 0
    try:
        number = int(path.stem)
    except ValueError:
        return None
    for end, record in records(data):
        if record.kind == Kind.SEGMENT:
            try:
                head = msgspec.msgpack.decode(record.body, type=Head)
            except msgspec.DecodeError:
                return None
            segment = Segment(number, path, head, end, end)
        elif segment is not None:
            if segment.first >= 0 and record.first > segment.end:
                holes.append((segment.end, record.first - 1, segment.to_us, record.from_us))
            segment.add(record)
        whole = end
    if segment is None:
        return None
    segment.size = whole
    return segment, holes, whole


def write_all(file: int, data: bytes) -> None:
    """Write all of it, however often the system takes only a part."""
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
