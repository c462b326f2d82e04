"""``/socket.io/`` of a gateway: an ASGI application that lets programs in, and their lines."""

from __future__ import annotations

import asyncio
import hmac
import logging
from http import HTTPStatus
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.clock import SECOND
from talaia.engineio.engine_carrier import serve_socket
from talaia.engineio.engine_connection import EngineConnection, EngineTimes, LineGone
from talaia.first_completed import until_first
from talaia.gateway.adapters.socketio.asgi_requests import (
    AsgiSocket,
    EngineRequest,
    ProgramRefused,
    read_body,
    read_request,
    send_answer,
    wait_until_gone,
)
from talaia.gateway.adapters.socketio.program_session import ProgramSession
from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import (
    EngineRevision,
    decode_body,
    encode_body,
)

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.adapters.socketio.asgi_requests import Receive, Scope, Send
    from talaia.gateway.adapters.socketio.program_session import EventReceiver
    from talaia.gateway.ports import EventSink
    from talaia.wire.socketio.engine_packets import EnginePacket

__all__ = ["EngineEndpoint"]

log = logging.getLogger(__name__)
# A program is on this computer or its network: one that fell silent keeps its place for 15 s.
_TIMES = EngineTimes(ping_ns=5 * SECOND, timeout_ns=10 * SECOND)
_PATHS = {"/socket.io", "/socket.io/"}
# More than a robot has: one that went without a word counts until it was not heard for 15 s.
_MOST_PROGRAMS = 32
# After a wrong token everybody with a wrong one waits: a guesser gets one try a second.
_WRONG_S = 1.0
_MOST_WRONG = 8  # Who stand in that line; the others are sent away at once.
# So long messages wait for their turn (s).
_TURN_S = 20.0
# Until the last polled request has fetched why it ended, a closed line is found (s).
_LAST_POLL_S = 2.0


