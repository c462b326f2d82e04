"""One GET, whole and bounded: to the address that was judged, no redirect, one deadline. Blocks.

The standard library's client takes a connection that is made already, so the name is looked up
once, its address judged, and that very address is asked: a name that means another machine a
moment later gains nothing.
"""

from __future__ import annotations

import contextlib
import http.client
import socket
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from talaia.gateway.errors import GatewayError
from talaia.model.camera_addresses import why_no_camera

if TYPE_CHECKING:
    import ssl
    from collections.abc import Mapping

__all__ = ["MAX_ANSWER", "FetchFailed", "HttpQuestion", "HttpServer"]

# Of an answer, in bytes: a device's whole state is some ten thousand.
MAX_ANSWER = 1024 * 1024
_PIECE = 64 * 1024


class FetchFailed(GatewayError):
    """There is no answer, or none that can be read; says why, without any secret."""


class HttpServer(NamedTuple):
    """Who is asked, and how.

    Attributes:
        url: its root.
        headers: sent with each question; secrets among them.
        tls: trusts its certificate; none for plain text.
        timeout: for all of one question (s).
        here: it may be this computer.

    """

    url: str
    headers: Mapping[str, str]
    tls: ssl.SSLContext | None
    timeout: float
    here: bool


class HttpQuestion:
    """One GET; `fetch_answer` on a thread of its own, `cut_off` from any other."""

    def __init__(self, server: HttpServer, get: str) -> None:
        """Ask for ``get`` below the server's root."""
        self._server, self._get = server, get
        self._line: socket.socket | None = None  # While it is under way.
        self._is_cut = False  # Its time is over: what came so far is no answer.

    def cut_off(self) -> None:
        """End it now, however it stands: a byte a second would meet no timeout of the socket's."""
        self._is_cut = True
        line = self._line
        if line is not None:
            # OSError: it has ended meanwhile.
            with contextlib.suppress(OSError):
                line.shutdown(socket.SHUT_RDWR)

    def fetch_answer(self) -> bytes:
        """Give the body of an answer of status 200. Blocks.

        Raises:
            FetchFailed: there is none, or it was cut off.

        """
        parts = urlsplit(self._server.url)
        host = parts.hostname or ""
        port = parts.port or (443 if self._server.tls else 80)
        connection = http.client.HTTPConnection(host, port, timeout=self._server.timeout)
        try:
            self._line = connection.sock = _connect(self._server, host, port)
            # The name that was looked up, as a server with several of them wants it.
            headers = {**self._server.headers, "Host": parts.netloc, "Connection": "close"}
            connection.request("GET", parts.path.rstrip("/") + self._get, headers=headers)
            with connection.getresponse() as answer:
                body = _read_answer(answer)
        except (OSError, http.client.HTTPException) as error:
            if self._is_cut:
                raise FetchFailed(_late_words(self._server.timeout)) from error
            why = (str(error) or type(error).__name__)[:200]
            where = f"at {host}:{port}"
            said = f"its answer {where} cannot be read" if self._line else f"none answers {where}"
            raise FetchFailed(f"{said} ({why})") from error
        finally:
            connection.close()
            # The client has let go of a line that the server is to close.
            if self._line is not None:
                self._line.close()
        # Cut off, a body without a stated length looks whole.
        if self._is_cut:
            raise FetchFailed(_late_words(self._server.timeout))
        return body


def _late_words(timeout: float) -> str:
    return f"it has not answered whole within {timeout:g} s"


def _connect(server: HttpServer, host: str, port: int) -> socket.socket:
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    failed = OSError("its name has no address")
    for family, kind, protocol, _, address in found:
        why = why_no_camera(str(address[0]), here=server.here)
        if why:
            # Never the next one instead: a name with one such address is no device's.
            raise FetchFailed(f"{host} is not asked: it is {address[0]}, {why}")
        line = socket.socket(family, kind, protocol)
        line.settimeout(server.timeout)
        try:
            line.connect(address)
            if server.tls is not None:
                return server.tls.wrap_socket(line, server_hostname=host)
        except OSError as error:
            line.close()
            failed = error
            continue
        return line
    raise failed


def _read_answer(answer: http.client.HTTPResponse) -> bytes:
    if 300 <= answer.status < 400:
        raise FetchFailed(f"it sends us elsewhere ({answer.status}), which is not followed")
    # Not its words: they are the server's, of any length and letters.
    if answer.status != 200:
        raise FetchFailed(f"it answers with the status {answer.status}")
    body = bytearray()
    while piece := answer.read(_PIECE):
        body += piece
        if len(body) > MAX_ANSWER:
            raise FetchFailed(f"its answer is longer than {MAX_ANSWER // 1024} KiB")
    # `read` with a size does not say so by itself.
    if answer.length:
        raise FetchFailed("its answer ends before its stated length")
    return bytes(body)
