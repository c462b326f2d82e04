"""Serves the page of `talaia init --web` on this machine alone, and ends when it is answered.

The address that is printed holds a token that is good for one visit: it is exchanged for a cookie,
which every other request has to bring. What asks by another host's name or from another page is
refused, so that no web page in the same browser can write a file here.
"""

from __future__ import annotations

import asyncio
import hmac
import secrets
from http.cookies import CookieError, SimpleCookie
from importlib.resources import files
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import parse_qs

import msgspec

from talaia.bounded_http import serve_bounded
from talaia.model.discovery.rules.proposal_answers import ProposalAnswers

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

__all__ = ["InitPage", "serve_page"]

_HERE = "127.0.0.1"
_COOKIE = "talaia_init"
# Answers of the largest robot of the tests have some 100 kB.
_MOST_BYTES = 2 * 1024 * 1024
_FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
}
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
_HEADERS = [
    (b"cache-control", b"no-store"),
    (b"content-security-policy", _POLICY.encode()),
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
]


class _Answer(NamedTuple):
    """An answer of HTTP."""

    status: int
    kind: str = "text/plain; charset=utf-8"
    body: bytes = b""
    more: tuple[tuple[bytes, bytes], ...] = ()


class InitPage:
    """An ASGI application; `done` is set when the file is written."""

    def __init__(
        self,
        questions: bytes,
        newest: Callable[[], Mapping[str, float | str]],
        picture: Callable[[str], bytes | None],
        finish: Callable[[ProposalAnswers], list[str]],
    ) -> None:
        """Serve one person.

        Args:
            questions: JSON of what is asked.
            newest: gives the newest values by channel.
            picture: gives a camera's newest picture (JPEG) by its address; none so far.
            finish: writes the file; gives what is wrong with the answers, and then writes nothing.

        """
        self._questions, self._finish = questions, finish
        self._newest, self._picture = newest, picture
        # Good for the first visit; empty afterwards.
        self.token = secrets.token_urlsafe(24)
        self._session = secrets.token_urlsafe(24)
        self.done = asyncio.Event()
        # What a browser has to call us: known when there is a port.
        self.hosts: tuple[str, ...] = ()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:  # noqa: ANN401 - ASGI
        """Answer one request."""
        if scope["type"] != "http":
            return
        answer = await self._answer(scope, receive)
        headers = [(b"content-type", answer.kind.encode()), *_HEADERS, *answer.more]
        await send({"type": "http.response.start", "status": answer.status, "headers": headers})
        await send({"type": "http.response.body", "body": answer.body})

    async def _answer(self, scope: Any, receive: Any) -> _Answer:  # noqa: ANN401 - ASGI
        headers = {
            key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]
        }
        path, method = scope["path"], scope["method"]
        # A name that leads here from elsewhere is not ours: see DNS rebinding.
        if headers.get("host") not in self.hosts:
            return _Answer(421, body=b"this page is at 127.0.0.1 alone")
        token = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if path == "/" and token:
            return self._let_in(token)
        if not self._is_known(headers):
            return _Answer(403, body=b"open the address that talaia init printed; it is good once")
        if method == "GET" and path in _FILES:
            name, kind = _FILES[path]
            return _Answer(200, kind, files(__package__).joinpath(name).read_bytes())
        if method == "GET" and path == "/questions":
            return _Answer(200, "application/json", self._questions)
        if method == "GET" and path == "/values":
            return _Answer(200, "application/json", msgspec.json.encode(self._newest()))
        if path == "/favicon.ico":
            # Browsers ask for it by themselves.
            return _Answer(204)
        if method == "GET" and path.startswith("/pictures/"):
            picture = self._picture(path.removeprefix("/pictures/"))
            return _Answer(204) if picture is None else _Answer(200, "image/jpeg", picture)
        if method == "POST" and path == "/answers":
            return await self._write_file(headers, receive)
        return _Answer(404, body=b"there is nothing of this name")

    def _let_in(self, token: str) -> _Answer:
        if not self.token or not hmac.compare_digest(token.encode(), self.token.encode()):
            return _Answer(403, body=b"this address was used before; start talaia init --web anew")
        self.token = ""
        cookie = f"{_COOKIE}={self._session}; Path=/; HttpOnly; SameSite=Strict"
        return _Answer(303, more=((b"location", b"/"), (b"set-cookie", cookie.encode())))

    def _is_known(self, headers: Mapping[str, str]) -> bool:
        try:
            sent = SimpleCookie(headers.get("cookie", "")).get(_COOKIE)
        except CookieError:
            return False
        return sent is not None and hmac.compare_digest(sent.value.encode(), self._session.encode())

    async def _write_file(self, headers: Mapping[str, str], receive: Any) -> _Answer:  # noqa: ANN401
        # A form of another page can send no JSON, and a script of one has another origin.
        own = {f"http://{host}" for host in self.hosts}
        if headers.get("content-type") != "application/json" or headers.get("origin") not in own:
            return _Answer(403, body=b"answers come from this page alone")
        body, more = b"", True
        while more:
            part = await receive()
            if part["type"] != "http.request":
                return _Answer(400)
            body, more = body + part.get("body", b""), part.get("more_body", False)
            if len(body) > _MOST_BYTES:
                return _Answer(413, body=b"these answers are too long")
        try:
            answers = msgspec.json.decode(body, type=ProposalAnswers)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            return _Answer(400, body=str(error).encode()[:1000])
        problems = self._finish(answers)
        if problems:
            return _Answer(422, "application/json", msgspec.json.encode({"problems": problems}))
        self.done.set()
        return _Answer(200, "application/json", b"{}")


async def serve_page(page: InitPage, tell: Callable[[str], None], port: int = 0) -> None:
    """Serve until it is answered; ``tell`` is given the address to open."""
    async with serve_bounded(page, _HERE, port, most_connections=20) as taken:
        page.hosts = (f"{_HERE}:{taken}", f"localhost:{taken}")
        tell(f"http://{_HERE}:{taken}/?token={page.token}")
        await page.done.wait()
