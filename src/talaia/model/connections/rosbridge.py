"""ROS 1 or ROS 2 behind a rosbridge server."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import CommandKind, LogLevel
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.ros import RosRules, RosSource

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command

__all__ = ["RosbridgeConnection", "RosbridgeRules"]


class RosbridgeConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="rosbridge"):
    """ROS 1 or ROS 2 behind a rosbridge server, for machines that nothing can be installed on.

    Attributes:
        url: of the server's WebSocket: ``ws://robot.local:9090``.
        ros: which ROS stands behind it, 1 or 2: the two write times and types differently.
        ca: file of certificate authorities for ``wss://``; empty takes the system's.
        token_file: a file that holds what is sent as ``Authorization: Bearer``; empty for none.
        token_env: a variable that holds it, instead of a file.
        cbor: take pictures as CBOR, which is a quarter smaller than JSON.
        log: lines of the robot's log (``/rosout``) from this level on stand in the logbook.
        keep_log: lines of the robot's log from this level on are kept at the hub, all of them.

    """

    url: str
    ros: int = 2
    ca: str = ""
    token_file: str = ""
    token_env: str = ""
    cbor: bool = True
    log: LogLevel = LogLevel.NONE
    keep_log: LogLevel = LogLevel.WARNING


class RosbridgeRules(RosRules[RosbridgeConnection]):
    """Checks what is described of a rosbridge connection."""

    kind = ConnectionKind.ROSBRIDGE
    # Parameters: a rosbridge of ROS 2 answers none.
    commands = frozenset({CommandKind.SERVICE, CommandKind.TOPIC, CommandKind.ACTION})
    files = False

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        yield from url_fits(f"{where}.url", connection.url, ("ws", "wss"), example="robot:9090")
        if connection.ros not in (1, 2):
            yield Finding(f"{where}.ros", f"expected 1 or 2, found {connection.ros}")
        # Which of two secrets was meant nobody can tell.
        if connection.token_file and connection.token_env:
            yield Finding(f"{where}.token_env", "token_file is given, too", "leave one out")

    def parameter_fits(self, where: str, source: RosSource) -> Iterator[Finding]:
        """See `RosRules`."""
        yield Finding(f"{where}.parameter", "a rosbridge reads no parameters", "take a topic")

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if self.connection.ros == 1 and command.kind is CommandKind.ACTION:
            problem = "a rosbridge of ROS 1 has no actions"
            yield Finding(f"{where}.kind", problem, "call a service")
        yield from super().command_fits(where, command)
