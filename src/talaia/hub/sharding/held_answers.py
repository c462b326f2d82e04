"""One HTTP request, asked of one shard's application, and its answer as a whole."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, NamedTuple

import msgspec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

__all__ = [
    "HeldAnswer",
    "RequestTooLong",
    "ask_shard",
    "problem_answer",
    "read_body",
    "send_answer",
]

# Bytes of a request, and of an answer: a list of ten thousand sites has some ten million.
_MOST_ASKED, _MOST_ANSWERED = 4 * 1024 * 1024, 64 * 1024 * 1024
# Of a request: an answer is wanted whole, as it is, and whatever the asker has already.
_NOT_ASKED = frozenset(
    {
        b"accept-encoding",
        b"if-match",
        b"if-modified-since",
        b"if-none-match",
        b"if-range",
        b"if-unmodified-since",
        b"range",
    }
)
# Of an answer: of its length and way, not of what it says.
_OF_ONE_ANSWER = frozenset({b"content-length", b"etag", b"last-modified", b"transfer-encoding"})


class RequestTooLong(Exception):
    """A request has more bytes than any that is led to several shards needs."""


class HeldAnswer(NamedTuple):
    """An answer."""

    status: int
    headers: Sequence[tuple[bytes, bytes]]
    body: bytes


def problem_answer(status: int, code: str, message: str, retry_s: int = 0) -> HeldAnswer:
    """Make the answer that says no, in the form of all the hub's refusals.

    It is a word for programs, a sentence for people, and when to ask again (s).
    """
    headers = [(b"content-type", b"application/problem+json"), (b"cache-control", b"no-store")]
    if retry_s:
        headers.append((b"retry-after", str(retry_s).encode()))
    return HeldAnswer(status, headers, msgspec.json.encode({"code": code, "message": message}))


async def ask_shard(app: ASGIApp, scope: Scope, body: bytes) -> HeldAnswer:
    """Ask what a request asks.

    Raises:
        ConnectionError: there is no answer, or not all of one; or what the application raises.

    """
    asked = {
        **scope,
        "headers": [(name, said) for name, said in scope["headers"] if name not in _NOT_ASKED],
        "extensions": {},
        "state": dict(scope.get("state", {})),
    }
    requests: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]
    answer = _Answer()

    async def receive() -> Message:
        if requests:
            return requests.pop()
        # Whoever asks is there until the answer is.
        await asyncio.get_running_loop().create_future()
        return {"type": "http.disconnect"}

    await app(asked, receive, answer.add_message)
    return answer.whole()


async def read_body(receive: Receive) -> bytes:
    """Read a request's body.

    Raises:
        RequestTooLong: it is.
        ConnectionError: whoever asks has gone.

    """
    pieces, size = [], 0
    while True:
        message = await receive()
        if message["type"] != "http.request":
            raise ConnectionError("who asked has gone")
        pieces.append(message.get("body", b""))
        size += len(pieces[-1])
        if size > _MOST_ASKED:
            raise RequestTooLong
        if not message.get("more_body", False):
            return b"".join(pieces)


async def send_answer(send: Send, answer: HeldAnswer) -> None:
    """Give an answer, with its length."""
    headers = [(name, said) for name, said in answer.headers if name.lower() not in _OF_ONE_ANSWER]
    if answer.body or answer.status not in {204, 304}:
        headers.append((b"content-length", str(len(answer.body)).encode()))
    await send({"type": "http.response.start", "status": answer.status, "headers": headers})
    await send({"type": "http.response.body", "body": answer.body})


class _Answer:
    """What has come of an answer."""

    def __init__(self) -> None:
        self._start: Message | None = None
        self._pieces: list[bytes] = []
        self._size = 0
        self._done = False

    async def add_message(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self._start = message
        elif message["type"] == "http.response.body":
            self._pieces.append(message.get("body", b""))
            self._size += len(self._pieces[-1])
            if self._size > _MOST_ANSWERED:
                raise ConnectionError("the answer of a shard is too long")
            self._done = not message.get("more_body", False)

    def whole(self) -> HeldAnswer:
        if self._start is None or not self._done:
            raise ConnectionError("a shard has not answered to the end")
        headers = [(bytes(name), bytes(said)) for name, said in self._start.get("headers", ())]
        return HeldAnswer(self._start["status"], headers, b"".join(self._pieces))
