"""What stands before every request: Host, Origin, size, and the headers of every answer."""

from __future__ import annotations

import ipaddress
import re
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers, MutableHeaders

from talaia.hub.api.problems import problem_response
from talaia.hub.api.server.anonymous_requests import AnonymousRequests
from talaia.hub.api.server.proxies import Proxies
from talaia.hub.api.server.response_headers import guarding_headers
from talaia.hub.policy_routes import ROUTES, AccessNeed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from talaia.hub.settings import Settings

__all__ = ["HIDDEN_TOKEN", "RequestGuard", "host_name", "same_origin"]

# Change nothing (RFC 9110, 9.2.1).
_SAFE = frozenset({"GET", "HEAD", "OPTIONS"})
_GATEWAY = "/gateway/"
# Of other tools: cookies never count there, and each protocol has its own list of origins.
_CLIENTS = ("/clients/", "/socket.io/")
# Where the token of such a client stands that was in its address; nothing can log it there.
HIDDEN_TOKEN = "talaia.token"  # noqa: S105
# Of programs that have no session: what they show stands in what they send.
_OF_PROGRAMS = frozenset({"/api/enrol", "/api/heads"})
_API = "/api/"
# Sign-in and the like: what is sent there is read, whoever sends it.
_UNASKED = frozenset(
    route for route, need in ROUTES.items() if need is AccessNeed.OPEN and route[0] not in _SAFE
)
# The routes whose body holds a whole description.
_DESCRIPTION = re.compile(r"/api/sites/[^/]+/descriptions(/check|/edit)?")
# The host becomes a part of the Content-Security-Policy, and of the command to enrol by.
_PORT = re.compile(r"^(\[[^\]]*\]|[^:\[\]]*)(:[0-9]{1,5})?$", re.ASCII)
_STRANGE = frozenset("\"' ;,\\/@?#<>")
_SECURE = frozenset({"https", "wss"})


class _No(NamedTuple):
    """A refusal."""

    status: int
    code: str
    said: str


_TOO_MANY = _No(
    503, "busy", "too many requests of your address are open; sign in, or wait a little"
)


def host_name(host: str) -> str:
    """Give the name in a Host header: without port and brackets, in lower case."""
    if host.startswith("["):
        return host[1:].split("]", 1)[0].lower()
    return host.rsplit(":", 1)[0].lower() if host.count(":") == 1 else host.lower()


def same_origin(origin: str | None, host: str, *, tls: bool) -> bool:
    """Tell whether a page of this very scheme, host and port is asking."""
    return origin is not None and origin == f"{'https' if tls else 'http'}://{host}"


