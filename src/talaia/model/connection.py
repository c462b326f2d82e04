"""How a gateway reaches robots: one shape for each robot protocol.

A connection has a name in the description; devices say which one they are reached by. Nothing
here is a secret: a password or token stands in a file or a variable that is named.
"""

from __future__ import annotations

from enum import StrEnum

from talaia.model.base import Shape

__all__ = [
    "ROS_KINDS",
    "Connection",
    "ConnectionKind",
    "ExtensionConnection",
    "ExtensionScalar",
    "IndiConnection",
    "ProcessConnection",
    "Ros1Connection",
    "Ros2Connection",
    "Ros2Settings",
    "RosbridgeConnection",
    "VideoConnection",
    "kind_of",
]


class ConnectionKind(StrEnum):
    """The robot protocols."""

    ROS2 = "ros2"
    ROS1 = "ros1"
    ROSBRIDGE = "rosbridge"
    INDI = "indi"
    PROCESS = "process"
    VIDEO = "video"
    # Whatever an installed extension speaks; see docs/how-to/extend.
    EXTENSION = "extension"


# These name things as ROS does: topics, services, types.
ROS_KINDS = frozenset({ConnectionKind.ROS2, ConnectionKind.ROS1, ConnectionKind.ROSBRIDGE})


class Ros2Settings(Shape, frozen=True, kw_only=True):
    """How the gateway joins ROS 2.

    Attributes:
        domain: the ROS domain id; none takes ROS_DOMAIN_ID or 0.
        node: the gateway's node name.

    """

    domain: int | None = None
    node: str = "talaia_gateway"


class Ros2Connection(Ros2Settings, frozen=True, kw_only=True, tag_field="kind", tag="ros2"):
    """ROS 2, joined as a node.

    Attributes:
        domain: the ROS domain id; none takes ROS_DOMAIN_ID or 0.
        node: the gateway's node name.

    """


class Ros1Connection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="ros1"):
    """ROS 1, joined as a node by rospy in the machine's own Python.

    Attributes:
        master: where the master answers; empty takes ROS_MASTER_URI or http://localhost:11311.
        namespace: names that do not begin with ``/`` are below it.
        node: the gateway's node name.
        python: the interpreter that has rospy.

    """

    master: str = ""
    namespace: str = "/"
    node: str = "talaia_gateway"
    python: str = "/usr/bin/python3"


class RosbridgeConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="rosbridge"):
    """ROS 1 or ROS 2 behind a rosbridge server, for machines that nothing can be installed on.

    Attributes:
        url: of the server's WebSocket: ``ws://robot.local:9090``.
        ros: which ROS stands behind it, 1 or 2: the two write times and types differently.
        ca: file of certificate authorities for ``wss://``; empty takes the system's.
        token_file: a file that holds what is sent as ``Authorization: Bearer``; empty for none.
        token_env: a variable that holds it, instead of a file.
        cbor: take pictures as CBOR, which is a quarter smaller than JSON.

    """

    url: str
    ros: int = 2
    ca: str = ""
    token_file: str = ""
    token_env: str = ""
    cbor: bool = True


class IndiConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="indi"):
    """An INDI server.

    Attributes:
        host: where the server answers.
        port: its TCP port.
        discover: make devices of what the server has and the description does not name.
        devices: with ``discover``: only INDI devices of these names; empty takes all.
        connect: tell drivers to connect to their hardware when they come, and again after a
            crash; one that somebody disconnects is left so until somebody connects it.

    """

    host: str = "127.0.0.1"
    port: int = 7624
    discover: bool = True
    connect: bool = True
    devices: tuple[str, ...] = ()


class ProcessConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="process"):
    """Commands of the operating system that are run, and whose answers are read.

    Attributes:
        file: a JSON command file (``command``, ``devices``) whose devices are taken in; a path
            beside the description or an absolute one; empty for none.
        prefix: stands before every argument line: ``ros2 run``.
        poll: what is read is asked for so often (s).
        timeout: a command that has not ended by then is ended (s).

    """

    file: str = ""
    prefix: str = ""
    poll: float = 1.0
    timeout: float = 10.0


class VideoConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="video"):
    """Cameras without ROS: on the network by RTSP, or at this computer's USB.

    Attributes:
        user: whom a camera's server asks for; empty for nobody.
        password_file: a file that holds that user's password; empty for none.
        udp: let the network drop what is late, where a camera can do no TCP.
        here: cameras' servers may run on the gateway's own computer (``127.0.0.1``), which is
            refused otherwise.

    """

    user: str = ""
    password_file: str = ""
    udp: bool = False
    here: bool = False


ExtensionScalar = bool | int | float | str


class ExtensionConnection(Shape, frozen=True, kw_only=True, tag_field="kind", tag="extension"):
    """A protocol that an extension speaks, which is installed at the gateway.

    Attributes:
        extension: its name, as ``talaia extensions`` lists it: ``snmp``.
        keys: what the extension asks for, by its own names; ``talaia extensions`` lists them. A
            hub on which it is not installed keeps them as they are.

    """

    extension: str
    keys: dict[str, ExtensionScalar] = {}


Connection = (
    Ros2Connection
    | Ros1Connection
    | RosbridgeConnection
    | IndiConnection
    | ProcessConnection
    | VideoConnection
    | ExtensionConnection
)


def kind_of(connection: Connection) -> ConnectionKind:
    """Tell the protocol of a connection."""
    match connection:
        case Ros2Connection():
            return ConnectionKind.ROS2
        case Ros1Connection():
            return ConnectionKind.ROS1
        case RosbridgeConnection():
            return ConnectionKind.ROSBRIDGE
        case IndiConnection():
            return ConnectionKind.INDI
        case ProcessConnection():
            return ConnectionKind.PROCESS
        case VideoConnection():
            return ConnectionKind.VIDEO
        case ExtensionConnection():
            return ConnectionKind.EXTENSION
