"""An object store that speaks S3, as a process that others wrote; and a line to it with faults."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import importlib.util
import os
import sys
import threading
from contextlib import asynccontextmanager
from http.client import HTTPConnection, HTTPException
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import pytest
from certificates import Certificates, speak_tls
from patience import until_answered
from ports import free_port

BUCKET = "robots"
KEY_ID, SECRET = "AKIATALAIATESTS00000", "a-secret-that-no-log-may-show"


# It looks who asks, and not whether the signature holds.
SIGNED = (
    f"AWS4-HMAC-SHA256 Credential={KEY_ID}/20260101/us-east-1/s3/aws4_request,"
    " SignedHeaders=host, Signature=0"
)


def _client() -> httpx.AsyncClient:
    return httpx.AsyncClient(trust_env=False, headers={"Authorization": SIGNED})


def require_store() -> None:
    """Skip where there is no such store, or no library for one."""
    missing = [name for name in ("moto", "flask_cors", "obstore") if not _is_there(name)]
    if missing:
        said = f"needs {', '.join(missing)} (the extra dev)"
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") == "1" else pytest.skip)(said)


def _is_there(name: str) -> bool:
    return importlib.util.find_spec(name) is not None


class ObjectStore:
    """Moto's S3 at a port of its own, where it may be killed and begun anew, with what it had."""

    def __init__(self, **environment: str) -> None:
        require_store()
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        self._environment = environment
        self._process = None

    async def __aenter__(self) -> ObjectStore:
        await self.start()
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self.kill()

    async def start(self) -> None:
        """Begin with an empty bucket."""
        quiet = asyncio.subprocess.DEVNULL
        # Its warnings are about itself.
        words = ["-W", "ignore", "-m", "moto.server", "-H", "127.0.0.1", "-p", str(self.port)]
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            *words,
            stdout=quiet,
            stderr=quiet,
            env={**os.environ, **self._environment},
        )

        async def has_bucket() -> bool:
            async with _client() as client:
                try:
                    return (await client.put(f"{self.url}/{BUCKET}")).is_success
                except httpx.TransportError:
                    return False

        await until_answered(has_bucket)

    async def kill(self) -> None:
        """End it without farewell; it forgets everything."""
        if self._process is not None:
            self._process.kill()
            await self._process.wait()
            self._process = None

    async def keys(self) -> list[str]:
        """List what is there, by asking it and not through the hub."""
        async with _client() as client:
            text = (await client.get(f"{self.url}/{BUCKET}?list-type=2")).text
        return [part.partition("</Key>")[0] for part in text.split("<Key>")[1:]]

    async def content(self, key: str) -> bytes:
        """Give a file as it has it."""
        async with _client() as client:
            return (await client.get(f"{self.url}/{BUCKET}/{key}")).content

    async def remove(self, key: str) -> None:
        """Take a file out, as somebody does who works on the bucket."""
        async with _client() as client:
            assert (await client.delete(f"{self.url}/{BUCKET}/{key}")).is_success

    async def uploads(self) -> int:
        """Count uploads of several parts that nobody ended."""
        async with _client() as client:
            return (await client.get(f"{self.url}/{BUCKET}?uploads")).text.count("<Upload>")


class FaultyLine:
    """What stands between hub and store: it hands on what is asked, unless it is told otherwise.

    Attributes:
        away: connections are closed at once.
        slow_s: each answer takes so much longer.
        refusal: status and code with which writing is refused.
        cut: of what is read so many bytes are missing, while all else is as it should be.
        etag: what is read has another version than it had.
        lose: of what is written half is kept, and the answer is 200.
        spoil: of what is written the first byte is another one, and the answer is 200.
        asked: methods and paths.

    """

    def __init__(self, target: int, certificates: Certificates | None = None) -> None:
        # Under a certificate where one is given.
        self.away = False
        self.slow_s = 0.0
        self._ended = threading.Event()
        self.refusal: tuple[int, str] | None = None
        self.cut = 0
        self.etag = self.lose = self.spoil = False
        self.asked: list[tuple[str, str]] = []
        line = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *_words: object) -> None:
                pass

            def handle_any(self) -> None:
                line.hand_on(self, target)

            do_GET = do_PUT = do_POST = do_HEAD = do_DELETE = handle_any  # noqa: N815 - its names

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        if certificates is not None:
            speak_tls(self._server, certificates)
        scheme = "https" if certificates is not None else "http"
        self.url = f"{scheme}://127.0.0.1:{self._server.server_port}"
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    def __enter__(self) -> FaultyLine:
        self._thread.start()
        return self

    def __exit__(self, *_exc: object) -> None:
        self._ended.set()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def hand_on(self, request: BaseHTTPRequestHandler, port: int) -> None:
        """Ask the store, and answer with what it says, or with something else."""
        body = request.rfile.read(int(request.headers.get("Content-Length", 0)))
        self.asked.append((request.command, request.path))
        self._ended.wait(self.slow_s)
        if self.away:
            request.close_connection = True
            return
        written = request.command == "PUT" and body
        if written and self.refusal:
            status, code = self.refusal
            # As some stores do, it repeats the key.
            said = f"<Error><Code>{code}</Code><AWSAccessKeyId>{KEY_ID}</AWSAccessKeyId></Error>"
            self._answer(request, status, {}, said.encode())
            return
        if written and self.lose:
            body = body[: len(body) // 2]
        if written and self.spoil:
            body = bytes([body[0] ^ 1]) + body[1:]
        headers = {
            name: value
            for name, value in request.headers.items()
            if name.lower() not in {"content-length", "x-amz-content-sha256"}
        }
        connection = HTTPConnection("127.0.0.1", port, timeout=60)
        try:
            connection.request(request.command, request.path, body, headers)
            answer = connection.getresponse()
            data = answer.read()
        except (OSError, HTTPException):
            request.close_connection = True
            return
        finally:
            connection.close()
        self._answer(request, answer.status, dict(answer.getheaders()), data)

    def _answer(
        self, request: BaseHTTPRequestHandler, status: int, headers: dict[str, str], data: bytes
    ) -> None:
        read = request.command == "GET" and status in {200, 206} and "list-type" not in request.path
        if read:
            data = data[: len(data) - self.cut]
            if self.etag:
                headers["ETag"] = '"0123456789abcdef0123456789abcdef"'
        request.send_response(status)
        for name, value in headers.items():
            if name.lower() not in {"content-length", "connection", "date", "server"}:
                request.send_header(name, value)
        length = headers.get("Content-Length", "0") if request.command == "HEAD" else len(data)
        request.send_header("Content-Length", str(length))
        request.end_headers()
        if request.command != "HEAD":
            request.wfile.write(data)


@asynccontextmanager
async def faulty_store():
    """Start a store, and a line to it."""
    async with ObjectStore() as store:
        with FaultyLine(store.port) as line:
            yield store, line
