"""Whoever has dialled is served or turned away, also while the queue ends."""

from __future__ import annotations

import asyncio
import socket

import pytest

from talaia.hub.api.server.accept_queue import AcceptQueue

# The turns of the loop from a connection that stands in the kernel's queue to its protocol.
TURNS = 6


@pytest.mark.parametrize("turns", range(TURNS))
async def test_nobody_is_left_open_whenever_the_queue_ends(turns: int) -> None:
    made: list[asyncio.BaseTransport] = []

    class Protocol(asyncio.Protocol):
        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            made.append(transport)

    with socket.create_server(("127.0.0.1", 0)) as listener:
        queue = AcceptQueue(listener, Protocol, None)
        queue.open()
        # Waits for arrivals.
        await asyncio.sleep(0)
        with socket.create_connection(listener.getsockname()) as caller:
            for _ in range(turns):
                await asyncio.sleep(0)
            await queue.close()
            caller.settimeout(5.0)
            if made:
                made[0].close()
            listener.close()
            try:
                assert await asyncio.to_thread(caller.recv, 1) == b""
            except ConnectionResetError:
                # It stood in the kernel's queue still.
                assert not made
