"""Keeps None, True and False alive under a Qt binding that forgets to count them."""

from __future__ import annotations

import ctypes
import sys

__all__ = ["keep_constants"]

_PLENTY = 1 << 40
_NEAR = 64


def keep_constants() -> None:
    """Give the constants so many references that no number of forgotten ones frees them.

    PySide6 6.12.0 gives back None without counting the reference (measured: one lost with each
    call). From Python 3.12 on that is right, as constants are immortal there (PEP 683). In 3.11 a
    few thousand calls would free None and end the process with ``none_dealloc``. See decision 47.
    """
    if sys.version_info >= (3, 12):
        return
    for each in (None, True, False, NotImplemented):
        count = ctypes.c_ssize_t.from_address(id(each))
        # A build of Python that keeps something else in that place is left alone.
        if abs(count.value - sys.getrefcount(each)) < _NEAR and count.value < _PLENTY:
            count.value += _PLENTY
