"""Reports a service's state to systemd over its notification socket (`sd_notify`).

See sd_notify(3) and systemd.service(5), ``Type=notify`` and ``WatchdogSec=``. Without a
notification socket in the environment nothing is sent.
"""

from __future__ import annotations

import contextlib
import os
import socket
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["ServiceManager", "own_service_manager"]


class ServiceManager:
    """A service manager that listens on a datagram socket, or nobody.

    Attributes:
        watchdog_s: it ends this process after so long without `feed_watchdog` (s); 0: never.

    """

    def __init__(self, address: str = "", watchdog_s: float = 0.0) -> None:
        """Take the socket's address: a path, or ``@name`` in the abstract namespace."""
        self.watchdog_s = watchdog_s
        # A leading NUL is how Linux writes an address that is in no file system (unix(7)).
        self._address = "\0" + address[1:] if address.startswith("@") else address
        # None without a manager and after `close`; then nothing is sent.
        self._socket: socket.socket | None = None
        if self._address:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
            # A manager that does not read must never hold up a control loop.
            self._socket.settimeout(0)

    @classmethod
    def from_environment(cls, environment: Mapping[str, str], pid: int) -> ServiceManager:
        """Take what systemd left in ``environment``; a watchdog for another ``pid`` is not ours."""
        seconds = 0.0
        # Where it is unset the watchdog is taken for ours, as libsystemd does.
        if environment.get("WATCHDOG_PID", str(pid)) == str(pid):
            # An unreadable number is as none: better no watchdog than a service that does not
            # start.
            with contextlib.suppress(ValueError):
                seconds = max(0, int(environment.get("WATCHDOG_USEC", "0"))) / 1e6
        return cls(environment.get("NOTIFY_SOCKET", ""), seconds)

    def report_ready(self) -> None:
        """Tell that the service has started."""
        self._send_state("READY=1")

    def report_stopping(self) -> None:
        """Tell that the service is ending, as it was asked to."""
        self._send_state("STOPPING=1")

    def feed_watchdog(self) -> None:
        """Tell that the service still does its work."""
        if self.watchdog_s:
            self._send_state("WATCHDOG=1")

    def close(self) -> None:
        """Send nothing any more."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _send_state(self, state: str) -> None:
        if self._socket is not None:
            # Missed once, it is sent again in a moment; a manager that is gone needs nothing.
            with contextlib.suppress(OSError):
                self._socket.sendto(state.encode(), self._address)


def own_service_manager() -> ServiceManager:
    """Give the service manager of this process; processes that it starts have none."""
    manager = ServiceManager.from_environment(os.environ, os.getpid())
    # A child that inherited them could report itself ready, or feed the watchdog, in our name.
    for name in ("NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"):
        os.environ.pop(name, None)
    return manager
