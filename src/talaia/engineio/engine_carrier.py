"""A WebSocket that carries a client's line of Engine.IO, from the first frame or after polls."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from talaia.engineio.engine_connection import LineGone
from talaia.first_completed import until_first
from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import EngineKind, decode_frame, encode_frame

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.engineio.engine_connection import EngineConnection
    from talaia.wire.socketio.engine_packets import EnginePacket

__all__ = ["FrameSocket", "serve_socket"]


class FrameSocket(Protocol):
    """A WebSocket that is open."""

    async def receive_frame(self) -> str | bytes:
        """Wait for a frame; raises `LineGone` when the client has gone."""
        ...

    async def send_frame(self, frame: str | bytes) -> None:
        """Send one; raises `LineGone` when the client has gone."""
        ...

    async def close_socket(self, code: int) -> None:
        """Close it, if the client was not quicker."""
        ...


async def serve_socket(socket: FrameSocket, line: EngineConnection, *, polled: bool) -> None:
    """Carry a line until it or the socket ends; a socket that takes nothing over is closed.

    Args:
        socket: it is open.
        line: whose packets it carries.
        polled: requests have carried it up to now, and go on if the client does not change over.

    """
    try:
        if polled:
            await _take_over(socket, line)
        else:
            await line.end_upgrade(done=True)
            await _send_packets(socket, line, [line.opening_packet(upgrades=False)])
        if line.is_on_socket:
            await _carry_line(socket, line)
    except LineGone:
        pass
    finally:
        # A polled session whose upgrade came to nothing goes on without.
        if line.is_on_socket or not polled:
            await line.close_line()


async def _carry_line(socket: FrameSocket, line: EngineConnection) -> None:
    results = await until_first(_read_socket(socket, line), _write_socket(socket, line))
    for result in results:
        if isinstance(result, PeerError):
            await line.close_line(result.code)
        elif isinstance(result, Exception) and not isinstance(result, LineGone):
            raise result
    await socket.close_socket(line.close_code)


async def _take_over(socket: FrameSocket, line: EngineConnection) -> None:
    """Let a WebSocket carry a session that was polled, if it does as the protocol says."""
    offered = done = False
    try:
        answer = await line.offer_upgrade(await _receive_packet(socket, line))
        offered = True
        await _send_packets(socket, line, [answer])
        done = (await _receive_packet(socket, line)).kind is EngineKind.UPGRADE
    except (PeerError, LineGone):
        # The polled session is as good as before.
        pass
    finally:
        if offered:
            await line.end_upgrade(done=done)
    if not done:
        await socket.close_socket(1002)


async def _read_socket(socket: FrameSocket, line: EngineConnection) -> None:
    while not line.is_closed:
        await line.receive_packet(await _receive_packet(socket, line))


async def _write_socket(socket: FrameSocket, line: EngineConnection) -> None:
    # It ends by `LineGone`, once the line is closed and nothing waits.
    while True:
        await _send_packets(socket, line, await line.pull_packets())


async def _receive_packet(socket: FrameSocket, line: EngineConnection) -> EnginePacket:
    return decode_frame(await socket.receive_frame(), line.revision)


async def _send_packets(
    socket: FrameSocket, line: EngineConnection, packets: Iterable[EnginePacket]
) -> None:
    for packet in packets:
        await socket.send_frame(encode_frame(packet, line.revision))
