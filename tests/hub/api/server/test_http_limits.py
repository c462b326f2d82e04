"""What is refused before it reaches a route: sizes, smuggling, hosts, slow and strange requests."""

from __future__ import annotations

import asyncio
import os

import psutil
import pytest

from talaia.hub.api.server import http_limits
from talaia.hub.api.server.http_limits import MAX_HEAD

from ...everyone.wires import read, request, say

MEBI = 1024 * 1024
pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest.fixture
def hub(shared_hub):
    """Nothing here gets as far as to change something."""
    return shared_hub


@pytest.fixture
def host(hub) -> str:
    return f"127.0.0.1:{hub.port}"


SMUGGLED = {
    "length and chunks": ["Content-Length: 4", "Transfer-Encoding: chunked"],
    "chunks and length": ["Transfer-Encoding: chunked", "Content-Length: 4"],
    "two lengths": ["Content-Length: 4", "Content-Length: 5"],
    "two lengths in one": ["Content-Length: 4, 5"],
    "a length with a sign": ["Content-Length: +4"],
    "a length in hexadecimal": ["Content-Length: 0x4"],
    "a length before a space": ["Content-Length : 4"],
    "chunks that are none": ["Transfer-Encoding: xchunked", "Content-Length: 4"],
    "chunks twice": ["Transfer-Encoding: chunked", "Transfer-Encoding: identity"],
    "a folded head": ["X-One: 1", " Transfer-Encoding: chunked", "Content-Length: 4"],
    "a head without a colon": ["Content-Length 4"],
    "a control character": ["X-One: \x01"],
}


@pytest.mark.parametrize("how", SMUGGLED)
async def test_request_of_two_meanings_is_400_and_the_connection_ends(hub, host, how) -> None:
    head = request(
        "/api/login",
        "Content-Type: application/json",
        f"Origin: http://{host}",
        *SMUGGLED[how],
        method="POST",
        host=host,
    )
    reader, writer = await asyncio.open_connection("127.0.0.1", hub.port)
    writer.write(head + b"0\r\n\r\n" + request(host=host))
    answer = await read(reader)
    # Refused whole, and what followed is not taken for a request of its own.
    assert answer.status in {400, 411}, answer
    if answer.status == 400:
        assert (await read(reader)).status == 0
    writer.close()


async def test_length_and_chunks_together_are_400(hub, host) -> None:
    answer = await say(
        hub.port,
        request(
            "/api/login",
            *SMUGGLED["length and chunks"],
            "Content-Type: application/json",
            method="POST",
            host=host,
        ),
    )
    assert answer.status == 400
    assert answer.headers["connection"] == "close"


@pytest.mark.parametrize(
    "garbage",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"\x00" * 64,
        b"GET http://[ HTTP/1.1\r\nHost: x\r\n\r\n",
        b"GET /\xff\xfe HTTP/1.1\r\nHost: x\r\n\r\n",
    ],
)
async def test_garbage_is_answered_in_our_form_with_our_headers(hub, garbage) -> None:
    answer = await say(hub.port, garbage)
    assert answer.status in {400, 421}
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]
    assert b"Traceback" not in answer.body


async def test_body_of_ten_gigabytes_is_413_early_and_memory_stays_flat(hub, host) -> None:
    head = request(
        "/api/login",
        "Content-Type: application/json",
        f"Origin: http://{host}",
        f"Content-Length: {10 * 1024 * MEBI}",
        method="POST",
        host=host,
    )
    reader, writer = await asyncio.open_connection("127.0.0.1", hub.port)
    writer.write(head)
    # The answer is there before the first byte of the body.
    answer = await read(reader)
    assert answer.status == 413
    before = psutil.Process().memory_info().rss
    chunk = os.urandom(MEBI)
    try:
        for _ in range(64):
            writer.write(chunk)
            await writer.drain()
    except (ConnectionResetError, BrokenPipeError):
        pass
    assert psutil.Process().memory_info().rss - before < 16 * MEBI
    writer.close()
    assert (await say(hub.port, request(host=host))).status == 200


async def test_body_without_a_length_is_refused_before_it_is_read(hub, host) -> None:
    answer = await say(
        hub.port,
        request(
            "/api/login",
            "Content-Type: application/json",
            "Transfer-Encoding: chunked",
            method="POST",
            host=host,
        ),
    )
    assert answer.status == 411


async def test_head_that_does_not_end_is_431_and_memory_stays_flat(hub, host) -> None:
    head = b"GET / HTTP/1.1\r\nHost: " + host.encode()
    line = b"\r\nX-More: " + b"x" * 8192
    answer = await say(hub.port, head, *[line] * (2 * MAX_HEAD // len(line)))
    assert answer.status == 431
    assert answer.headers["connection"] == "close"


async def test_who_dawdles_over_a_request_is_sent_away(hub, host, monkeypatch) -> None:
    monkeypatch.setattr(http_limits, "HEAD_S", 0.05)
    monkeypatch.setattr(http_limits, "BODY_S", 0.05)
    silent = await say(hub.port)
    half_a_head = await say(hub.port, b"GET / HTTP/1.1\r\n")
    half_a_body = await say(
        hub.port,
        request(
            "/api/login",
            "Content-Type: application/json",
            f"Origin: http://{host}",
            "Content-Length: 10",
            method="POST",
            host=host,
        ),
        b"{",
    )
    assert [each.status for each in (silent, half_a_head, half_a_body)] == [408, 408, 408]


@pytest.mark.parametrize(
    ("named", "status"),
    [
        ("127.0.0.1:{port}", 200),
        ("LOCALHOST:{port}", 200),
        ("[::1]:{port}", 200),
        ("evil.test", 421),
        ("127.0.0.1.evil.test:{port}", 421),
        ("evil.test:{port}@127.0.0.1", 421),
        ("localhost:{port}.evil", 421),
        ("127.0.0.1:{port}.evil.test", 421),
        ("127.0.0.1, evil.test", 421),
        ("127.0.0.2:{port}", 421),
        ("", 421),
        ("localhost'><script>", 421),
    ],
)
async def test_host_is_one_of_our_names(hub, named, status) -> None:
    answer = await say(hub.port, request(host=named.format(port=hub.port)))
    assert answer.status == status
    assert b"script" not in answer.body
    assert "evil" not in str(answer.headers)


async def test_two_hosts_are_refused(hub, host) -> None:
    answer = await say(hub.port, request("/api/health", "Host: evil.test", host=host))
    assert answer.status == 400


async def test_hub_may_be_called_by_the_address_it_was_dialled_at(hub) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", hub.port)
    writer.write(request(host=f"127.0.0.1:{hub.port}"))
    assert (await read(reader)).status == 200
    writer.close()


@pytest.mark.parametrize("method", ["TRACE", "PUT", "PATCH", "DELETE", "OPTIONS", "PROPFIND"])
async def test_method_that_no_route_has_does_nothing(hub, host, method) -> None:
    answer = await say(
        hub.port, request("/api/health", f"Origin: http://{host}", method=method, host=host)
    )
    assert answer.status in {400, 404, 405}
    assert b"Origin" not in answer.body
