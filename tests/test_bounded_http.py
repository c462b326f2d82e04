"""A port of its own: who does not send a whole head in time is sent away, and nobody else."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
import uvicorn
from patience import PATIENCE_S
from uvicorn.server import ServerState
from websockets.client import ClientProtocol
from websockets.uri import parse_uri

from talaia.bounded_http import EndingSocketProtocol, serve_bounded
from talaia.hub.clients.alpaca.listener import serve_alpaca

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

HEAD_S = 0.3
REQUEST = b"GET / HTTP/1.1\r\nHost: here\r\n\r\n"


class Answers:
    """An application that answers when it may."""

    def __init__(self) -> None:  # noqa: D107
        self.may = asyncio.Event()

    async def __call__(self, _scope: Any, _receive: Any, send: Any) -> None:
        await self.may.wait()
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"fine"})


@asynccontextmanager
async def connected(port: int) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        yield reader, writer
    finally:
        writer.close()


async def until_closed(reader: asyncio.StreamReader) -> None:
    try:
        async with asyncio.timeout(PATIENCE_S):
            assert await reader.read() == b""
    except ConnectionResetError:
        pass


@pytest.mark.parametrize("sent", [b"", REQUEST[:20]], ids=["nothing", "half a head"])
async def test_client_of_the_alpaca_port_that_sends_no_whole_head_is_sent_away(sent: bytes) -> None:
    async with (
        serve_alpaca(Answers(), "127.0.0.1", 0, head_s=HEAD_S) as port,
        connected(port) as (reader, writer),
    ):
        writer.write(sent)
        await until_closed(reader)


async def test_client_that_drips_bytes_is_sent_away_all_the_same() -> None:
    serving = serve_bounded(Answers(), "127.0.0.1", 0, most_connections=4, head_s=HEAD_S)
    async with serving as port, connected(port) as (reader, writer):
        closed = asyncio.create_task(until_closed(reader))
        async with asyncio.timeout(PATIENCE_S):
            # Longer than the time as a whole, and never silent for as long.
            while not closed.done():
                writer.write(b"G")
                await asyncio.wait({closed}, timeout=HEAD_S / 10)
        await closed


async def test_answer_that_takes_longer_than_a_head_may_is_waited_for() -> None:
    application = Answers()
    serving = serve_bounded(application, "127.0.0.1", 0, most_connections=4, head_s=HEAD_S)
    async with serving as port, connected(port) as (reader, writer), connected(port) as (other, _):
        writer.write(REQUEST)
        # The other's time, which began no earlier, is over.
        await until_closed(other)
        application.may.set()
        assert (await reader.readline()).startswith(b"HTTP/1.1 200")


async def test_connections_over_the_bound_are_answered_503() -> None:
    application = Answers()
    application.may.set()
    serving = serve_bounded(application, "127.0.0.1", 0, most_connections=1)
    async with serving as port, connected(port), connected(port) as (reader, writer):
        writer.write(REQUEST)
        assert (await reader.readline()).startswith(b"HTTP/1.1 503")


class StuckTransport(asyncio.Transport):
    """One that has been closed, and still has something to send to whoever does not read."""

    def __init__(self) -> None:  # noqa: D107
        super().__init__()
        self.written: list[bytes] = []
        self.closed = 0

    def write(self, data: bytes | bytearray | memoryview) -> None:
        self.written.append(bytes(data))

    def close(self) -> None:
        self.closed += 1

    def is_closing(self) -> bool:
        return bool(self.closed)


class LostTransport(StuckTransport):
    """One of uvloop's, whose line is gone and whose protocol has not heard of it yet."""

    def write(self, data: bytes | bytearray | memoryview) -> None:
        if self.closed:
            raise RuntimeError("unable to perform operation; the handler is closed")
        super().write(data)


class JoinedSocket(NamedTuple):
    """The server's end of a WebSocket, its line, and the client's end."""

    protocol: EndingSocketProtocol
    transport: StuckTransport
    client: ClientProtocol


def join(app: Any, transport: StuckTransport) -> JoinedSocket:
    """Let a client ask for a socket."""
    config = uvicorn.Config(app, lifespan="off", log_config=None)
    config.load()
    protocol = EndingSocketProtocol(config, ServerState(), {})
    protocol.connection_made(transport)
    client = ClientProtocol(parse_uri("ws://localhost/"))
    client.send_request(client.connect())
    protocol.data_received(b"".join(client.data_to_send()))
    return JoinedSocket(protocol, transport, client)


async def test_server_ends_while_a_client_that_said_good_bye_has_not_read_all() -> None:
    accepted = asyncio.Event()

    async def app(_scope: object, receive: Any, send: Any) -> None:
        await receive()
        await send({"type": "websocket.accept"})
        accepted.set()
        await receive()

    protocol, transport, client = join(app, StuckTransport())
    await asyncio.wait_for(accepted.wait(), PATIENCE_S)
    client.receive_data(b"".join(transport.written))
    client.send_close(1000)
    protocol.data_received(b"".join(client.data_to_send()))
    assert transport.closed == 1
    protocol.shutdown()
    assert transport.closed == 2


@pytest.mark.parametrize("is_in", [False, True], ids=["not let in yet", "let in"])
async def test_server_ends_while_the_line_of_a_client_is_lost(
    caplog: pytest.LogCaptureFixture, *, is_in: bool
) -> None:
    reached, ended = asyncio.Event(), asyncio.Event()

    async def app(_scope: object, receive: Any, send: Any) -> None:
        await receive()
        if is_in:
            await send({"type": "websocket.accept"})
        reached.set()
        try:
            await asyncio.Future()
        finally:
            ended.set()

    protocol, transport, _ = join(app, LostTransport())
    await asyncio.wait_for(reached.wait(), PATIENCE_S)
    transport.close()
    protocol.shutdown()
    # What the server does next, with those who are still at something.
    for task in list(protocol.tasks):
        task.cancel()
    await asyncio.wait_for(ended.wait(), PATIENCE_S)
    await asyncio.gather(*protocol.tasks)
    assert "AssertionError" not in caplog.text
    assert "RuntimeError" not in caplog.text
