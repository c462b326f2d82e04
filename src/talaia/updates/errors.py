"""What is wrong with an update."""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["UpdateError", "UpdateRefused"]


class UpdateError(TalaiaError):
    """An update cannot be made; what ran goes on."""


class UpdateRefused(UpdateError):
    """An update is not from whom it should be, not whole, or not for this gateway."""
