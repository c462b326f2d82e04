"""``/socket.io/``: polled requests and WebSockets of Engine.IO, by which Socket.IO comes."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response, WebSocket

from talaia.engineio.engine_carrier import serve_socket
from talaia.engineio.engine_connection import LineGone
from talaia.first_completed import until_first
from talaia.hub.api.access import deny_socket, who_of
from talaia.hub.api.guarded_routes import GuardedRoute
from talaia.hub.api.problems import STORE_DOWN, ApiProblem
from talaia.hub.clients.catalog import SOCKETIO
from talaia.hub.errors import StoreDown
from talaia.hub.live.pages.page_transport import GONE
from talaia.wire.errors import PeerError
from talaia.wire.socketio.engine_packets import (
    EnginePacket,
    EngineRevision,
    decode_body,
    encode_body,
)

if TYPE_CHECKING:
    from talaia.engineio.engine_connection import EngineConnection
    from talaia.hub.api.clients.client_admission import ClientAdmission
    from talaia.hub.api.clients.engine_sessions import EngineSessions

__all__ = ["SocketioRoutes"]

_PATH = "/socket.io/"
# So long a client's messages wait for their turn, if it does not fetch what it is answered (s).
_TURN_S = 20.0


class SocketioRoutes:
    """The path at which every Socket.IO client looks for its server."""

    def __init__(self, *, admission: ClientAdmission, sessions: EngineSessions) -> None:
        """Hand what comes to ``sessions``; ``admission`` lets sockets in."""
        self._admission = admission
        self._sessions = sessions

    def router(self) -> APIRouter:
        """Give the routes of polled requests."""
        router = APIRouter(route_class=GuardedRoute)
        # No JSON: packets.
        router.get(_PATH, response_class=Response)(self.poll)
        router.post(_PATH, response_class=Response)(self.push)
        return router

    def socket_router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket(_PATH)(self.serve)
        return router

    async def poll(self, request: Request) -> Response:
        """Begin a session, or wait for what it has for the client."""
        who = who_of(request)
        query = request.query_params
        if query.get("transport") != "polling":
            raise ApiProblem(400, "transport", "transport= is polling for a request")
        if "sid" not in query:
            line = self._sessions.begin_session(who, request)
            return _answer_packets(request, line, [line.opening_packet(upgrades=True)])
        line = self._sessions.find_session(who, query["sid"])
        try:
            with line.hold_poll():
                packets, _ = await until_first(line.pull_packets(polling=True), _gone(request))
        except PeerError as error:
            await line.close_line(error.code)
            raise ApiProblem(400, "session", error.problem) from error
        if isinstance(packets, LineGone):
            raise ApiProblem(400, "session", "the session has ended; connect anew")
        if not isinstance(packets, list):
            # The client has given up on this request, and would miss what it was to fetch.
            await line.close_line()
            return Response()
        return _answer_packets(request, line, packets)

    async def push(self, request: Request) -> Response:
        """Take what a client sends."""
        who = who_of(request)
        line = self._sessions.find_session(who, request.query_params.get("sid", ""))
        try:
            async with asyncio.timeout(_TURN_S):
                for packet in decode_body(await request.body(), line.revision):
                    await line.receive_packet(packet)
        except PeerError as error:
            await line.close_line(error.code)
            raise ApiProblem(400, "invalid", error.problem) from error
        except TimeoutError:
            await line.close_line()
            raise ApiProblem(400, "session", "answers wait and are not fetched") from None
        return Response("ok", media_type="text/plain", headers=_cross_origin(request))

    async def serve(self, socket: WebSocket) -> None:
        """Serve a WebSocket, which begins a session or takes over one that was polled."""
        try:
            line = await self._admit_socket(socket)
        except ApiProblem as no:
            await deny_socket(
                socket, status=no.status, code=no.code, message=no.message, retry_s=no.retry_s
            )
            return
        except StoreDown:
            await deny_socket(socket, status=503, code="store", message=STORE_DOWN, retry_s=2)
            return
        try:
            await socket.accept()
        except GONE:
            if "sid" not in socket.query_params:
                await line.close_line()
            return
        await serve_socket(_HubSocket(socket), line, polled="sid" in socket.query_params)

    async def _admit_socket(self, socket: WebSocket) -> EngineConnection:
        """Give the line that a socket is to carry.

        Raises:
            ApiProblem: it is not let in.
            StoreDown: it cannot be told whose token it is.

        """
        query = socket.query_params
        who = await self._admission.identify_account(socket, SOCKETIO)
        if query.get("transport") != "websocket":
            raise ApiProblem(400, "transport", "transport= is websocket for a socket")
        if "sid" in query:
            return self._sessions.find_session(who, query["sid"])
        return self._sessions.begin_session(who, socket)


class _HubSocket:
    """A `FrameSocket`."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket

    async def receive_frame(self) -> str | bytes:
        """Wait for a frame."""
        event = await self._socket.receive()
        if event["type"] == "websocket.disconnect":
            raise LineGone
        data: bytes | None = event.get("bytes")
        return str(event.get("text", "")) if data is None else data

    async def send_frame(self, frame: str | bytes) -> None:
        """Send one."""
        try:
            if isinstance(frame, str):
                await self._socket.send_text(frame)
            else:
                await self._socket.send_bytes(frame)
        except GONE as gone:
            raise LineGone from gone

    async def close_socket(self, code: int) -> None:
        """Close it."""
        try:
            await self._socket.close(code)
        except GONE:
            # The client was quicker.
            return


async def _gone(request: Request) -> None:
    """Return when whoever asks has gone."""
    while (await request.receive())["type"] != "http.disconnect":
        pass


def _answer_packets(
    request: Request, line: EngineConnection, packets: list[EnginePacket]
) -> Response:
    binary = line.revision is EngineRevision.OLD and not line.as_text
    return Response(
        encode_body(packets, line.revision, as_text=line.as_text),
        media_type="application/octet-stream" if binary else "text/plain; charset=UTF-8",
        headers={"Cache-Control": "no-store", **_cross_origin(request)},
    )


def _cross_origin(request: Request) -> dict[str, str]:
    """Let a page read the answer whose origin an admin lets in; others were refused."""
    origin = request.headers.get("origin")
    return {"Access-Control-Allow-Origin": origin, "Vary": "Origin"} if origin else {}
