"""A DDS participant number whose ports no killed process has used of late.

Fast DDS reads from a port in shared memory that is named after the participant's number. A gateway
that is killed leaves its port behind; the next one gets the same, lowest free number, removes the
dead port and makes it anew. A robot that still has the old one mapped writes into memory that
nobody reads, for one to four seconds, and repeats only with its heartbeats. Measured: the last
words before a silence came up to 22 s late in a quarter of the restarts. With another number the
robot opens a port that it has not seen, and nothing is late (20 of 20 restarts).

The number cannot be chosen through rclpy, so the discovery ports of lower numbers are held by
sockets of ours while ROS is joined; Fast DDS then takes the next one that is free.
"""

from __future__ import annotations

import contextlib
import os
import socket
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

__all__ = ["ParticipantNumber", "choose_number", "data_port", "discovery_port", "domain_of"]

_FOLDER = Path("/dev/shm")  # noqa: S108 - where Fast DDS has its ports
# Fast DDS 2 calls them fastrtps.
_NAMES = ("fastdds_port{}", "fastrtps_port{}")
# More restarts than fit into the 20 s after which a robot forgets a dead participant, and few
# enough for the first 32 numbers, which are all that is asked where multicast is off.
NUMBERS = range(16)
_LAST_PORT = 65_535


def discovery_port(domain: int, number: int) -> int:
    """Give a participant's unicast port of discovery (RTPS 2.5, 9.6.2.4: PB + DG·d + d1 + PG·p)."""
    return 7400 + 250 * domain + 10 + 2 * number


def data_port(domain: int, number: int) -> int:
    """Give a participant's unicast port for data, which names its port in shared memory."""
    return discovery_port(domain, number) + 1


def domain_of(value: str | None) -> int | None:
    """Read ``ROS_DOMAIN_ID``; None for what has no ports, which ROS itself will refuse."""
    try:
        domain = int(value or 0)
    except ValueError:
        return None
    fits = domain >= 0 and data_port(domain, NUMBERS[-1]) <= _LAST_PORT
    return domain if fits else None


def choose_number(free: Collection[int], used_s: Mapping[int, float]) -> int | None:
    """Choose a number: the lowest that nobody used, or else the one used longest ago.

    Args:
        free: numbers whose port of discovery nobody has now.
        used_s: when the ports of a number were last used (any clock, seconds), by number.

    Returns:
        One of ``free``; None if there is none.

    """
    return min(free, key=lambda number: (used_s.get(number, float("-inf")), number), default=None)


class ParticipantNumber:
    """The number of one participant, from before it joins until it leaves."""

    def __init__(self, domain: int | None, folder: Path = _FOLDER) -> None:
        """Take the domain; None does nothing at all, for other DDS than Fast DDS."""
        self._domain = domain
        self._folder = folder
        # The number that was left for ROS to take; None before `held` and when there was none.
        self.chosen: int | None = None

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold lower numbers back while ROS is joined within the block."""
        with contextlib.ExitStack() as sockets:
            if self._domain is not None:
                self._hold(self._domain, sockets)
            yield

    def mark_used(self) -> None:
        """Write the time on the port, so that whoever comes after a kill knows how fresh it is.

        Fast DDS writes through a mapping, which leaves a file's time as it was.
        """
        if self._domain is not None and self.chosen is not None:
            for path in self._paths(self._domain, self.chosen):
                with contextlib.suppress(OSError):
                    os.utime(path)

    def _hold(self, domain: int, sockets: contextlib.ExitStack) -> None:
        held: dict[int, socket.socket] = {}
        for number in NUMBERS:
            found = _bound(discovery_port(domain, number))
            if found is not None:
                held[number] = sockets.enter_context(found)
        used = {number: time for number in held if (time := self._used_s(domain, number))}
        self.chosen = choose_number(held, used)
        for number, found in held.items():
            if self.chosen is not None and number >= self.chosen:
                found.close()

    def _used_s(self, domain: int, number: int) -> float:
        """Tell when a number's port was last used (Unix time, seconds); 0 if there is none."""
        times = [0.0]
        for path in self._paths(domain, number):
            with contextlib.suppress(OSError):
                times.append(path.stat().st_mtime)
        return max(times)

    def _paths(self, domain: int, number: int) -> list[Path]:
        return [self._folder / name.format(data_port(domain, number)) for name in _NAMES]


def _bound(port: int) -> socket.socket | None:
    """Give a socket on every address of a port, or None if somebody has it on any of them."""
    found = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        found.bind(("", port))
    except OSError:
        found.close()
        return None
    return found
