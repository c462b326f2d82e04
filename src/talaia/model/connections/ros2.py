"""ROS 2, joined as a node."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.checks.identifiers import Finding
from talaia.model.closed_lists import CommandKind, LogLevel
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.ros import RosRules, node_fits

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Ros2Connection", "Ros2Rules", "Ros2Settings"]

# What the middlewares' ports leave room for.
_MAX_DOMAIN = 232


class Ros2Settings(Shape, frozen=True, kw_only=True):
    """How the gateway joins ROS 2.

    Attributes:
        domain: the ROS domain id; none takes ROS_DOMAIN_ID or 0.
        node: the gateway's node name.
        definitions: a folder with ``.msg`` files, or a recording, for message types that neither
            this machine nor the robot's nodes describe; relative to the description's folder.
        log: lines of the robot's log (``/rosout``) from this level on stand in the logbook.
        keep_log: lines of the robot's log from this level on are kept at the hub, all of them.
        use_sim_time: the robot's nodes go by ``/clock``, and so do the stamps of their messages.

    """

    domain: int | None = None
    node: str = "talaia_gateway"
    definitions: str = ""
    log: LogLevel = LogLevel.NONE
    keep_log: LogLevel = LogLevel.WARNING
    use_sim_time: bool = False


class Ros2Connection(Ros2Settings, frozen=True, kw_only=True, tag_field="kind", tag="ros2"):
    """ROS 2, joined as a node.

    Attributes:
        domain: the ROS domain id; none takes ROS_DOMAIN_ID or 0.
        node: the gateway's node name.
        definitions: a folder with ``.msg`` files, or a recording, for message types that neither
            this machine nor the robot's nodes describe; relative to the description's folder.
        log: lines of the robot's log (``/rosout``) from this level on stand in the logbook.
        keep_log: lines of the robot's log from this level on are kept at the hub, all of them.
        use_sim_time: the robot's nodes go by ``/clock``, and so do the stamps of their messages.

    """


class Ros2Rules(RosRules[Ros2Connection]):
    """Checks what is described of a ROS 2 connection."""

    kind = ConnectionKind.ROS2
    commands = RosRules.commands | {CommandKind.LIFECYCLE}
    lifecycles = True

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        domain = self.connection.domain
        if domain is not None and not 0 <= domain <= _MAX_DOMAIN:
            problem = f"expected a ROS domain id from 0 to {_MAX_DOMAIN}, found {domain}"
            yield Finding(f"{where}.domain", problem)
        yield from node_fits(where, self.connection.node)
