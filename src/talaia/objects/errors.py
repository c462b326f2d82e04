"""What can go wrong with a detector."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["DetectorError"]


class DetectorError(TalaiaError):
    """A detector's file cannot be used, or is not what its setting says."""