class RequestGuard:
    """ASGI around the application."""

    def __init__(
        self,
        app: ASGIApp,
        settings: Settings,
        picture_origins: Callable[[], Sequence[str]] = tuple,
    ) -> None:
        """Guard ``app``; hosts, proxies and the body's limit come from ``settings``.

        ``picture_origins`` are those that an admin allowed pages to ask for tiles of maps.
        """
        self._app = app
        self._picture_origins = picture_origins
        # All fixed while the hub runs.
        self._proxies = Proxies(settings.proxies)
        self._hosts = settings.host_names
        self._anonymous = AnonymousRequests()
        self._max_body = settings.max_body
        self._max_description_body = settings.max_description_body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on with our headers on the answer."""
        # The start and the end of the hub, not a request.
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["path"].startswith(_CLIENTS):
            _hide_token(scope)
        # First: all that follows goes by the real asker and the real scheme.
        scope = self._proxies.look_through(scope)
        tls = scope["scheme"] in _SECURE
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        # DNS rebinding: a stranger's name that leads to this address is not answered.
        host = hosts[0] if len(hosts) == 1 and self._is_ours(hosts[0], scope) else ""
        dressed = self._dress(scope, host, send, tls=tls)
        # A proxy and this hub could each believe another one of them.
        if len(hosts) > 1:
            no: _No | None = _No(400, "host", "say once which host is meant")
        elif not host:
            no = _No(421, "host", "this hub is not known by that name; add it with --allow-host")
        elif scope["type"] == "websocket":
            no = _of_socket(scope["path"], headers, host, tls=tls)
        else:
            no = self._of_request(scope, headers, host, tls=tls)
        if no is not None:
            await _refuse_request(no, scope, receive, dressed)
            return
        client = scope.get("client")
        address = client[0] if client else ""
        unasked = (scope.get("method"), scope["path"]) in _UNASKED
        with self._anonymous.count(address, headers, unasked=unasked) as allowed:
            if allowed:
                await self._app(scope, receive, dressed)
            else:
                await _refuse_request(_TOO_MANY, scope, receive, dressed)

    def _dress(self, scope: Scope, host: str, send: Send, *, tls: bool) -> Send:
        guarding = guarding_headers(host, tls=tls, pictures=self._picture_origins())
        return _dressed(scope, guarding, send)

    def _is_ours(self, host: str, scope: Scope) -> bool:
        if not _STRANGE.isdisjoint(host):
            return False
        # What follows the name is a port and nothing else: a page's origin is made of it.
        if _PORT.search(host) is None:
            return False
        name = host_name(host)
        if name in self._hosts:
            return True
        # The very address that was dialled. A page of somebody else's name cannot bring it about
        # that a browser says this: that is what the list is against.
        server = scope.get("server")
        return server is not None and _same_address(name, server[0])

    def _limit_of(self, scope: Scope) -> int:
        # Who may not send a description is refused by its route before the body is read.
        large = scope["method"] == "POST" and _DESCRIPTION.fullmatch(scope["path"])
        return self._max_description_body if large else self._max_body

    def _of_request(self, scope: Scope, headers: Headers, host: str, *, tls: bool) -> _No | None:
        length = headers.get("content-length")
        # A body of unknown length cannot be refused before it is read.
        if "transfer-encoding" in headers:
            return _No(411, "length", "say how long the body is")
        # By what is said; uvicorn reads no more than that.
        most = self._limit_of(scope)
        if length is not None and (not length.isdecimal() or int(length) > most):
            return _No(413, "too_large", f"a body holds at most {most} bytes")
        if scope["path"].startswith(_CLIENTS):
            # Admitted by token, from origins that an admin names; its route looks at both.
            return None
        # Browsers send it, and no script of a page can change it.
        path, site = scope["path"], headers.get("sec-fetch-site")
        if scope["method"] in _SAFE:
            # It could not read the answer, but could keep the hub busy.
            if path.startswith(_API) and site in {"cross-site", "same-site"}:
                return _No(403, "origin", "a page of another origin may not ask this")
            return None
        # A form of another page can send text or form data without being asked; JSON it cannot.
        kind = headers.get("content-type", "").split(";", 1)[0].strip().lower()
        if kind != "application/json" and (kind or length not in {None, "0"}):
            return _No(415, "type", "send JSON (Content-Type: application/json)")
        if not _may_change(path, headers, host, tls=tls):
            return _No(403, "origin", "a page of another origin may not ask this")
        return None


def _may_change(path: str, headers: Headers, host: str, *, tls: bool) -> bool:
    """Tell whether what may change something comes from a page of ours, or from no page at all.

    A browser names the origin of the page that asks. Programs have none; they are let in where no
    cookie could speak for somebody who does not know: with a token of their own, to enrol, and to
    leave heads of another hub.
    """
    origin = headers.get("origin")
    if origin is not None:
        return same_origin(origin, host, tls=tls)
    site = headers.get("sec-fetch-site")
    if site is not None:
        # No Origin, but a browser all the same.
        return site == "same-origin"
    # No page at all: nothing here goes by a cookie.
    return path in _OF_PROGRAMS or _has_bearer(headers)


def _of_socket(path: str, headers: Headers, host: str, *, tls: bool) -> _No | None:
    if path.startswith(_CLIENTS):
        # Admitted by token, from origins that an admin names; its route looks at both.
        return None
    origin = headers.get("origin")
    if path.startswith(_GATEWAY):
        # A gateway is no page; a page must not speak to this door whatever key it has.
        return _No(403, "origin", "this is no door for pages") if origin is not None else None
    if origin is None and "cookie" not in headers and _has_bearer(headers):
        # A script with a token of its own; a page cannot send one when it opens a socket.
        return None
    # Browsers let any page open a socket to anywhere: the same-origin policy does not hold there.
    if not same_origin(origin, host, tls=tls):
        return _No(403, "origin", "a page of another origin may not connect")
    return None


def _hide_token(scope: Scope) -> None:
    """Take the token out of a client's address, in place: the server's own log reads it there."""
    if b"token" not in scope["query_string"]:
        return
    said = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
    scope[HIDDEN_TOKEN] = next((value for name, value in said if name == "token"), "")
    kept = [(name, "***" if name == "token" else value) for name, value in said]
    scope["query_string"] = urlencode(kept, safe="*").encode("ascii")


def _has_bearer(headers: Headers) -> bool:
    return headers.get("authorization", "").lower().startswith("bearer ")


def _same_address(name: str, own: str) -> bool:
    try:
        return ipaddress.ip_address(name) == ipaddress.ip_address(own)
    except ValueError:
        # A name, where the other is an address.
        return False


async def _refuse_request(no: _No, scope: Scope, receive: Receive, send: Send) -> None:
    answer = problem_response(*no)
    if scope["type"] == "http":
        await answer(scope, receive, send)
        return
    # Before the upgrade, as an ordinary answer: a browser's console shows the status.
    # ASGI: first the other side's wish to connect is taken.
    await receive()
    start = {"status": no.status, "headers": answer.raw_headers}
    await send({"type": "websocket.http.response.start", **start})
    await send({"type": "websocket.http.response.body", "body": bytes(answer.body)})


def _dressed(scope: Scope, guarding: Sequence[tuple[str, str]], send: Send) -> Send:
    async def dressed(message: Message) -> None:
        if message["type"] in {"http.response.start", "websocket.http.response.start"}:
            headers = MutableHeaders(scope=message)
            # Also on refusals, and on what the framework itself answers.
            for name, value in guarding:
                # What others have sent us is locked up more tightly by its own route.
                if not headers.get(name, "").startswith("sandbox"):
                    headers[name] = value
            if scope["path"].startswith("/api"):
                # The next person at this browser must not find it by going back.
                headers["Cache-Control"] = "no-store"
        await send(message)

    return dressed
