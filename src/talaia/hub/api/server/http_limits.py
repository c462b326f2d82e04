"""HTTP as uvicorn reads it, with bounds: how long a head may be, and how long it may take."""

from __future__ import annotations

import functools
import json
from http import HTTPStatus
from typing import TYPE_CHECKING

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol, RequestResponseCycle

from talaia.hub.api.server.response_headers import guarding_headers

if TYPE_CHECKING:
    import asyncio

    from talaia.hub.api.server.proxy_protocol import Asker

__all__ = ["HubProtocol"]

# Of a request line and all headers (bytes); uvicorn bounds them with its other parser only.
MAX_HEAD = 64 * 1024
# To send a whole head, and a whole body (s): who drips bytes must not hold a connection.
HEAD_S = 15.0
BODY_S = 60.0


class HubProtocol(HttpToolsProtocol):
    """One connection. Whoever dawdles or babbles is sent away, before it costs memory."""

    # Runs while something is due from the other side; there is one at most.
    _timer: asyncio.TimerHandle | None = None
    # Until a head is complete, and again from the next one on.
    _in_head = True
    _head = 0  # bytes of it so far
    # A whole head has come at least once; see `silent_connections`.
    spoken = False
    # Who comes, where a load balancer has said so; else the socket's other end.
    asker: Asker | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a head, but not for ever."""
        super().connection_made(transport)
        self.client = self.asker or self.client
        self._arm_timer(HEAD_S)

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._disarm_timer()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Count what a head has so far."""
        # The parser first: it calls back below when a head begins and ends within these bytes.
        super().data_received(data)
        if self._in_head and not self.transport.is_closing():
            self._head += len(data)
            if self._head > MAX_HEAD:
                self._end_request(431, "head", f"a request's head holds at most {MAX_HEAD} bytes")

    def on_message_begin(self) -> None:
        """Begin a head."""
        super().on_message_begin()
        self._in_head, self._head = True, 0
        self._arm_timer(HEAD_S)

    def on_headers_complete(self) -> None:
        """Go on to the body, which may take longer."""
        super().on_headers_complete()
        self._in_head, self.spoken = False, True
        self._arm_timer(BODY_S)

    def on_message_complete(self) -> None:
        """Wait no more; the next head is uvicorn's matter until it begins."""
        super().on_message_complete()
        self._disarm_timer()

    def handle_websocket_upgrade(self) -> None:
        """Hand the connection over."""
        # A socket stays open for days; its own limits hold from now on.
        self._disarm_timer()
        if self.asker is not None and self.ws_protocol_class is not None:
            # uvicorn only calls it, to make a protocol.
            self.ws_protocol_class = functools.partial(  # type: ignore[assignment]
                self.ws_protocol_class,
                asker=self.asker,  # type: ignore[call-arg]
            )
        super().handle_websocket_upgrade()

    def send_400_response(self, msg: str) -> None:
        """Say no in our form, with our headers."""
        self._end_request(400, "invalid", msg)

    def _end_request(self, status: int, code: str, message: str) -> None:
        # There may be no request yet that uvicorn could answer: it is written here by hand.
        self._disarm_timer()
        body = json.dumps({"code": code, "message": message}).encode()
        headers = [
            *guarding_headers("", tls=self.scheme == "https"),
            ("Content-Type", "application/problem+json"),
            ("Content-Length", str(len(body))),
            ("Cache-Control", "no-store"),
            ("Connection", "close"),
        ]
        lines = [f"HTTP/1.1 {status} {HTTPStatus(status).phrase}"]
        lines += [f"{name.lower()}: {value}" for name, value in headers]
        self.transport.write("\r\n".join(lines).encode("ascii") + b"\r\n\r\n" + body)
        # What is written goes out first.
        self.transport.close()

    def _arm_timer(self, seconds: float) -> None:
        self._disarm_timer()
        self._timer = self.loop.call_later(seconds, self._handle_timeout)

    def _disarm_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _handle_timeout(self) -> None:
        self._timer = None
        cycle: RequestResponseCycle | None = self.cycle
        if cycle is not None and cycle.response_started:
            # It has its answer; what it still sends is not wanted.
            self.transport.close()
        elif not self.transport.is_closing():
            self._end_request(408, "late", "the request took too long")
