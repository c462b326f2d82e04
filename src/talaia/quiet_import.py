"""Imports of a whole program without the garbage collector, which finds nothing in them."""

from __future__ import annotations

import contextlib
import gc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["quiet_imports"]


@contextlib.contextmanager
def quiet_imports() -> Iterator[None]:
    """Import within it. To look for garbage is a fifth of the time that a hub takes to import.

    In a process that is a program's own (which has frozen what it has already), what is imported
    stays until it ends, and no later collection goes through it.
    """
    collecting, own = gc.isenabled(), gc.get_freeze_count() > 0
    gc.disable()
    try:
        yield
    finally:
        if own:
            gc.freeze()
        # Left off where a caller had it off.
        if collecting:
            gc.enable()
