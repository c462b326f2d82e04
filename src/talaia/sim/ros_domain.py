"""A ROS domain of one's own, on this machine only.

Everything ROS 2 of one domain number on a network hears each other. Two demos, or a demo and a
test, must not; and nothing of a simulator has any business outside its machine. So a number is
reserved for as long as a process lives, and ROS is told to stay on the loopback interface and in
shared memory.
"""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.sim.errors import BadDomain, NoFreeDomain

if TYPE_CHECKING:
    from types import TracebackType

__all__ = [
    "FIRST",
    "LAST",
    "Reservation",
    "domain_environment",
    "fastdds_profile",
    "reserve_domain",
]

FIRST = 1
LAST = 101
"""Above, DDS's ports reach into those Linux gives to outgoing connections; 0 is everybody's."""


@dataclass
class Reservation:
    """A domain number nobody else gets until `release`, or until this process ends."""

    domain: int
    # Of the lock file; the lock lasts for as long as it is open. -1: released.
    _file: int

    def release(self) -> None:
        """Give the number back."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def __enter__(self) -> Reservation:
        """Hold it for a block."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Release it."""
        self.release()


def reserve_domain(domain: int | None = None, *, folder: Path | None = None) -> Reservation:
    """Reserve a ROS domain.

    Args:
        domain: this one and no other, or None for the first free one.
        folder: where the lock files are; by default the user's runtime folder.

    Raises:
        BadDomain: the number is not safe to use.
        NoFreeDomain: it, or every one of them, is taken.

    """
    folder = folder or _runtime_folder()
    # Nobody else's: whoever may write here can keep every number from us.
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if domain is not None:
        _check_domain(domain)
        return _try_lock(folder, domain) or _raise_none_free(domain, domain)
    # Processes start their search apart, so that two that start together seldom meet.
    span = LAST - FIRST + 1
    start = os.getpid() % span
    for step in range(span):
        candidate = FIRST + (start + step) % span
        taken = _try_lock(folder, candidate)
        if taken is not None:
            return taken
    return _raise_none_free(FIRST, LAST)


def domain_environment(domain: int) -> dict[str, str]:
    """Give the variables that put a process into a domain and keep it on this machine.

    Raises:
        BadDomain: the number is not safe to use.

    """
    _check_domain(domain)
    return {
        "ROS_DOMAIN_ID": str(domain),
        # Known from ROS 2 Iron on; the profile below holds everywhere.
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
        "FASTDDS_DEFAULT_PROFILES_FILE": str(fastdds_profile()),
    }


def fastdds_profile() -> Path:
    """Give the Fast DDS profile: loopback only, shared memory wide enough for pictures."""
    return Path(__file__).parent / "fastdds.xml"


def _check_domain(domain: int) -> None:
    if not FIRST <= domain <= LAST:
        raise BadDomain(domain, FIRST, LAST)


def _raise_none_free(first: int, last: int) -> Reservation:
    raise NoFreeDomain(first, last)


def _runtime_folder() -> Path:
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    if runtime and os.access(runtime, os.W_OK):
        return Path(runtime) / "talaia-domains"
    return Path(tempfile.gettempdir()) / f"talaia-domains-{os.getuid()}"


def _try_lock(folder: Path, domain: int) -> Reservation | None:
    # No link that somebody laid here is followed, and no child inherits the lock.
    flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
    file = os.open(folder / f"{domain}.lock", flags, 0o600)
    try:
        # The kernel takes it back however the process ends.
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(file)
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return None
        raise
    if not _is_silent(domain):
        os.close(file)
        return None
    return Reservation(domain, file)


def _is_silent(domain: int) -> bool:
    """Tell whether no DDS program that knows nothing of our locks has the domain's first port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # By the RTPS specification, where a domain's first participant is found.
            probe.bind(("127.0.0.1", 7400 + 250 * domain + 10))
        except OSError:
            return False
    return True
