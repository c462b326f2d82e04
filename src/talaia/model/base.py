"""The base of every shape of the description."""

from __future__ import annotations

import msgspec

__all__ = ["Shape"]


class Shape(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Immutable, and a key we do not know is an error, not a silence."""
