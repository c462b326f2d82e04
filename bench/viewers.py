"""What a frame costs the hub for each page that looks, beside bare servers of the same frames.

    viewers.py look PORT CERTIFICATE KIND    many pages, or a few that tell how old what comes is
    viewers.py serve PORT CERTIFICATE BYTES HOW    a bare server: "broadcast" of the library
                                            websockets, or "written": ready bytes to each socket

The certificate is the path of one, or "-" for plain TCP. `measure` starts both, and `run.py` it.
Long, because pages, bare servers and what is measured of them belong to one another.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import hashlib
import json
import os
import selectors
import socket
import ssl
import struct
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import httpx
import numpy as np
import psutil
import uvloop
import websockets
from crowd import describe
from stack import PASSWORD, free_port

from talaia.cli.child_processes import end_all, start_talaia
from talaia.gateway.uplink.heartbeat import reply_to
from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.wire import browser, frames
from talaia.wire.columns import Columns, pack_columns, unpack_columns
from talaia.wire.socket_frame import SocketFrame

SIGNALS = 10
# What the gateway sends, and the pages want (ms).
BATCH_MS, PAGE_MS = 20, 100
# Pages of one person; the hub lets a few more in.
_A_PERSON = 90
# Pages whose frames are read; all others only take bytes off their sockets.
WATCHERS = 20
# A page comes again so often (once a second).
_TRIES = 20
_GREETING = (
    "GET {path} HTTP/1.1\r\nHost: localhost:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    "Origin: {origin}\r\nCookie: {cookie}\r\n\r\n"
)
_MAGIC = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def channels_of(signals: int) -> list[str]:
    """Give the channels of a site that `crowd.describe` describes."""
    return [f"hut/n{number}" for number in range(signals)]


class Cost(NamedTuple):
    """What so many pages cost a server.

    Attributes:
        pages: how many look.
        frame_us: CPU of the server for each frame of each of them (µs).
        p50: age of the newest sample in a frame when it has come (ms); ``p99`` the same.
        frame_bytes: how large a frame is.

    """

    pages: int
    frame_us: float
    p50: float
    p99: float
    frame_bytes: int


# ── many pages, in a process of their own ──


class Looker:
    """Pages on bare sockets: they ask once, and then read."""

    def __init__(self, port: int, certificate: str, kind: str) -> None:
        """Dial ``port``; of ``kind`` "ages" frames are read, of "bytes" they are only taken."""
        self._port = port
        self._trust = None if certificate == "-" else _trust(certificate)
        self._reads = kind == "ages"
        self._selector = selectors.DefaultSelector()
        self._rest: dict[socket.socket, bytearray] = {}
        self.frames, self.bytes = 0, 0
        self.ages: list[float] = []

    def open_page(self, cookie: str, site: str, channels: list[str], every_ms: int) -> None:
        """Open one page more, that looks at channels of a site."""
        for _ in range(_TRIES):
            line, answer = self._dial(cookie)
            head, _, rest = answer.partition(b"\r\n\r\n")
            if head.startswith(b"HTTP/1.1 101"):
                break
            # A hub that is too busy to look up a session says so, and a page comes again.
            line.close()
            assert head.startswith(b"HTTP/1.1 503"), head
            time.sleep(1)
        else:
            _stop("a page was not let in")
        asked = browser.Subscribe(sub=1, site=site, channels=channels, every_ms=every_ms)
        payload = browser.FROM_BROWSER.encode(asked)
        # A mask of zeros leaves the bytes as they are.
        line.sendall(struct.pack("!BBHI", 0x82, 0xFE, len(payload), 0) + payload)
        line.settimeout(0)
        self._rest[line] = bytearray(rest)
        self._selector.register(line, selectors.EVENT_READ, line)

    def _dial(self, cookie: str) -> tuple[socket.socket, bytes]:
        bare = socket.create_connection(("127.0.0.1", self._port), timeout=60)
        line = self._trust.wrap_socket(bare, server_hostname="localhost") if self._trust else bare
        scheme = "https" if self._trust else "http"
        words = {"path": "/ws", "port": self._port, "cookie": cookie}
        line.sendall(
            _GREETING.format(origin=f"{scheme}://localhost:{self._port}", **words).encode()
        )
        answer = b""
        while b"\r\n\r\n" not in answer:
            answer += line.recv(4096) or _stop(f"no answer: {answer[:200]!r}")
        return line, answer

    def read_once(self, wait_s: float) -> None:
        """Read what is there."""
        for key, _ in self._selector.select(wait_s):
            line = key.data
            with contextlib.suppress(BlockingIOError, ssl.SSLWantReadError):
                while True:
                    data = line.recv(65_536) or _stop("the server has closed a page")
                    self.bytes += len(data)
                    if self._reads:
                        self._rest[line] += data
                        self._parse(self._rest[line], time.time() * 1e6)
                    if not self._trust and len(data) < 65_536:
                        break

    def _parse(self, rest: bytearray, now_us: float) -> None:
        while len(rest) >= 2:
            size, begin = rest[1], 2
            if size == 126:
                if len(rest) < 4:
                    return
                (size,), begin = struct.unpack_from("!H", rest, 2), 4
            if len(rest) < begin + size:
                return
            payload = bytes(rest[begin : begin + size])
            del rest[: begin + size]
            newest = _newest_us(payload)
            if newest:
                self.frames += 1
                self.ages.append((now_us - newest) / 1000)

    def tell(self) -> dict[str, object]:
        """Say what came since this was last asked."""
        told = {"frames": self.frames, "bytes": self.bytes, "ages": self.ages}
        self.frames, self.bytes, self.ages = 0, 0, []
        return told


def _newest_us(payload: bytes) -> float:
    if payload.startswith(b"bare"):
        return float(struct.unpack_from("<d", payload, 4)[0])
    message = browser.TO_BROWSER.decode(payload)
    if not isinstance(message, browser.Values) or message.age_ms:
        return 0.0
    return float(unpack_columns(message).value.max())


def _stop(why: str) -> bytes:
    raise SystemExit(why)


def _trust(certificate: str) -> ssl.SSLContext:
    trust = ssl.create_default_context(cafile=certificate)
    trust.check_hostname = False
    return trust


def look(port: int, certificate: str, kind: str) -> None:
    """Open pages and read until the input ends: "open [what `open_page` takes]", or "tell"."""
    if kind == "bytes":
        # They stand for machines of their own.
        os.nice(15)
    pages = Looker(port, certificate, kind)
    words = bytearray()
    os.set_blocking(0, False)
    while True:
        pages.read_once(0.02)
        with contextlib.suppress(BlockingIOError):
            data = os.read(0, 65_536)
            if not data:
                return
            words += data
        while b"\n" in words:
            line, _, rest = words.partition(b"\n")
            words = bytearray(rest)
            if line.startswith(b"open "):
                pages.open_page(*json.loads(line[5:]))
                print("open", flush=True)
            else:
                print(json.dumps(pages.tell()), flush=True)


# ── bare servers ──


class _Written(asyncio.Protocol):
    """A socket to which ready bytes are written."""

    everyone: ClassVar[set[asyncio.Transport]] = set()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        self._transport, self._head = transport, bytearray()

    def data_received(self, data: bytes) -> None:
        if self._transport in self.everyone:
            return
        self._head += data
        if b"\r\n\r\n" in self._head:
            key = self._head.split(b"Sec-WebSocket-Key: ")[1].split(b"\r\n")[0]
            proof = base64.b64encode(hashlib.sha1(key + _MAGIC).digest())  # noqa: S324 - RFC 6455
            self._transport.write(
                b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                b"Sec-WebSocket-Accept: " + proof + b"\r\n\r\n"
            )
            self.everyone.add(self._transport)

    def connection_lost(self, _error: Exception | None) -> None:
        self.everyone.discard(self._transport)


async def serve(port: int, certificate: str, size: int, how: str) -> None:
    """Send the same to everybody every `PAGE_MS`."""
    context = None
    if certificate != "-":
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        folder = Path(certificate).parent
        context.load_cert_chain(certificate, folder / "key.pem")

    def payload() -> bytes:
        return b"bare" + struct.pack("<d", time.time() * 1e6) + bytes(size - 12)

    async def hear(connection: websockets.ServerConnection) -> None:
        with contextlib.suppress(websockets.ConnectionClosed):
            async for _ in connection:
                pass

    async with contextlib.AsyncExitStack() as stack:
        if how == "written":
            loop = asyncio.get_running_loop()
            await loop.create_server(_Written, "127.0.0.1", port, ssl=context, backlog=512)
        else:
            server = await stack.enter_async_context(
                websockets.serve(
                    hear, "127.0.0.1", port, ssl=context, compression=None, ping_interval=None,
                    backlog=512,
                )
            )  # fmt: skip
        print("ready", flush=True)
        while True:
            await asyncio.sleep(PAGE_MS / 1000)
            data = payload()
            if how == "written":
                data = SocketFrame(data).framed
                for transport in _Written.everyone:
                    transport.write(data)
            else:
                websockets.broadcast(server.connections, data)


# ── what is measured ──


class Pages:
    """A process of pages."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        """Speak to ``process``, which is a `Looker`'s."""
        self._process = process

    async def open_page(self, *words: object) -> None:
        """Let it open one page more; see `Looker.open_page`."""
        await self.ask(f"open {json.dumps(words)}")

    async def tell(self) -> dict[str, Any]:
        """Ask what came since this was last asked: frames, bytes, and ages (ms)."""
        told: dict[str, Any] = json.loads(await self.ask("tell"))
        return told

    async def ask(self, words: str) -> str:
        """Say a line, and give the answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{words}\n".encode())
        async with asyncio.timeout(60):
            answer = (await self._process.stdout.readline()).decode()
        if not answer:
            raise SystemExit("the pages have ended")
        return answer


@contextlib.asynccontextmanager
async def role(*words: object) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run this file as one of its roles, see above."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, __file__, *(str(word) for word in words),
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE, limit=2**26,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        await process.wait()


async def _cost_of(
    pid: int, port: int, certificate: str, cookies: list[str], counts: list[int], alone_s: float
) -> list[Cost]:
    """Let ever more pages look; ``alone_s`` is the CPU that the server takes without (s a s)."""
    found: list[Cost] = []
    opened = 0
    server = psutil.Process(pid)
    async with (
        role("look", port, certificate, "bytes") as many,
        role("look", port, certificate, "ages") as few,
    ):
        crowd, watchers = Pages(many), Pages(few)
        for count in counts:
            while opened < count:
                # Those that are read lie evenly among the others, as their turns do.
                watched = opened * WATCHERS // counts[-1] < (opened + 1) * WATCHERS // counts[-1]
                cookie = cookies[opened // _A_PERSON] if cookies else ""
                one = watchers if watched else crowd
                await one.open_page(cookie, "viewed", channels_of(SIGNALS), PAGE_MS)
                opened += 1
            await asyncio.sleep(3)
            await watchers.tell()
            before, began = sum(server.cpu_times()[:2]), time.monotonic()
            await asyncio.sleep(16 if count < 100 else 10)
            used, passed = sum(server.cpu_times()[:2]) - before, time.monotonic() - began
            told = await watchers.tell()
            watching = opened * WATCHERS // counts[-1]
            got, ages = told["frames"] / watching * opened, np.array(told["ages"])
            found.append(
                Cost(
                    count, 1e6 * (used - alone_s * passed) / got,
                    float(np.percentile(ages, 50)), float(np.percentile(ages, 99)),
                    round(told["bytes"] / told["frames"]),
                )
            )  # fmt: skip
    return found


class _Gateway:
    """A gateway of `SIGNALS` signals; the value of each sample is the moment when it is sent."""

    def __init__(self, connection: websockets.ClientConnection) -> None:
        self._connection = connection
        self._tasks: list[asyncio.Task[None]] = []

    async def begin(self) -> None:
        hello = frames.Hello(
            site="viewed", boot="b", catalogue="c", description=describe("viewed", SIGNALS)
        )
        await self._connection.send(frames.LINK_FROM_GATEWAY.encode(hello))
        welcomed = asyncio.Event()
        self._tasks = [asyncio.create_task(self._read(welcomed))]
        await asyncio.wait_for(welcomed.wait(), 30)
        self._tasks.append(asyncio.create_task(self._send()))

    async def end(self) -> None:
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _read(self, welcomed: asyncio.Event) -> None:
        async for data in self._connection:
            message = frames.LINK_FROM_HUB.decode(data)
            if isinstance(message, frames.Welcome):
                welcomed.set()
            elif isinstance(message, frames.Beat):
                reply = reply_to(message, time.monotonic_ns())
                await self._connection.send(frames.LINK_FROM_GATEWAY.encode(reply))

    async def _send(self) -> None:
        addresses, at = np.arange(SIGNALS, dtype=np.uint16), 0
        due = time.monotonic()
        while True:
            now_us = time.time() * 1e6
            times = np.full(SIGNALS, int(now_us), np.int64)
            columns = Columns(addresses, times, np.full(SIGNALS, now_us), {})
            batch = frames.SampleBatch(
                boot="b", first=at, catalogue="c", live=True, **pack_columns(columns)._asdict()
            )
            at += SIGNALS
            await self._connection.send(frames.LINK_FROM_GATEWAY.encode(batch))
            due += BATCH_MS / 1000
            await asyncio.sleep(max(0.0, due - time.monotonic()))


async def _sign_in(origin: str, trust: ssl.SSLContext | None, people: list[str]) -> list[str]:
    found = []
    for name in people:
        async with httpx.AsyncClient(verify=trust or True, base_url=origin, timeout=60) as client:
            answer = await client.post(
                "/api/login", json={"name": name, "password": PASSWORD}, headers={"Origin": origin}
            )
            answer.raise_for_status()
            found.append("; ".join(f"{word}={value}" for word, value in client.cookies.items()))
    return found


async def measure(counts: list[int], *, tls: bool) -> dict[str, list[Cost]]:
    """Measure the hub, then the bare servers with frames as large, one after the other."""
    with tempfile.TemporaryDirectory(prefix="talaia-viewers-") as name:
        folder, port = Path(name), free_port()
        settings = Settings(data=folder, host="127.0.0.1", port=port)
        people = [f"person {number}" for number in range(-(-counts[-1] // _A_PERSON))]
        for person in people:
            await accounts.create_user(settings, person, PASSWORD, "admin")
        key = await accounts.create_gateway(settings, "viewed")
        words = ["hub", "--data", str(folder), "--host", "127.0.0.1", "--port", str(port)]
        hub = await start_talaia("hub", [*words, *(() if tls else ("--plain",))], folder / "log")
        try:
            await hub.wait_line("ready", 30)
            certificate = str(folder / "tls" / "cert.pem") if tls else "-"
            trust = _trust(certificate) if tls else None
            scheme = "https" if tls else "http"
            cookies = await _sign_in(f"{scheme}://localhost:{port}", trust, people)
            async with websockets.connect(
                f"{scheme.replace('http', 'ws')}://localhost:{port}/gateway/link", ssl=trust,
                compression=None, ping_interval=None, proxy=None,
                additional_headers={"Authorization": f"Bearer {key}"},
            ) as connection:  # fmt: skip
                gateway = _Gateway(connection)
                await gateway.begin()
                await asyncio.sleep(3)
                process = psutil.Process(hub.process.pid)
                before, began = sum(process.cpu_times()[:2]), time.monotonic()
                await asyncio.sleep(12)
                alone_s = (sum(process.cpu_times()[:2]) - before) / (time.monotonic() - began)
                ours = await _cost_of(hub.process.pid, port, certificate, cookies, counts, alone_s)
                await gateway.end()
        finally:
            await end_all([hub])
        found = {"hub": ours}
        for how in ("broadcast", "written"):
            port = free_port()
            async with role("serve", port, certificate, ours[-1].frame_bytes, how) as server:
                assert server.stdout is not None
                await server.stdout.readline()
                found[how] = await _cost_of(server.pid, port, certificate, [], counts, 0.0)
    return found


if __name__ == "__main__":
    if sys.argv[1] == "look":
        look(int(sys.argv[2]), sys.argv[3], sys.argv[4])
    else:
        uvloop.run(serve(int(sys.argv[2]), sys.argv[3], int(sys.argv[4]), sys.argv[5]))
