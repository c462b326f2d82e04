"""The WebSocket of a client protocol: admitted by token, served like a page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from fastapi import APIRouter, WebSocket

from talaia.hub.api.access import address_of, deny_socket
from talaia.hub.clients.catalog import CLIENT_PROTOCOLS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.hub.api.clients.client_admission import AdmittedClient, ClientAdmission
    from talaia.hub.clients.client_connection import (
        ClientConnection,
        ClientConnections,
        ClientSession,
    )
    from talaia.hub.clients.open_protocols import OpenProtocols
    from talaia.hub.store.audit import Audit

__all__ = ["ClientSockets"]


class BeginsSession(Protocol):
    """Makes a protocol's session of a client that has just connected."""

    def __call__(self, socket: WebSocket, connection: ClientConnection) -> ClientSession:
        """Give it; the socket is accepted, and nothing was sent."""
        ...


class ClientSockets:
    """The route of one protocol."""

    def __init__(
        self,
        protocol: str,
        *,
        begin: BeginsSession,
        subprotocols: Sequence[str],
        admission: ClientAdmission,
        connections: ClientConnections,
        protocols: OpenProtocols,
        audit: Audit,
    ) -> None:
        """Serve ``protocol`` of the catalog.

        Args:
            protocol: its short name.
            begin: makes the session of each client.
            subprotocols: of which a client must offer one, the first that it names counts; empty:
                the protocol knows none.
            admission: lets clients in.
            connections: makes their connections.
            protocols: counts them.
            audit: keeps who came and went.

        """
        self._protocol = protocol
        self._begin = begin
        self._subprotocols = subprotocols
        self._admission = admission
        self._connections = connections
        self._protocols = protocols
        self._audit = audit

    def router(self) -> APIRouter:
        """Give the socket's route."""
        router = APIRouter()
        router.websocket(CLIENT_PROTOCOLS[self._protocol].path)(self.serve)
        return router

    async def serve(self, socket: WebSocket) -> None:
        """Serve one client."""
        async with self._admission.admit_client(socket, self._protocol) as admitted:
            if admitted is not None:
                await self._serve(socket, admitted)

    async def _serve(self, socket: WebSocket, admitted: AdmittedClient) -> None:
        # In the order in which the client would have them.
        offered: list[str] = socket.scope.get("subprotocols") or []
        chosen = next((name for name in offered if name in self._subprotocols), None)
        if self._subprotocols and chosen is None:
            known = " or ".join(self._subprotocols)
            await deny_socket(
                socket, status=400, code="subprotocol", message=f"offer the subprotocol {known}"
            )
            return
        await socket.accept(subprotocol=chosen)
        # Nothing is awaited from here until it is served: no change of the table is missed.
        connection = self._connections.connect(admitted.live, admitted.who)
        with self._protocols.count_client(self._protocol, connection, admitted.origin):
            self._append_record("client connected", socket, admitted)
            try:
                await connection.serve_client(self._begin(socket, connection))
            finally:
                self._append_record("client disconnected", socket, admitted)

    def _append_record(self, kind: str, socket: WebSocket, admitted: AdmittedClient) -> None:
        self._audit.append_record(
            kind,
            who=admitted.who.name,
            address=address_of(socket),
            site=admitted.live.name,
            message=CLIENT_PROTOCOLS[self._protocol].title,
        )
