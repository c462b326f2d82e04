"""Ports for programs that have to be told theirs, and may be killed and begun anew there.

They lie below those that the system gives to whoever asks for any port: a test that runs beside
this one, and its servers, come by none of them.
"""

import secrets
import socket
import sys

FIRST, MANY = 20_000, 10_000
# Of ports that were given away, until this process ends: others would find them free until
# somebody listens there, which takes a program seconds.
_reservations: list[socket.socket] = []


def free_port() -> int:
    """Find a port of loopback at which nobody listens, and that no other test was given."""
    while True:
        port = FIRST + secrets.randbelow(MANY)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        if _reserve_port(port):
            return port


def _reserve_port(port: int) -> bool:
    """Tell whether nobody else has it; by a name without a file, which ends with its process."""
    if sys.platform != "linux":
        return True
    reservation = socket.socket(socket.AF_UNIX)
    try:
        reservation.bind(f"\0talaia-test-port-{port}")
    except OSError:
        reservation.close()
        return False
    _reservations.append(reservation)
    return True
