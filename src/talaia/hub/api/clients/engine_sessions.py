"""Sessions of Engine.IO: begun by a request or a socket, served apart from both."""

from __future__ import annotations

import asyncio
import logging
from contextlib import ExitStack
from typing import TYPE_CHECKING, Protocol

from talaia.engineio.engine_connection import EngineConnection
from talaia.hub.api.access import address_of
from talaia.hub.api.problems import ApiProblem
from talaia.hub.api.rate_limits import MOST_SOCKETS
from talaia.hub.clients.catalog import CLIENT_PROTOCOLS, SOCKETIO
from talaia.hub.clients.socketio.founding_words import read_wishes
from talaia.wire.socketio.engine_packets import EngineRevision

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection

    from talaia.clock import Clock
    from talaia.hub.api.clients.client_admission import ClientAdmission
    from talaia.hub.auth.permissions import Who
    from talaia.hub.clients.client_connection import (
        ClientConnection,
        ClientConnections,
        ClientSession,
    )
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.clients.socketio.founding_words import ClientWishes
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit

__all__ = ["EngineSessions"]

_LOG = logging.getLogger(__name__)
# Until the last polled request has fetched the reason why it ended, a closed session is found (s).
_FAREWELL_S = 2.0


class BeginsEngineSession(Protocol):
    """Makes the session of a client that has just come."""

    def __call__(
        self, line: EngineConnection, connection: ClientConnection, wishes: ClientWishes
    ) -> ClientSession:
        """Give it; nothing was sent."""
        ...


class EngineSessions:
    """All that are open. Call `end_sessions` at the end."""

    def __init__(
        self,
        *,
        begin: BeginsEngineSession,
        admission: ClientAdmission,
        connections: ClientConnections,
        protocols: OpenProtocols,
        audit: Audit,
        clock: Clock,
    ) -> None:
        """Let clients in by ``admission``, and serve each by the session that ``begin`` makes."""
        self._begin = begin
        self._admission = admission
        self._connections = connections
        self._protocols = protocols
        self._audit = audit
        self._clock = clock
        # By the secret that names each.
        self._lines: dict[str, EngineConnection] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    def find_session(self, who: Who, sid: str) -> EngineConnection:
        """Give a session of an account.

        Raises:
            ApiProblem: 400 it has none such; those of others are as if they were not there.

        """
        line = self._lines.get(sid)
        if line is None or line.user != who.user:
            raise ApiProblem(400, "session", "there is no such session; connect anew")
        return line

    def begin_session(self, who: Who, connection: HTTPConnection) -> EngineConnection:
        """Begin a session for an account; it is served until it is closed.

        Nothing is awaited from its admission on, so no change of what is open is missed.

        Raises:
            ApiProblem: 400 its address asks for what there is not, 404 of a site; 429 these are
                too many.

        """
        query = connection.query_params
        try:
            revision = EngineRevision(int(query.get("EIO", "")))
        except ValueError:
            raise ApiProblem(400, "version", "EIO= is 3 or 4, the revision of Engine.IO") from None
        wishes = read_wishes(query)
        if isinstance(wishes, str):
            raise ApiProblem(400, "invalid", wishes)
        live = self._admission.choose_site(who, query.get("site", ""))
        counted = ExitStack()
        if not counted.enter_context(self._admission.count_connection(who)):
            counted.close()
            raise ApiProblem(429, "busy", f"at most {MOST_SOCKETS} connections at once", 1)
        line = EngineConnection(
            revision, user=who.user, clock=self._clock, as_text=query.get("b64") in {"1", "true"}
        )
        client = self._connections.connect(live, who)
        origin = connection.headers.get("origin")
        counted.enter_context(self._protocols.count_client(SOCKETIO, client, origin))
        self._lines[line.sid] = line
        address = address_of(connection)
        serving = self._serve(line, client, wishes, address=address, counted=counted)
        task = asyncio.create_task(serving, name="serve a Socket.IO client")
        self._tasks.add(task)
        task.add_done_callback(self._forget_task)
        return line

    async def end_sessions(self) -> None:
        """End all, and wait until they have ended."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _serve(
        self,
        line: EngineConnection,
        client: ClientConnection,
        wishes: ClientWishes,
        *,
        address: str,
        counted: ExitStack,
    ) -> None:
        try:
            with counted:
                self._append_record("client connected", client.who, client.live, address)
                try:
                    await client.serve_client(self._begin(line, client, wishes))
                finally:
                    self._append_record("client disconnected", client.who, client.live, address)
                    await line.close_line()
            # No longer counted: what is left is to be fetched by one poll, or never.
            if line.waiting_bytes:
                await asyncio.sleep(_FAREWELL_S)
        finally:
            del self._lines[line.sid]

    def _forget_task(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        # Nobody waits for it: what went wrong is told here.
        if not task.cancelled() and (error := task.exception()) is not None:
            _LOG.error("a Socket.IO client's session failed", exc_info=error)

    def _append_record(self, kind: str, who: Who, live: LiveSite, address: str) -> None:
        self._audit.append_record(
            kind,
            who=who.name,
            address=address,
            site=live.name,
            message=CLIENT_PROTOCOLS[SOCKETIO].title,
        )
