"""What can go wrong with a picture.

TalaiaError
└── ImagingError
    └── UnreadableFrame
"""

from __future__ import annotations

from talaia.errors import TalaiaError

__all__ = ["ImagingError", "UnreadableFrame"]


class ImagingError(TalaiaError):
    """Something about a picture of the sky is wrong."""


class UnreadableFrame(ImagingError):
    """A file is no picture that can be read here."""
