"""Imports of a whole program without the garbage collector, which finds nothing in them."""

from __future__ import annotations

import contextlib
import gc
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["own_process", "quiet_imports"]

# That this process is a program's own. Asked of the collector it would take long: it counts what is
# frozen one by one, which in a test's process is a million.
_owned = False


def own_process() -> None:
    """Say that this process is a program's own: what it imports stays until it ends.

    What is there already is left out of all collections, the one at the end included.
    """
    global _owned
    _owned = True
    gc.freeze()


@contextlib.contextmanager
def quiet_imports() -> Iterator[None]:
    """Import within it. To look for garbage is a fifth of the time that a hub takes to import.

    In a process that is a program's own (see `own_process`) no later collection goes through what
    is imported.
    """
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if _owned:
            gc.freeze()
        # Left off where a caller had it off.
        if collecting:
            gc.enable()
