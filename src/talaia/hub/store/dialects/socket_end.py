"""The end of a driver's socket under a thread that reads from it."""

from __future__ import annotations

import contextlib
import socket

__all__ = ["shut_socket"]


def shut_socket(opened: object) -> None:
    """Shut a socket, if it is one; whoever reads from it or writes to it fails."""
    if isinstance(opened, socket.socket):
        # It may be closed already.
        with contextlib.suppress(OSError):
            opened.shutdown(socket.SHUT_RDWR)
