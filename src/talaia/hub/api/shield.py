"""What stands before every request: Host, Origin, size, and the headers of every answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.datastructures import Headers, MutableHeaders

from talaia.hub.api.problems import problem

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from talaia.hub.settings import Settings

__all__ = ["Shield", "host_name", "same_origin"]

_SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
_GATEWAY = "/gateway/"


def host_name(host: str) -> str:
    """Give the name in a Host header: without port and brackets, in lower case."""
    if host.startswith("["):
        return host[1:].split("]", 1)[0].lower()
    return host.rsplit(":", 1)[0].lower() if host.count(":") == 1 else host.lower()


def same_origin(origin: str | None, host: str, *, tls: bool) -> bool:
    """Tell whether a page of this very scheme, host and port is asking."""
    return origin is not None and origin == f"{'https' if tls else 'http'}://{host}"


class Shield:
    """ASGI around the application."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        """Guard ``app``; hosts, TLS and the body's limit come from ``settings``."""
        self._app = app
        self._tls = settings.tls
        self._hosts = settings.host_names
        self._max_body = settings.max_body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on with our headers on the answer."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if host_name(host) not in self._hosts or any(c in host for c in "\"' ;,\\/@"):
            status, code = 421, "host"
            said = "this hub is not known by that name; add it with --name"
        elif scope["type"] == "websocket":
            status, code, said = self._socket(scope["path"], headers, host)
        else:
            status, code, said = self._request(scope["method"], headers, host)
        if not status:
            await self._app(scope, receive, self._with_headers(scope, host, send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": said})
        else:
            answer = problem(status, code, said)
            await answer(scope, receive, self._with_headers(scope, host, send))

    def _socket(self, path: str, headers: Headers, host: str) -> tuple[int, str, str]:
        origin = headers.get("origin")
        if path.startswith(_GATEWAY):
            # A gateway is no page; a page must not speak to this door whatever key it has.
            return (403, "origin", "this is no door for pages") if origin else (0, "", "")
        if not same_origin(origin, host, tls=self._tls):
            return 403, "origin", "a page of another origin may not connect"
        return 0, "", ""

    def _request(self, method: str, headers: Headers, host: str) -> tuple[int, str, str]:
        length = headers.get("content-length")
        if "transfer-encoding" in headers:
            return 411, "length", "say how long the body is"
        if length is not None and (not length.isdecimal() or int(length) > self._max_body):
            return 413, "too_large", f"a body holds at most {self._max_body} bytes"
        if method in _SAFE:
            return 0, "", ""
        kind = headers.get("content-type", "").split(";", 1)[0].strip().lower()
        if kind != "application/json" and (kind or length not in {None, "0"}):
            return 415, "type", "send JSON (Content-Type: application/json)"
        origin = headers.get("origin")
        if not same_origin(origin, host, tls=self._tls) and not (
            origin is None and headers.get("sec-fetch-site") == "same-origin"
        ):
            return 403, "origin", "a page of another origin may not ask this"
        return 0, "", ""

    def _with_headers(self, scope: Scope, host: str, send: Send) -> Send:
        async def dressed(message: Message) -> None:
            if message["type"] in {"http.response.start", "websocket.http.response.start"}:
                headers = MutableHeaders(scope=message)
                for name, value in self._headers(host):
                    headers[name] = value
                if scope["path"].startswith("/api"):
                    headers["Cache-Control"] = "no-store"
            await send(message)

        return dressed

    def _headers(self, host: str) -> list[tuple[str, str]]:
        # Older browsers do not count a WebSocket to the same host as 'self'.
        socket = (
            f"{'wss' if self._tls else 'ws'}://{host}" if host_name(host) in self._hosts else ""
        )
        policy = (
            f"default-src 'self'; img-src 'self' blob: data:; connect-src 'self' {socket};"
            " worker-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'self';"
            " frame-ancestors 'none'"
        )
        headers = [
            ("Content-Security-Policy", policy),
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("X-Frame-Options", "DENY"),
        ]
        if self._tls:
            headers.append(("Strict-Transport-Security", "max-age=31536000"))
        return headers
