"""HTTP and WebSockets at a port of the gateway's own, as uvicorn reads them, with bounds."""

from __future__ import annotations

import asyncio
import contextlib
from typing import TYPE_CHECKING, Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.server import ServerState

from talaia.wire.socketio.engine_packets import MAX_SOCKETIO_BODY

if TYPE_CHECKING:
    import ssl
    from collections.abc import AsyncIterator

__all__ = ["serve_application"]

# TCP connections at once; those over it are answered 503.
_MOST_CONNECTIONS = 128
# To send a whole head (s): who drips bytes must not hold a connection.
_HEAD_S = 15.0
# Until a connection without a request is closed (s).
_IDLE_S = 30
# For those who are still in, at the end (s).
_FAREWELL_S = 1.0


class _BoundedProtocol(H11Protocol):
    """One connection; who does not send a whole head in time is sent away."""

    _timer: asyncio.TimerHandle | None = None

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
        elif self._timer is None:
            self._timer = self.loop.call_later(_HEAD_S, self.transport.abort)

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


@contextlib.asynccontextmanager
async def serve_application(
    application: Any,  # noqa: ANN401 - an ASGI application; uvicorn has no public type of it
    host: str,
    port: int,
    tls: ssl.SSLContext | None,
) -> AsyncIterator[None]:
    """Serve within this context.

    Raises:
        OSError: the port cannot be had.

    """
    config = uvicorn.Config(
        application,
        http=_BoundedProtocol,
        ws="websockets-sansio",
        # The gateway's own loop runs already, and there is nothing to begin with it.
        loop="none",
        lifespan="off",
        limit_concurrency=_MOST_CONNECTIONS,
        ws_max_size=MAX_SOCKETIO_BODY,
        # Compressing each frame would take the loop's time, and pictures are packed already.
        ws_per_message_deflate=False,
        # Engine.IO has a beat of its own.
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
        lambda: config.http_protocol_class(  # type: ignore[call-arg]
            config=config, server_state=state, app_state={}, _loop=loop
        ),
        host,
        port,
        ssl=tls,
    )
    try:
        yield
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
