"""Faults and foreign hands, told to a simulated observatory by a named pipe, a line each.

    weather rain              a fault, as ``observatory fault`` has it
    dome do open              what a person on site does who asks no gateway
    pdu do outlet1 off

It costs no process and no search for nodes, so that thousands of trials are quick. Standard
library only: both ROS shells use it.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from talaia.sim.observatory.models.ticket import Ticket

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.sim.observatory.servers.base import Server

__all__ = ["ControlPipe", "act_on"]


class ControlPipe:
    """Lines from a named pipe, without waiting for any."""

    def __init__(self, path: Path | None) -> None:
        """Open the pipe; it is made where there is none. Without a path nothing ever comes."""
        # The beginning of a line whose end has not come yet.
        self._rest = b""
        # -1 where there is no pipe.
        self._file = -1
        if path is not None:
            if not path.exists():
                os.mkfifo(path)
            # For writing as well: so it never ends when a writer goes.
            self._file = os.open(path, os.O_RDWR | os.O_NONBLOCK)

    def read_orders(self) -> list[tuple[str, str]]:
        """Give the whole lines that have come: device, and the rest of the line."""
        if self._file < 0:
            return []
        try:
            self._rest += os.read(self._file, 65536)
        # Nothing has come.
        except BlockingIOError:
            return []
        *lines, self._rest = self._rest.split(b"\n")
        found = [line.decode().strip().partition(" ") for line in lines]
        return [(device, rest) for device, _, rest in found if device]

    def close(self) -> None:
        """Close the pipe."""
        if self._file >= 0:
            os.close(self._file)


def act_on(server: Server, words: str) -> Ticket | None:
    """Do what a line says behind ``do``, none where it says a fault."""
    first, *rest = words.split()
    if first != "do" or not rest:
        return None
    name, *values = rest
    if name in server.triggers:
        return server.triggers[name]()
    if name in server.switches:
        return server.switches[name](values == ["on"])
    if name in server.asks:
        ask = server.asks[name]
        return ask.act(**dict(zip(ask.arguments, map(float, values), strict=False)))
    return Ticket.refused(f"{server.name}: there is no action {name!r}")
