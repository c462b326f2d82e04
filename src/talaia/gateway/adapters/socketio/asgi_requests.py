"""Requests and WebSockets of ASGI, as much of them as Engine.IO needs."""

from __future__ import annotations

import asyncio
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import parse_qsl

from talaia.engineio.engine_connection import LineGone
from talaia.gateway.errors import GatewayError
from talaia.wire.socketio.engine_packets import MAX_SOCKETIO_BODY

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    Scope = dict[str, Any]
    Receive = Callable[[], Awaitable[dict[str, Any]]]
    Send = Callable[[dict[str, Any]], Awaitable[None]]

__all__ = [
    "AsgiSocket",
    "EngineRequest",
    "ProgramRefused",
    "read_body",
    "read_request",
    "send_answer",
    "wait_until_gone",
]

# So long the body of a request may take to come (s).
_BODY_S = 30.0


class ProgramRefused(GatewayError):
    """A request that is not served."""

    def __init__(self, status: HTTPStatus, why: str) -> None:
        """Answer with ``status`` and a sentence."""
        super().__init__(why)
        self.status, self.why = status, why


class EngineRequest(NamedTuple):
    """What is asked for."""

    query: dict[str, str]
    headers: dict[str, str]  # By name in small letters.
    peer: str


class AsgiSocket:
    """A `FrameSocket`."""

    def __init__(self, receive: Receive, send: Send) -> None:
        """Speak by these two of an accepted WebSocket."""
        self._receive, self._send = receive, send

    async def receive_frame(self) -> str | bytes:
        """Wait for a frame."""
        event = await self._receive()
        if event["type"] == "websocket.disconnect":
            raise LineGone
        data: bytes | None = event.get("bytes")
        return str(event.get("text", "")) if data is None else data

    async def send_frame(self, frame: str | bytes) -> None:
        """Send one."""
        kind = "text" if isinstance(frame, str) else "bytes"
        try:
            await self._send({"type": "websocket.send", kind: frame})
        except (OSError, RuntimeError) as gone:
            raise LineGone from gone

    async def close_socket(self, code: int) -> None:
        """Close it."""
        try:
            await self._send({"type": "websocket.close", "code": code})
        except (OSError, RuntimeError):
            # The program was quicker.
            return


def read_request(scope: Scope) -> EngineRequest:
    """Read what is asked for."""
    client = scope.get("client")
    return EngineRequest(
        query=dict(parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)),
        headers={
            name.decode("latin-1").lower(): value.decode("latin-1")
            for name, value in scope["headers"]
        },
        peer=str(client[0]) if client else "nowhere",
    )


async def read_body(receive: Receive) -> bytes:
    """Read the body of a request; raises `ProgramRefused` of one that is too large or too slow."""
    body = bytearray()
    try:
        async with asyncio.timeout(_BODY_S):
            while True:
                event = await receive()
                body += event.get("body", b"")
                if len(body) > MAX_SOCKETIO_BODY:
                    why = f"a request holds at most {MAX_SOCKETIO_BODY} bytes"
                    raise ProgramRefused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, why)
                if event["type"] == "http.disconnect" or not event.get("more_body"):
                    return bytes(body)
    except TimeoutError:
        raise ProgramRefused(HTTPStatus.REQUEST_TIMEOUT, "the request took too long") from None


async def wait_until_gone(receive: Receive) -> None:
    """Return when whoever asks has gone."""
    while (await receive())["type"] != "http.disconnect":
        pass


async def send_answer(send: Send, status: HTTPStatus, body: bytes, kind: str) -> None:
    """Answer a request whole."""
    headers = [
        (b"content-type", kind.encode()),
        (b"content-length", str(len(body)).encode()),
        (b"cache-control", b"no-store"),
        (b"x-content-type-options", b"nosniff"),
    ]
    await send({"type": "http.response.start", "status": int(status), "headers": headers})
    await send({"type": "http.response.body", "body": body})
