"""Connections whose other end is gone without a word (a cut line, a laptop switched off) end."""

from __future__ import annotations

import socket

__all__ = ["drop_dead_peers"]

# Of tcp(7): a line that says nothing is asked after so long (s), so often (s), so many times.
_IDLE_S, _EVERY_S, _TIMES = 30, 10, 3
# What was sent and is not acknowledged for so long (ms) ends the connection: the system's own
# limit is about a quarter of an hour.
_UNACKNOWLEDGED_MS = 60_000


def drop_dead_peers(listener: socket.socket) -> None:
    """Have the system end connections of ``listener`` whose other end is gone, within a minute.

    Pages and gateways have beats of their own; clients of other tools need not say anything for
    hours. Connections that are accepted have these settings of their listener.
    """
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    wanted = {
        "TCP_KEEPIDLE": _IDLE_S,
        "TCP_KEEPINTVL": _EVERY_S,
        "TCP_KEEPCNT": _TIMES,
        "TCP_USER_TIMEOUT": _UNACKNOWLEDGED_MS,
    }
    for name, value in wanted.items():
        # Some of them are Linux's only; elsewhere the system's own limits hold.
        if (option := getattr(socket, name, None)) is not None:
            listener.setsockopt(socket.IPPROTO_TCP, option, value)
