"""An ASGI application at a port of its own, beside what the process does else, with bounds."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING, Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from uvicorn.server import ServerState
from websockets.exceptions import InvalidState

if TYPE_CHECKING:
    import ssl
    from collections.abc import AsyncIterator

__all__ = ["HEAD_S", "EndingSocketProtocol", "serve_bounded"]

# To send a whole head (s): who says nothing, or drips bytes, must not hold a connection.
HEAD_S = 15.0
# Until a connection without another request is closed (s).
_IDLE_S = 30
# For those who are still in, at the end (s).
_FAREWELL_S = 1.0


class EndingSocketProtocol(WebSocketsSansIOProtocol):
    """One WebSocket of uvicorn's, whose server ends whatever the other side is just doing."""

    async def send(self, message: Any) -> None:  # noqa: ANN401 - uvicorn's own
        """Pass on what the application says."""
        await super().send(message)
        # A refusal that is whole is an answer, too: uvicorn would log it as a fault of ours, each
        # time that a gateway asks what it has to prove.
        if self.initial_response is not None and self.close_sent:
            self.handshake_complete = True

    def send_500_response(self) -> None:
        """Refuse who is not in yet, unless the line is gone or the refusal has been sent."""
        # To write to a line that is closed is an error of uvloop's.
        if not (self.transport.is_closing() or self.conn.eof_sent):
            super().send_500_response()

    def shutdown(self) -> None:
        """Say good-bye at the server's end."""
        try:
            super().shutdown()
        except (InvalidState, RuntimeError):
            # The other side has said it first, or the line was lost a moment ago, to which uvloop
            # lets nobody write. The error would end the server's own end, and with it that of
            # everything after this connection.
            self.transport.close()


class _BoundedProtocol(H11Protocol):
    """One connection; who does not send a whole head in time is sent away."""

    def __init__(self, *, head_s: float, **more: Any) -> None:  # noqa: ANN401 - uvicorn's own
        super().__init__(**more)
        self._head_s = head_s
        # Runs while a head is waited for.
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a head, but not for ever."""
        super().connection_made(transport)
        self._watch_head()

    def data_received(self, data: bytes) -> None:
        """Go on waiting for a head, or stop."""
        super().data_received(data)
        self._watch_head()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._stop_timer()
        super().connection_lost(exc)

    def _watch_head(self) -> None:
        if self.conn.their_state is not h11.IDLE:
            self._stop_timer()
        # Bytes that come do not begin it anew: all of a head has one time.
        elif self._timer is None:
            self._timer = self.loop.call_later(self._head_s, self.transport.abort)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


@contextlib.asynccontextmanager
async def serve_bounded(
    application: Any,  # noqa: ANN401 - an ASGI application; uvicorn has no public type of it
    host: str,
    port: int,
    *,
    most_connections: int,
    tls: ssl.SSLContext | None = None,
    websocket_bytes: int = 0,
    head_s: float = HEAD_S,
) -> AsyncIterator[int]:
    """Serve within this context; give the port.

    Args:
        application: an ASGI application.
        host: the address to listen at.
        port: 0 takes a free one.
        most_connections: TCP connections at once; those over it are answered 503.
        tls: none for plain HTTP.
        websocket_bytes: the largest message of a WebSocket; 0: there are none.
        head_s: a head has to come whole within so long.

    Raises:
        OSError: the address or port cannot be had.

    """
    config = uvicorn.Config(
        application,
        ws=EndingSocketProtocol if websocket_bytes else "none",
        # The process's own loop runs already, and there is nothing to begin with it.
        loop="none",
        lifespan="off",
        limit_concurrency=most_connections,
        ws_max_size=websocket_bytes,
        # Compressing each frame would take the loop's time, and pictures are packed already.
        ws_per_message_deflate=False,
        # What is served here has a beat of its own.
        ws_ping_interval=None,
        proxy_headers=False,
        server_header=False,
        # Addresses hold tokens.
        access_log=False,
        log_config=None,
        log_level="warning",
        timeout_keep_alive=_IDLE_S,
    )
    config.load()
    state, loop = ServerState(), asyncio.get_running_loop()
    server = await loop.create_server(
        lambda: _BoundedProtocol(
            head_s=head_s, config=config, server_state=state, app_state={}, _loop=loop
        ),
        host,
        port,
        ssl=tls,
    )
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        server.close()
        for connection in list(state.connections):
            connection.shutdown()
        if state.tasks:
            # Requests that wait have been answered by who closed their lines.
            await asyncio.wait(set(state.tasks), timeout=_FAREWELL_S)
        for connection in list(state.connections):
            connection.transport.abort()
        for task in list(state.tasks):
            task.cancel()
