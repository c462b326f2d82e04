"""Sockets that say nothing: bounded for each address, and those who speak come first."""

from __future__ import annotations

import asyncio
import datetime as dt
import ipaddress
import socket
import ssl

import pytest
from patience import PATIENCE_S

from talaia.hub.api.server.accept_queue import AcceptQueue
from talaia.hub.api.server.anonymous_requests import AnonymousRequests
from talaia.hub.api.server.silent_connections import (
    MOST_AT_ALL,
    MOST_SILENT,
    SILENT_S,
    SilentConnections,
    defer_silent,
)
from talaia.hub.certificate import own_certificate
from talaia.hub.settings import Settings


class Open:
    """A connection as its transport and its protocol show it."""

    def __init__(self, *, spoken: bool = False) -> None:  # noqa: D107
        self.spoken, self.closed = spoken, False

    def is_closing(self) -> bool:
        return self.closed

    def abort(self) -> None:
        self.closed = True


def arrive(silent: SilentConnections, address: str, now_s: float, *, spoken: bool = False):
    arrival = silent.add_arrival(address, now_s)
    if arrival is None:
        return None
    arrival.transport = arrival.protocol = Open(spoken=spoken)
    return arrival.transport


@pytest.mark.pure
def test_longest_silent_of_an_address_goes_and_nobody_else() -> None:
    silent = SilentConnections()
    speaking = [arrive(silent, "192.0.2.7", 0.0, spoken=True) for _ in range(200)]
    held = [arrive(silent, "192.0.2.7", 0.0) for _ in range(MOST_SILENT)]
    other = arrive(silent, "192.0.2.8", 0.0)
    arrive(silent, "192.0.2.7", SILENT_S + 0.1)
    assert [each.closed for each in held] == [True] + [False] * (MOST_SILENT - 1)
    assert not any(each.closed for each in [*speaking, other])


@pytest.mark.pure
def test_crowd_that_has_just_come_is_not_taken_for_silent_and_has_an_end_all_the_same() -> None:
    silent = SilentConnections()
    crowd = [arrive(silent, "192.0.2.7", 0.0) for _ in range(MOST_AT_ALL)]
    assert not any(each.closed for each in crowd)
    assert arrive(silent, "192.0.2.7", SILENT_S / 2) is None
    # One household of IPv6 counts as one; a listed proxy is many.
    v6 = SilentConnections([ipaddress.ip_network("10.0.0.0/8")])
    many = [arrive(v6, f"2001:db8::{number:x}", 0.0) for number in range(MOST_SILENT)]
    arrive(v6, "2001:db8::ffff", SILENT_S + 0.1)
    assert many[0].closed
    behind = [arrive(v6, "10.1.2.3", 0.0) for _ in range(MOST_AT_ALL)]
    assert arrive(v6, "10.1.2.3", SILENT_S + 0.1) is not None
    assert not any(each.closed for each in behind)


@pytest.mark.pure
def test_unsigned_requests_of_an_address_are_bounded_and_signed_ones_are_not() -> None:
    requests = AnonymousRequests(most=2)
    asker, cookie = "192.0.2.7", {"cookie": "talaia=x"}
    first = requests.count(asker, {}, unasked=False)
    # Where nobody looks who it is, a made-up cookie is no sign-in.
    second = requests.count(asker, cookie, unasked=True)
    assert first.__enter__()
    assert second.__enter__()
    for headers, unasked in (({}, False), ({}, True), (cookie, True)):
        with requests.count(asker, headers, unasked=unasked) as allowed:
            assert not allowed
    with requests.count(asker, cookie, unasked=False) as allowed:
        assert allowed
    with requests.count("192.0.2.8", {}, unasked=True) as allowed:
        assert allowed
    first.__exit__(None, None, None)
    with requests.count(asker, {}, unasked=False) as allowed:
        assert allowed
    second.__exit__(None, None, None)


@pytest.mark.skipif(not hasattr(socket, "TCP_DEFER_ACCEPT"), reason="the system has none")
def test_system_keeps_a_connection_to_itself_until_it_says_something() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        defer_silent(listener)
        listener.settimeout(0)
        with socket.create_connection(listener.getsockname()) as silent:
            with pytest.raises(BlockingIOError):
                listener.accept()
            silent.sendall(b"hello")
            listener.settimeout(PATIENCE_S)
            connection, _ = listener.accept()
            assert connection.recv(5) == b"hello"
            connection.close()


class Echo(asyncio.Protocol):
    spoken = False

    def connection_made(self, transport) -> None:
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        self.spoken = True
        self.transport.write(data)


async def test_hundreds_that_say_nothing_are_let_go_when_somebody_comes(tmp_path) -> None:
    made = own_certificate(Settings(data=tmp_path, host="127.0.0.1"), dt.datetime.now(dt.UTC))
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.load_cert_chain(made.cert, made.key)
    trust = ssl.create_default_context(cafile=str(made.cert))
    trust.check_hostname = False
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        doorway = AcceptQueue(listener, Echo, server)
        doorway.open()
        silent = await asyncio.gather(
            *(asyncio.open_connection("127.0.0.1", port) for _ in range(400))
        )
        ended = [asyncio.create_task(reader.read()) for reader, _ in silent]
        async with asyncio.timeout(PATIENCE_S):
            # Each that comes lets go of those that were silent for long enough.
            while sum(task.done() for task in ended) < 400 - MOST_SILENT:
                reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=trust)
                writer.write(b"hello")
                assert await reader.readexactly(5) == b"hello"
                writer.close()
        assert sum(task.done() for task in ended) <= 400 - MOST_SILENT + 1
        for task, (_, writer) in zip(ended, silent, strict=True):
            task.cancel()
            writer.transport.abort()
        await asyncio.gather(*ended, return_exceptions=True)
        await doorway.close()
