"""ROS 1, joined as a node by rospy in the machine's own Python."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.base import Shape
from talaia.model.checks.identifiers import Finding, topic_fits
from talaia.model.closed_lists import LogLevel
from talaia.model.connections.addresses import url_fits
from talaia.model.connections.kinds import ConnectionKind
from talaia.model.connections.ros import RosRules, node_fits

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["Ros1Connection", "Ros1Rules"]


class Ros1Connection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="ros1"):
    """ROS 1, joined as a node by rospy in the machine's own Python.

    Attributes:
        master: where the master answers; empty takes ROS_MASTER_URI or http://localhost:11311.
        namespace: names that do not begin with ``/`` are below it.
        node: the gateway's node name.
        python: the interpreter that has rospy.
        log: lines of the robot's log (``/rosout``) from this level on stand in the logbook.
        keep_log: lines of the robot's log from this level on are kept at the hub, all of them.
        use_sim_time: the robot's nodes go by ``/clock``, and so do the stamps of their messages.

    """

    master: str = ""
    namespace: str = "/"
    node: str = "talaia_gateway"
    python: str = "/usr/bin/python3"
    log: LogLevel = LogLevel.NONE
    keep_log: LogLevel = LogLevel.WARNING
    use_sim_time: bool = False


class Ros1Rules(RosRules[Ros1Connection]):
    """Checks what is described of a ROS 1 connection."""

    kind = ConnectionKind.ROS1

    def own_findings(self, where: str) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        connection = self.connection
        if connection.master:
            at = f"{where}.master"
            yield from url_fits(at, connection.master, ("http",), example="robot:11311")
        if connection.namespace != "/":
            yield from topic_fits(f"{where}.namespace", connection.namespace)
        yield from node_fits(where, connection.node)
        # systemd gives a gateway no PATH that could find it.
        if not connection.python.startswith("/"):
            problem = f"{connection.python!r} is not an absolute path"
            yield Finding(f"{where}.python", problem, "write /usr/bin/python3")
