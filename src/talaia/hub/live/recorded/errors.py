"""What can be wrong with a recording that is read at a moment."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["RecordingUnreadable"]


class RecordingUnreadable(TalaiaError):
    """A file cannot be read at a moment, and why."""
