"""Requests to the hub's HTTP API, from the standard library alone. They block.

No redirect is followed and no proxy of the environment is asked: the token goes to the hub that
was named, and to nobody else.
"""

from __future__ import annotations

import http.client
import socket
import ssl
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, TypeVar
from urllib.parse import quote, urlencode

import msgspec

from talaia.client.errors import (
    HistoryCut,
    HubNotReached,
    HubUntrusted,
    NotFound,
    NotPermitted,
    NotSignedIn,
    ProtocolShut,
    RequestRefused,
    TooManyRequests,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from talaia.client.hub_location import HubLocation
    from talaia.client.hub_trust import CertificateTrust

__all__ = ["BodyStream", "HttpRequests", "quote_segment", "refusal_of", "untrusted"]

# An answer takes at most so long to begin, or to go on (s).
_WAIT_S = 60.0
# Of an answer that is read whole: a description of the largest kind is smaller.
_LONGEST = 64 * 1024 * 1024

T = TypeVar("T")


class _Problem(msgspec.Struct):
    """How the hub says no."""

    code: str = ""
    message: str = ""


class BodyStream:
    """The body of an answer, as a file that is read to its end."""

    def __init__(
        self, connection: http.client.HTTPConnection, answer: http.client.HTTPResponse
    ) -> None:
        """Read from ``answer``."""
        self._connection = connection
        self._answer = answer

    @property
    def closed(self) -> bool:
        """Whether nothing more can be read."""
        return self._answer.closed

    def read(self, size: int = -1) -> bytes:
        """Read so many bytes, fewer only at the end.

        Raises:
            HistoryCut: the hub ended before its answer did.

        """
        try:
            return self._answer.read(None if size < 0 else size)
        except (http.client.IncompleteRead, ValueError) as error:
            raise HistoryCut("the hub ended before its answer did; ask again") from error
        except OSError as error:
            raise HistoryCut(f"the connection was lost within the answer: {error}") from error

    def abort(self) -> None:
        """Give up, also while another thread reads."""
        with suppress(OSError, AttributeError):
            self._connection.sock.shutdown(socket.SHUT_RDWR)
        self._connection.close()


class HttpRequests:
    """Asks one hub. Each request has a connection of its own; threads may ask at once."""

    def __init__(self, hub: HubLocation, trust: CertificateTrust) -> None:
        """Ask ``hub``, which proves itself by ``trust``."""
        self._hub = hub
        self._trust = trust

    def get_json(
        self, kind: type[T], path: str, *, query: Sequence[tuple[str, str]] = (), needs: str = ""
    ) -> T:
        """Ask for what is read as ``kind``; ``needs`` says which right it takes.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        with self._open_answer("GET", _with_query(path, query), needs=needs) as stream:
            body = stream.read(_LONGEST)
        try:
            return msgspec.json.decode(body, type=kind)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            raise HubNotReached(
                f"{self._hub.page}{path} answers what this version does not understand: {error}"
            ) from error

    def send_json(self, method: str, path: str, body: object, *, needs: str = "") -> None:
        """Ask for something to be done, once; ``needs`` says which right it takes.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        with self._open_answer(method, path, body=msgspec.json.encode(body), needs=needs) as stream:
            stream.read(_LONGEST)

    @contextmanager
    def open_stream(
        self, path: str, *, query: Sequence[tuple[str, str]] = (), needs: str = ""
    ) -> Iterator[BodyStream]:
        """Ask for what is too large to be read at once.

        Raises:
            ClientError: the hub cannot be asked, or says no.

        """
        with self._open_answer("GET", _with_query(path, query), needs=needs) as stream:
            yield stream

    @contextmanager
    def _open_answer(
        self, method: str, target: str, *, body: bytes | None = None, needs: str = ""
    ) -> Iterator[BodyStream]:
        connection = self._connect()
        try:
            answer = self._ask(connection, method, target, body=body)
            if answer.status >= 300:
                raise refusal_of(
                    self._hub,
                    answer.status,
                    answer.read(64 * 1024),
                    retry=answer.headers.get("Retry-After", ""),
                    needs=needs,
                )
            yield BodyStream(connection, answer)
        finally:
            connection.close()

    def _connect(self) -> http.client.HTTPConnection:
        context = self._trust.tls_context()
        place = (self._hub.host, self._hub.port)
        if context is None:
            return http.client.HTTPConnection(*place, timeout=_WAIT_S)
        return http.client.HTTPSConnection(*place, timeout=_WAIT_S, context=context)

    def _ask(
        self,
        connection: http.client.HTTPConnection,
        method: str,
        target: str,
        *,
        body: bytes | None,
    ) -> http.client.HTTPResponse:
        headers = {"Authorization": f"Bearer {self._hub.token}", "Connection": "close"}
        if body is not None:
            headers["Content-Type"] = "application/json"
        try:
            connection.request(method, target, body=body, headers=headers)
            return connection.getresponse()
        except ssl.SSLCertVerificationError as error:
            self._trust.forget_certificate()
            raise untrusted(self._hub, error) from error
        except (OSError, http.client.HTTPException) as error:
            # The certificate may have been renewed: look at it again next time.
            self._trust.forget_certificate()
            said = str(error) or type(error).__name__
            raise HubNotReached(f"{self._hub.page} cannot be reached: {said}") from error


def untrusted(hub: HubLocation, error: ssl.SSLCertVerificationError) -> HubUntrusted:
    """Say what to do about a certificate that no authority vouches for."""
    return HubUntrusted(
        f"{hub.page} is not trusted: {error.verify_message}; give the fingerprint of its"
        " certificate, which the hub prints at its start, or its authority's file"
    )


def refusal_of(
    hub: HubLocation, status: int, body: bytes, *, retry: str = "", needs: str = ""
) -> RequestRefused | HubNotReached:
    """Make the error of an answer that says no."""
    try:
        said = msgspec.json.decode(body, type=_Problem)
    except (msgspec.DecodeError, UnicodeDecodeError):
        said = _Problem()
    code, message = said.code, said.message or f"{hub.page} answers HTTP {status}"
    match status, code:
        case 401, _:
            return NotSignedIn(
                code,
                "the hub does not know this token: it was revoked, has ended, or is mistyped",
                f"make another under Account, Tokens for scripts, at {hub.page}",
            )
        case 403, "shut":
            remedy = "an admin opens it under Admin, Clients: Driving by scripts"
            return ProtocolShut(code, "driving by scripts is shut", remedy)
        case 403, _:
            wants = f"it takes {needs}, of the token and of its person; " if needs else ""
            remedy = f"{wants}make a token with more rights, or ask an admin for the role"
            return NotPermitted(code, message, remedy)
        case 404, _:
            return NotFound(code, message)
        case 429, _:
            wait_s = float(retry) if retry.isascii() and retry.isdigit() and len(retry) < 6 else 5.0
            return TooManyRequests(code, message, wait_s)
        case ((502 | 503 | 504), _):
            return HubNotReached(message)
        case _:
            return RequestRefused(code, message)


def quote_segment(text: str) -> str:
    """Write a name as a segment of a path."""
    return quote(text, safe="")


def _with_query(path: str, query: Sequence[tuple[str, str]]) -> str:
    return f"{path}?{urlencode(query)}" if query else path