class EngineEndpoint:
    """All programs that are connected. Call `end_lines` at the end."""

    def __init__(
        self, *, token: str, receiver: EventReceiver, clock: Clock, events: EventSink
    ) -> None:
        """Let in who says ``token``; what is sent goes to ``receiver``."""
        self._token = token
        self._receiver = receiver
        self._clock = clock
        self._events = events
        # By the secret that names each.
        self._lines: dict[str, EngineConnection] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        # Held while a wrong token waits: guesses stand in line, from however many addresses.
        self._wrong = asyncio.Lock()
        self._guessing = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or serve a WebSocket (ASGI)."""
        request = read_request(scope)
        if scope["type"] == "websocket":
            await self._serve_websocket(scope["path"], request, receive, send)
            return
        try:
            await self._admit_request(scope["path"], request)
            body, kind = await self._answer_request(scope["method"], request, receive)
        except ProgramRefused as no:
            await send_answer(send, no.status, f"{no.why}\n".encode(), "text/plain")
        else:
            await send_answer(send, HTTPStatus.OK, body, kind)

    async def close_lines(self) -> None:
        """Close all lines; programs may connect anew."""
        for line in list(self._lines.values()):
            await line.close_line()

    async def end_lines(self) -> None:
        """Close all lines, and wait until nobody serves them."""
        await self.close_lines()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    # ── who comes in ──

    async def _admit_request(self, path: str, request: EngineRequest) -> None:
        if path not in _PATHS:
            raise ProgramRefused(HTTPStatus.NOT_FOUND, "there is /socket.io/ here")
        # Programs are no pages: a browser says of which origin its page is.
        origin, host = request.headers.get("origin"), request.headers.get("host", "")
        if origin is not None and urlsplit(origin).netloc != host:
            raise ProgramRefused(HTTPStatus.FORBIDDEN, "pages of other origins are not served")
        if self._has_token(request):
            return
        if self._guessing < _MOST_WRONG:
            self._guessing += 1
            try:
                async with self._wrong:
                    # Slept within the lock, and only by those who are wrong.
                    await asyncio.sleep(_WRONG_S)
            finally:
                self._guessing -= 1
            self._events.report_event("socketio_refused", f"a wrong token from {request.peer}")
        raise ProgramRefused(HTTPStatus.UNAUTHORIZED, "say the token: ?token=…, or as bearer")

    def _has_token(self, request: EngineRequest) -> bool:
        given = request.query.get("token", "")
        kind, _, value = request.headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer":
            given = value.strip()
        # In constant time: how long it takes must not tell how much of it is right.
        said = given.encode("utf-8", "surrogatepass")
        return hmac.compare_digest(said, self._token.encode())

    # ── polled requests ──

    async def _answer_request(
        self, method: str, request: EngineRequest, receive: Receive
    ) -> tuple[bytes, str]:
        if method == "GET":
            return await self._poll(request, receive)
        if method == "POST":
            return await self._push(request, receive), "text/plain"
        raise ProgramRefused(HTTPStatus.METHOD_NOT_ALLOWED, "GET or POST")

    async def _poll(self, request: EngineRequest, receive: Receive) -> tuple[bytes, str]:
        """Begin a session, or wait for what it has for the program."""
        if request.query.get("transport") != "polling":
            raise ProgramRefused(HTTPStatus.BAD_REQUEST, "transport= is polling for a request")
        if "sid" not in request.query:
            line = self._begin_line(request)
            return _body_of(line, [line.opening_packet(upgrades=True)])
        line = self._find_line(request)
        try:
            with line.hold_poll():
                pulling = line.pull_packets(polling=True)
                packets, _ = await until_first(pulling, wait_until_gone(receive))
        except PeerError as error:
            await line.close_line(error.code)
            raise ProgramRefused(HTTPStatus.BAD_REQUEST, error.problem) from error
        if isinstance(packets, list):
            return _body_of(line, packets)
        # The program has given up on this request, and would miss what it was to fetch.
        await line.close_line()
        raise ProgramRefused(HTTPStatus.BAD_REQUEST, "the session has ended; connect anew")

    async def _push(self, request: EngineRequest, receive: Receive) -> bytes:
        """Take what a program sends."""
        line = self._find_line(request)
        body = await read_body(receive)
        try:
            async with asyncio.timeout(_TURN_S):
                for packet in decode_body(body, line.revision):
                    await line.receive_packet(packet)
        except PeerError as error:
            await line.close_line(error.code)
            raise ProgramRefused(HTTPStatus.BAD_REQUEST, error.problem) from error
        except TimeoutError:
            await line.close_line()
            raise ProgramRefused(
                HTTPStatus.BAD_REQUEST, "answers wait and are not fetched"
            ) from None
        return b"ok"

    # ── WebSockets ──

    async def _serve_websocket(
        self, path: str, request: EngineRequest, receive: Receive, send: Send
    ) -> None:
        await receive()  # That it wants to connect.
        polled = "sid" in request.query
        try:
            await self._admit_request(path, request)
            line = self._find_line(request) if polled else self._begin_line(request)
        except ProgramRefused:
            # Before it is accepted, so it is answered 403.
            await send({"type": "websocket.close", "code": 1008})
            return
        await send({"type": "websocket.accept"})
        await serve_socket(AsgiSocket(receive, send), line, polled=polled)

    # ── lines ──

    def _find_line(self, request: EngineRequest) -> EngineConnection:
        line = self._lines.get(request.query.get("sid", ""))
        if line is None:
            raise ProgramRefused(HTTPStatus.BAD_REQUEST, "there is no such session; connect anew")
        return line

    def _begin_line(self, request: EngineRequest) -> EngineConnection:
        try:
            revision = EngineRevision(int(request.query.get("EIO", "")))
        except ValueError:
            why = "EIO= is 3 or 4, the revision of Engine.IO"
            raise ProgramRefused(HTTPStatus.BAD_REQUEST, why) from None
        if len(self._lines) >= _MOST_PROGRAMS:
            why = f"at most {_MOST_PROGRAMS} programs at once"
            raise ProgramRefused(HTTPStatus.SERVICE_UNAVAILABLE, why)
        as_text = request.query.get("b64") in {"1", "true"}
        line = EngineConnection(revision, clock=self._clock, as_text=as_text, times=_TIMES)
        self._lines[line.sid] = line
        task = asyncio.create_task(self._serve_line(line, request.peer))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return line

    async def _serve_line(self, line: EngineConnection, peer: str) -> None:
        try:
            try:
                await ProgramSession(line, self._receiver, self._clock).read_program()
            except LineGone:
                pass
            except PeerError as error:
                log.warning("a Socket.IO program at %s: %s", peer, error.problem)
                await line.close_line(error.code)
            except Exception:
                # One program's session; the others go on.
                log.exception("a Socket.IO program's session failed")
            await line.close_line()
            if line.waiting_bytes:
                await asyncio.sleep(_LAST_POLL_S)
        finally:
            del self._lines[line.sid]


def _body_of(line: EngineConnection, packets: list[EnginePacket]) -> tuple[bytes, str]:
    binary = line.revision is EngineRevision.OLD and not line.as_text
    kind = "application/octet-stream" if binary else "text/plain; charset=UTF-8"
    return encode_body(packets, line.revision, as_text=line.as_text), kind
