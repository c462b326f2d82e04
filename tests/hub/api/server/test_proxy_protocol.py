"""Who comes through a load balancer: its word is believed, and nobody else's."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import ipaddress
import socket
import struct

import pytest
from hypothesis import given, settings, strategies as st

from talaia.hub.api.server.accept_queue import AcceptQueue
from talaia.hub.api.server.proxy_protocol import (
    Balancers,
    NoProxyHeader,
    read_asker,
    receive_asker,
)

SIGNATURE = b"\r\n\r\n\0\r\nQUIT\n"
LOOPBACK = Balancers([ipaddress.ip_network("127.0.0.0/8")])


def header(source: str, port: int, command: int = 0x21, more: bytes = b"") -> bytes:
    """Write a header as "The PROXY protocol" (2.2) has it."""
    address = ipaddress.ip_address(source)
    family = 0x11 if address.version == 4 else 0x21
    body = address.packed * 2 + struct.pack("!HH", port, 443) + more
    return SIGNATURE + struct.pack("!BBH", command, family, len(body)) + body


class Known(asyncio.Protocol):
    """A protocol that keeps who comes, and the first that they say."""

    asker = None

    def __init__(self, came: asyncio.Queue) -> None:
        self._came = came

    def data_received(self, data: bytes) -> None:
        self._came.put_nowait((self.asker, data))


async def heard(said: bytes, balancers: Balancers) -> tuple[object, bytes] | bytes:
    """Connect and say something; give what the server makes of it, or how it hangs up."""
    came: asyncio.Queue = asyncio.Queue()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        queue = AcceptQueue(listener, lambda: Known(came), None, balancers=balancers)
        queue.open()
        reader, writer = await asyncio.open_connection(*listener.getsockname())
        writer.write(said)
        ends = [asyncio.ensure_future(reader.read(1)), asyncio.ensure_future(came.get())]
        done, left = await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        for task in left:
            task.cancel()
        await queue.close()
        writer.close()
        try:
            return done.pop().result()
        except ConnectionResetError:
            return b""


@pytest.mark.parametrize("source", ["192.0.2.7", "2001:db8::7"])
async def test_a_listed_balancer_says_who_comes_and_the_rest_is_theirs(source: str) -> None:
    more = b"\x02\0\x0bhub.example"
    assert await heard(header(source, 4711, more=more) + b"hello", LOOPBACK) == (
        (source, 4711),
        b"hello",
    )


async def test_a_balancers_own_check_comes_from_the_balancer() -> None:
    assert await heard(header("192.0.2.7", 1, command=0x20) + b"hello", LOOPBACK) == (
        None,
        b"hello",
    )


async def test_nobody_else_is_believed() -> None:
    said = header("192.0.2.7", 4711)
    for balancers in (Balancers(), Balancers([ipaddress.ip_network("10.0.0.9")])):
        assert await heard(said, balancers) == (None, said)


@pytest.mark.parametrize(
    "said",
    [
        b"GET / HTTP/1.1\r\n\r\n",
        b"PROXY TCP4 192.0.2.7 192.0.2.8 1 2\r\n",
        header("192.0.2.7", 1, command=0x31),
        SIGNATURE + struct.pack("!BBH", 0x21, 0x11, 4) + b"\1\2\3\4",
        SIGNATURE + struct.pack("!BBH", 0x21, 0x11, 60_000),
    ],
)
async def test_a_balancer_that_says_anything_else_is_hung_up_on(said: bytes) -> None:
    assert await heard(said, LOOPBACK) == b""


@given(st.binary(min_size=4, max_size=4), st.binary(max_size=80))
@settings(deadline=None)
def test_any_header_is_read_or_refused(word: bytes, body: bytes) -> None:
    try:
        asker = read_asker(SIGNATURE + word, body)
    except NoProxyHeader:
        return
    assert asker is None or ipaddress.ip_address(asker[0])


async def test_a_header_in_pieces_is_waited_for() -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.settimeout(0)
        loop = asyncio.get_running_loop()
        asking = asyncio.create_task(receive_asker(loop, ours))
        for byte in header("192.0.2.7", 4711):
            await loop.sock_sendall(theirs, bytes([byte]))
            await asyncio.sleep(0)
        assert await asking == ("192.0.2.7", 4711)
