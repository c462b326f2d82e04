"""The port at which Alpaca's clients are answered, and the answer to their discovery."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
from typing import TYPE_CHECKING, Any, cast

from talaia.bounded_http import HEAD_S, serve_bounded

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from contextlib import AbstractAsyncContextManager

__all__ = ["DISCOVERY_PORT", "answer_discovery", "serve_alpaca"]

DISCOVERY_PORT = 32_227
_DISCOVERY = b"alpacadiscovery"
_MOST_CONNECTIONS = 64


def serve_alpaca(
    application: Any,  # noqa: ANN401 - an ASGI application; uvicorn has no public type of it
    host: str,
    port: int,
    *,
    head_s: float = HEAD_S,
) -> AbstractAsyncContextManager[int]:
    """Serve within this context; gives the port. See `serve_bounded`."""
    return serve_bounded(application, host, port, most_connections=_MOST_CONNECTIONS, head_s=head_s)


class _DiscoveryAnswers(asyncio.DatagramProtocol):
    """Answers who asks from where the served address is reached."""

    def __init__(self, address: str, port: int) -> None:
        self._address, self._port = address, port
        self._transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the way back."""
        # asyncio's own is no subclass of it before Python 3.12.
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        """Answer a question; anything else gets no answer."""
        if self._transport is None or not data.startswith(_DISCOVERY):
            return
        # A broadcast comes by every interface, and is told to nobody beyond the chosen one.
        if _way_to(addr) == self._address:
            self._transport.sendto(json.dumps({"AlpacaPort": self._port}).encode(), addr)


def _way_to(addr: tuple[str, int]) -> str:
    """Give the address of ours from which somebody is reached; empty if there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as way:
        try:
            # UDP: nothing is sent, the system only chooses the way.
            way.connect(addr)
        except OSError:
            return ""
        return str(way.getsockname()[0])


@contextlib.asynccontextmanager
async def answer_discovery(
    address: str, port: int, *, at: int = DISCOVERY_PORT
) -> AsyncIterator[None]:
    """Answer Alpaca's discovery within this context.

    Args:
        address: where the server listens (IPv4).
        port: the server's.
        at: the port of the question.

    Raises:
        OSError: the port cannot be had.

    """
    loop = asyncio.get_running_loop()
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        # By ASCOM's text several servers of a computer share it.
        line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        # Broadcasts reach only who listens at every address.
        line.bind(("0.0.0.0", at))  # noqa: S104 - who may be answered is judged for each question
        line.setblocking(False)  # noqa: FBT003 - the library's own form
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _DiscoveryAnswers(address, port), sock=line
        )
    except BaseException:
        line.close()
        raise
    try:
        yield
    finally:
        transport.close()
