"""How large the spool lets its files grow, and what it keeps in memory instead."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["USUAL", "SpoolSizes"]


class SpoolSizes(NamedTuple):
    """Sizes in bytes.

    Attributes:
        segment: a segment that is larger is closed; the oldest segment is what gives way.
        trim: of a segment that is acknowledged to its end, so much may stay on disk.
        memory: so much waits in memory while the disk takes nothing.

    """

    # Small enough to be packed in memory and to be dropped without losing much at once.
    segment: int = 4 * 1024 * 1024
    # Emptied only above this, so that a hub that keeps up does not cost a call for each batch.
    trim: int = 512 * 1024
    memory: int = 4 * 1024 * 1024


USUAL = SpoolSizes()
