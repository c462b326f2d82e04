"""The certificates that clients of the tests trust by default, read once for each process.

To read a machine's two hundred certificates takes 20 ms of a core, and a client reads them anew
even where nothing is encrypted: tests make thousands of clients.
"""

from __future__ import annotations

import functools
import ssl

import httpx


@functools.cache
def usual_trust() -> ssl.SSLContext:
    """Give what a client checks a server's certificate by, as ``verify=usual_trust()``."""
    return httpx.create_ssl_context()
