"""Ports for programs that have to be told theirs, and may be killed and begun anew there.

They lie below those that the system gives to whoever asks for any port: a test that runs beside
this one, and its servers, come by none of them.
"""

import secrets
import socket

FIRST, MANY = 20_000, 10_000


def free_port() -> int:
    """Find a port of loopback at which nobody listens."""
    while True:
        port = FIRST + secrets.randbelow(MANY)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
