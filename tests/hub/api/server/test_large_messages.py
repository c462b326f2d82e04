"""Large messages arrive whole, in pieces that let others pass; frames for many at once."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
from typing import TYPE_CHECKING

import uvicorn
import websockets

from talaia.hub.api.server.large_messages import LARGEST_PIECE, HubSocketProtocol
from talaia.hub.live.gateways.link import MESSAGE_TAKER
from talaia.wire.socket_frame import FRAME_WRITER, SocketFrame

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

LARGE = os.urandom(10 * LARGEST_PIECE + 17)


@contextlib.asynccontextmanager
async def connected(
    serve: Callable[[Callable[[dict], Awaitable[None]]], Awaitable[None]],
) -> AsyncIterator[websockets.ClientConnection]:
    """Connect a client that we did not write to a server whose application is ``serve``."""

    async def app(_scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        await serve(send)
        await receive()

    async with connected_to(app) as client:
        yield client


@contextlib.asynccontextmanager
async def connected_to(app, **config) -> AsyncIterator[websockets.ClientConnection]:
    """The same, to an application of ASGI; ``config``: settings of uvicorn."""
    config = {"ws_per_message_deflate": False, **config}
    config = uvicorn.Config(app, ws=HubSocketProtocol, lifespan="off", log_config=None, **config)
    server = uvicorn.Server(config)
    listener = socket.create_server(("127.0.0.1", 0))
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    address = f"ws://127.0.0.1:{listener.getsockname()[1]}"
    try:
        async with websockets.connect(address, max_size=None, proxy=None) as client:
            yield client
    finally:
        server.should_exit = True
        await serving


def binary(data: bytes) -> dict[str, object]:
    return {"type": "websocket.send", "bytes": data}


async def test_large_messages_arrive_whole_and_in_order_though_several_tasks_send() -> None:
    async def serve(send) -> None:
        await asyncio.gather(
            send(binary(LARGE)),
            send({"type": "websocket.send", "text": "small"}),
            send(binary(LARGE[::-1])),
            send(binary(LARGE[:LARGEST_PIECE])),
        )

    async with connected(serve) as client:
        got = [await client.recv() for _ in range(4)]
    assert got == [LARGE, "small", LARGE[::-1], LARGE[:LARGEST_PIECE]]


async def test_whoever_else_has_something_to_do_does_it_between_the_pieces() -> None:
    turns = []

    async def count() -> None:
        while True:
            turns.append(1)
            await asyncio.sleep(0)

    async def serve(send) -> None:
        others = asyncio.create_task(count())
        await asyncio.sleep(0)
        before = len(turns)
        await send(binary(LARGE))
        turns.append(len(turns) - before)
        others.cancel()

    async with connected(serve) as client:
        assert await client.recv() == LARGE
        # Answered while the message is under way, or after: nothing of it stands within a frame.
        await (await client.ping())
    assert turns[-1] >= 10


async def test_a_message_that_is_broken_off_is_sent_to_its_end_so_that_others_can_follow() -> None:
    async def serve(send) -> None:
        sending = asyncio.create_task(send(binary(LARGE)))
        # Its first piece is out.
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        sending.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await sending
        await send({"type": "websocket.send", "text": "after it"})

    async with connected(serve) as client:
        assert await client.recv() == LARGE
        assert await client.recv() == "after it"


async def test_frames_hold_a_piece_at_most() -> None:
    async def serve(send) -> None:
        await send(binary(LARGE))

    async with connected(serve) as client:
        # One for each frame.
        sizes = [len(frame) async for frame in client.recv_streaming()]
    assert sum(sizes) == len(LARGE)
    assert max(sizes) == LARGEST_PIECE


async def test_messages_of_each_kind_of_length_arrive_as_they_were_sent() -> None:
    # RFC 6455 writes lengths up to 125, up to 65 535, and beyond in different ways.
    sizes = [0, 1, 125, 126, 127, 65_535, 65_536]
    messages = [os.urandom(size) for size in sizes]

    async def serve(send) -> None:
        for message in messages:
            await send(binary(message))
            await send({"type": "websocket.send", "text": str(len(message))})

    async with connected(serve) as client:
        for message in messages:
            assert await client.recv() == message
            assert await client.recv() == str(len(message))


async def test_nothing_is_written_after_the_farewell() -> None:
    refused: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    async def serve(send) -> None:
        await send({"type": "websocket.close", "code": 1000})
        try:
            await send(binary(b"late"))
        except RuntimeError as error:
            refused.set_result(str(error))
        else:
            refused.set_result("")

    async with connected(serve) as client:
        with contextlib.suppress(websockets.ConnectionClosed):
            assert await client.recv() is None
        assert "after sending 'websocket.close'" in await refused
        assert client.close_code == 1000


async def test_frames_written_for_many_and_messages_arrive_in_the_order_in_which_they_went() -> (
    None
):
    # RFC 6455 writes lengths up to 125, up to 65 535, and beyond in different ways.
    sent = [os.urandom(size) for size in (0, 125, 126, LARGEST_PIECE - 1, LARGEST_PIECE)]
    sent += ["", "ñ" * 100, "ñ" * 30_000]

    async def app(scope, receive, send):
        write = scope["extensions"][FRAME_WRITER]["write"]
        await receive()
        # Not before the other side is let in.
        assert not write(SocketFrame(b"early"))
        await send({"type": "websocket.accept"})
        for message in sent:
            assert write(SocketFrame(message))
            await send({"type": "websocket.send", "text": f"after {len(message)}"})
        await receive()

    async with connected_to(app) as client:
        for message in sent:
            assert await client.recv() == message
            assert await client.recv() == f"after {len(message)}"


async def test_one_frame_goes_to_everybody_with_the_same_bytes() -> None:
    frame = SocketFrame(b"\x01 for all")
    assert frame.framed is frame.framed
    assert frame.framed == b"\x82\x09\x01 for all"


async def test_no_frame_is_written_within_a_large_message_and_none_after_the_farewell() -> None:
    written = []

    async def app(scope, receive, send):
        write = scope["extensions"][FRAME_WRITER]["write"]
        await receive()
        await send({"type": "websocket.accept"})
        sending = asyncio.create_task(send(binary(LARGE)))
        # Its first piece is out.
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        written.append(write(SocketFrame(b"between")))
        await sending
        written.append(write(SocketFrame(b"after")))
        # Larger than what goes in one frame.
        written.append(write(SocketFrame(LARGE)))
        await send({"type": "websocket.close"})
        written.append(write(SocketFrame(b"late")))

    async with connected_to(app) as client:
        assert await client.recv() == LARGE
        assert await client.recv() == b"after"
        with contextlib.suppress(websockets.ConnectionClosed):
            assert await client.recv() is None
    assert written == [False, True, False, False]


async def test_who_does_not_read_is_written_no_more_than_a_little_and_gets_that_whole() -> None:
    frames = [SocketFrame(number.to_bytes(4) * 4096) for number in range(2_000)]
    taken: asyncio.Future[int] = asyncio.get_running_loop().create_future()

    async def app(scope, receive, send):
        write = scope["extensions"][FRAME_WRITER]["write"]
        await receive()
        await send({"type": "websocket.accept"})
        count = 0
        # The other side reads nothing yet: what the kernel takes is all it gets.
        while count < len(frames) and write(frames[count]):
            count += 1
            await asyncio.sleep(0)
        taken.set_result(count)
        await send({"type": "websocket.send", "text": "the end"})
        await receive()

    async with connected_to(app) as client:
        client.transport.pause_reading()
        count = await taken
        # 32 MB were there to be sent.
        assert count < len(frames)
        client.transport.resume_reading()
        assert [await client.recv() for _ in range(count)] == [one.data for one in frames[:count]]
        assert await client.recv() == "the end"


async def test_a_socket_that_compresses_is_written_nothing_past_its_extension() -> None:
    async def app(scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        wrote = scope["extensions"][FRAME_WRITER]["write"](SocketFrame(b"plain"))
        await send({"type": "websocket.send", "text": str(wrote)})
        await receive()

    async with connected_to(app, ws_per_message_deflate=True) as client:
        assert await client.recv() == "False"


async def test_what_is_said_is_offered_as_it_comes_and_what_is_not_taken_is_queued() -> None:
    taken, queued = [], []
    large = os.urandom(300_000)

    def take(data: bytes) -> bool:
        if data.startswith(b"no"):
            return False
        taken.append(data)
        return True

    async def app(scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        scope["extensions"][MESSAGE_TAKER]["begin"](take)
        await send(binary(b"go"))
        while (event := await receive())["type"] != "websocket.disconnect":
            queued.append(event.get("bytes", event.get("text")))
            await send(binary(b"from the queue"))

    async with connected_to(app) as client:
        assert await client.recv() == b"go"
        await client.send(b"one")
        await client.send(large)
        await (await client.ping())
        assert taken == [b"one", large]
        # Of several frames, and text: both are the parser's; and what is not taken.
        for message in ([b"in ", b"pieces"], "words", b"no, wait"):
            await client.send(message)
            assert await client.recv() == b"from the queue"
        await client.send(b"two")
        await (await client.ping())
    assert taken == [b"one", large, b"two"]
    assert queued == [b"in pieces", "words", b"no, wait"]


async def test_what_comes_behind_something_that_is_queued_does_not_pass_it() -> None:
    order, go_on = [], asyncio.Event()

    def take(data: bytes) -> bool:
        order.append(data)
        return True

    async def app(scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        scope["extensions"][MESSAGE_TAKER]["begin"](take)
        await send(binary(b"go"))
        await go_on.wait()
        while (event := await receive())["type"] != "websocket.disconnect":
            order.append(event.get("bytes", event.get("text")))

    async with connected_to(app) as client:
        assert await client.recv() == b"go"
        for message in ("words", b"bytes", "more", b"last"):
            await client.send(message)
        go_on.set()
        await (await client.ping())
    assert order == ["words", b"bytes", "more", b"last"]


async def test_a_message_that_is_too_large_ends_the_connection_as_before() -> None:
    async def app(scope, receive, send):
        await receive()
        await send({"type": "websocket.accept"})
        while (await receive())["type"] != "websocket.disconnect":
            pass

    async with connected_to(app, ws_max_size=1000) as client:
        await client.send(bytes(1000))
        await client.send(bytes(1001))
        await client.wait_closed()
        assert client.close_code == 1009
