"""One GET or PUT, whole and bounded: to the address that was judged, no redirect.

The standard library's client takes a connection that is made already, so the name is
looked up once, its address judged, and that very address is asked: a name that means another
machine a moment later gains nothing.
"""

from __future__ import annotations

import asyncio
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
    from concurrent.futures import Executor

__all__ = [
    "MAX_ANSWER",
    "FetchFailed",
    "HttpPost",
    "HttpQuestion",
    "HttpServer",
    "ServerNotReached",
    "StatusRefused",
]

# Of an answer, in bytes: a device's whole state is some ten thousand.
MAX_ANSWER = 1024 * 1024
_PIECE = 64 * 1024
# Of what a server says beside a status, in bytes: all that is read, and what is told of it.
_MOST_REFUSED = 64 * 1024
_MOST_WORDS = 2000


class FetchFailed(GatewayError):
    """There is no answer, or none that can be read; says why, without any secret."""


class ServerNotReached(FetchFailed):
    """There is no line to it: whatever was to be asked was not sent."""


class StatusRefused(FetchFailed):
    """It answers with a status that is no success.

    Attributes:
        status: of HTTP.
        words: the first of what it says, as text; its own, of any letters.
        body: the first of it, as it came.
        challenges: how it wants to be signed in at (``WWW-Authenticate``).

    """

    def __init__(self, status: int, body: bytes, challenges: tuple[str, ...] = ()) -> None:
        """Keep them apart: not every reader may show its words."""
        super().__init__(f"it answers with the status {status}")
        self.status, self.body, self.challenges = status, body, challenges
        self.words = body[:_MOST_WORDS].decode(errors="replace")


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


class HttpPost(NamedTuple):
    """What is sent with a POST."""

    content_type: str
    body: bytes


class HttpQuestion:
    """One GET, PUT or POST; `fetch_answer` on a thread of its own, `cut_off` from any other."""

    def __init__(
        self,
        server: HttpServer,
        get: str,
        *,
        form: bytes | None = None,
        post: HttpPost | None = None,
        longest: int = MAX_ANSWER,
    ) -> None:
        """Ask for ``get`` below the server's root.

        Args:
            server: who is asked.
            get: the path, with its query.
            form: put there, as a form's fields; none only asks. It is sent once and never again.
            post: sent there by POST, once and never again; none only asks.
            longest: of the answer (bytes).

        """
        self._server, self._get = server, get
        self._form, self._post, self._longest = form, post, longest
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

    async def fetch_in_time(self, threads: Executor) -> bytes:
        """Give what `fetch_answer` gives, all of it within the server's time limit.

        Raises:
            FetchFailed: there is none, or it was cut off.

        """
        loop = asyncio.get_running_loop()
        late = loop.call_later(self._server.timeout, self.cut_off)
        try:
            return await loop.run_in_executor(threads, self.fetch_answer)
        except asyncio.CancelledError:
            self.cut_off()
            raise
        finally:
            late.cancel()

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
            path, method = parts.path.rstrip("/") + self._get, "GET"
            if self._form is not None:
                method, headers["Content-Type"] = "PUT", "application/x-www-form-urlencoded"
            body = self._form
            if self._post is not None:
                method, headers["Content-Type"], body = "POST", *self._post
            connection.request(method, path, body, headers)
            with connection.getresponse() as answer:
                read = _read_answer(answer, self._longest)
        except (OSError, http.client.HTTPException) as error:
            # The line's own time limit and the cut come at the same moment: either may be first.
            late = self._line is not None and isinstance(error, TimeoutError)
            if self._is_cut or late:
                raise FetchFailed(_late_words(self._server.timeout)) from error
            why = (str(error) or type(error).__name__)[:200]
            where = f"at {host}:{port}"
            if self._line is None:
                raise ServerNotReached(f"none answers {where} ({why})") from error
            raise FetchFailed(f"its answer {where} cannot be read ({why})") from error
        finally:
            connection.close()
            # The client has let go of a line that the server is to close.
            if self._line is not None:
                self._line.close()
        # Cut off, a body without a stated length looks whole.
        if self._is_cut:
            raise FetchFailed(_late_words(self._server.timeout))
        return read


def _late_words(timeout: float) -> str:
    return f"it has not answered whole within {timeout:g} s"


def _connect(server: HttpServer, host: str, port: int) -> socket.socket:
    found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    failed = OSError("its name has no address")
    for family, kind, protocol, _, address in found:
        why = why_no_camera(str(address[0]), here=server.here)
        if why:
            # Never the next one instead: a name with one such address is no device's.
            raise ServerNotReached(f"{host} is not asked: it is {address[0]}, {why}")
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


def _read_answer(answer: http.client.HTTPResponse, longest: int) -> bytes:
    if 300 <= answer.status < 400:
        raise FetchFailed(f"it sends us elsewhere ({answer.status}), which is not followed")
    if answer.status != 200:
        challenges = tuple(answer.headers.get_all("WWW-Authenticate") or ())
        raise StatusRefused(answer.status, answer.read(_MOST_REFUSED), challenges)
    body = bytearray()
    while piece := answer.read(_PIECE):
        body += piece
        if len(body) > longest:
            raise FetchFailed(f"its answer is longer than {longest // 1024} KiB")
    # `read` with a size does not say so by itself.
    if answer.length:
        raise FetchFailed("its answer ends before its stated length")
    return bytes(body)
