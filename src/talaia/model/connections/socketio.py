"""Programs that send by Socket.IO, as the founding vehicle's nodes do, to the gateway."""

from __future__ import annotations

import ipaddress
import re
from typing import TYPE_CHECKING

from talaia.model.base import Shape, SourceShape
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import SignalType
from talaia.model.connections.json_path import json_path_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.rules import KindRules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal

__all__ = ["SocketioConnection", "SocketioRules", "SocketioSource"]

# Of Socket.IO: a comma ends it in a packet, and a query stands behind a question mark.
_NAMESPACE = re.compile(r"/?[A-Za-z0-9_][A-Za-z0-9_./:-]{0,98}\Z")
_LONGEST_EVENT = 100
_LONGEST_NAME = 100


class SocketioConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="socketio"):
    """Programs of a robot that send by Socket.IO; they connect to the gateway, with a token.

    Attributes:
        port: of TCP, at which the gateway listens for them.
        host: the address it listens at; another one than this computer's own needs a certificate.
        token_file: a file that holds the token that programs say; at least 16 letters.
        token_env: a variable that holds it, instead of a file.
        certificate: file (PEM) with the certificate for ``https://``; empty for plain text.
        key: file (PEM) with its key.

    """

    port: int
    host: str = "127.0.0.1"
    token_file: str = ""
    token_env: str = ""
    certificate: str = ""
    key: str = ""


class SocketioSource(SourceShape, frozen=True, kw_only=True, tag="socketio"):
    """Where a signal or a picture comes from that programs send by Socket.IO.

    Attributes:
        namespace: in which it is sent; empty is ``sensedData`` for a signal, ``cv2server`` for a
            picture.
        event: name of the event; empty for any.
        name: of a sensor that is sent as ``{'name': 'speed1', 'magnitude': 1.4}``; empty for other
            data.
        path: the field of the data, ``wind.speed`` or ``$.sensors[0].value``; empty where all of it
            is the value, or with a name the magnitude.

    """

    namespace: str = ""
    event: str = ""
    name: str = ""
    path: str = ""


class SocketioRules(KindRules[SocketioConnection, SocketioSource]):
    """Checks what is described of programs that send by Socket.IO."""

    kind = ConnectionKind.SOCKETIO
    source = SocketioSource
    example = "name: speed1, or namespace: weather, event: report, path: wind.speed"

    def __init__(self, connection: SocketioConnection) -> None:
        """Answer for this connection."""
        super().__init__(connection, SocketioSource)

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        if not 1 <= connection.port <= 65_535:
            yield Finding(f"{where}.port", f"expected 1 to 65535, found {connection.port}")
        if bool(connection.token_file) is bool(connection.token_env):
            # Also on loopback: every user of this computer reaches it there.
            problem = "programs say a token, also on this computer"
            remedy = "write token_file: socketio.token, or token_env: NAME_OF_A_VARIABLE"
            if connection.token_file:
                problem, remedy = "token_file is given, too", "leave one out"
            yield Finding(f"{where}.token_env", problem, remedy)
        if bool(connection.certificate) is not bool(connection.key):
            missing = "key" if connection.certificate else "certificate"
            yield Finding(f"{where}.{missing}", "certificate and key go together", "write both")
        yield from self._host_fits(f"{where}.host")

    def _host_fits(self, where: str) -> Iterator[Finding]:
        try:
            address = ipaddress.ip_address(self.connection.host)
        except ValueError:
            problem = f"{self.connection.host[:80]!r} is not an address of this computer"
            yield Finding(where, problem, "write 127.0.0.1, or 0.0.0.0 for all of its addresses")
            return
        if not address.is_loopback and not self.connection.certificate:
            problem = "what is sent over a network, the token too, could be read on its way"
            yield Finding(where, problem, "write certificate and key, or leave host out")

    def signal_fits(self, where: str, signal: Signal, source: SocketioSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if signal.type is SignalType.POSITION:
            yield self.no_positions(where)
        yield from _source_fits(where, source)
        if not source.name and not source.namespace:
            problem = "which sensor is it, or which namespace?"
            yield Finding(where, problem, f"write {self.example}")

    def stream_fits(self, where: str, source: SocketioSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from _source_fits(where, source)
        if source.name:
            yield Finding(f"{where}.name", "pictures are of no sensor", "leave it out")


def _source_fits(where: str, source: SocketioSource) -> Iterator[Finding]:
    if source.namespace not in {"", "/"} and not _NAMESPACE.match(source.namespace):
        problem = f"{source.namespace[:80]!r} is not the name of a namespace"
        yield Finding(f"{where}.namespace", problem, "write it as sensedData")
    for key, longest in (("event", _LONGEST_EVENT), ("name", _LONGEST_NAME)):
        found = getattr(source, key)
        if len(found) > longest or not found.isprintable():
            yield Finding(f"{where}.{key}", f"at most {longest} letters that can be seen")
    yield from json_path_fits(f"{where}.path", source.path)
