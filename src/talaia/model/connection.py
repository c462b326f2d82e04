"""How a gateway reaches robots: all kinds of connections and their sources, in one table.

A connection has a name in the description; devices say which one they are reached by. Nothing
here is a secret: a password or token stands in a file or a variable that is named. Each protocol
has a module of its own in `connections`.
"""

from __future__ import annotations

from talaia.model.base import SourceShape
from talaia.model.connections.alpaca import (
    AlpacaConnection,
    AlpacaRules,
    AlpacaSource,
    alpaca_device_of,
)
from talaia.model.connections.extension import (
    ExtensionConnection,
    ExtensionKindRules,
    ExtensionScalar,
    ExtensionSource,
)
from talaia.model.connections.http import HttpConnection, HttpRules, HttpSource
from talaia.model.connections.indi import IndiConnection, IndiRules, IndiSource
from talaia.model.connections.kinds import ROS_KINDS, ConnectionKind
from talaia.model.connections.mqtt import MqttConnection, MqttRules, MqttSource
from talaia.model.connections.onvif import OnvifConnection, OnvifRules, OnvifSource
from talaia.model.connections.process import ProcessConnection, ProcessRules, ProcessSource
from talaia.model.connections.ros import RosSource
from talaia.model.connections.ros1 import Ros1Connection, Ros1Rules
from talaia.model.connections.ros2 import Ros2Connection, Ros2Rules, Ros2Settings
from talaia.model.connections.rosbridge import RosbridgeConnection, RosbridgeRules
from talaia.model.connections.rules import ConnectionRules, SourceT, keys_given, own_keys
from talaia.model.connections.socketio import SocketioConnection, SocketioRules, SocketioSource
from talaia.model.connections.video import VideoConnection, VideoRules, VideoSource
from talaia.model.derivation.source import DerivedSource
from talaia.model.detection import DetectionSource

__all__ = [
    "ROS_KINDS",
    "RULES",
    "AlpacaConnection",
    "AlpacaSource",
    "Connection",
    "ConnectionKind",
    "ConnectionRules",
    "DerivedSource",
    "DetectionSource",
    "ExtensionConnection",
    "ExtensionScalar",
    "ExtensionSource",
    "HttpConnection",
    "HttpSource",
    "IndiConnection",
    "IndiSource",
    "MqttConnection",
    "MqttSource",
    "OnvifConnection",
    "OnvifSource",
    "ProcessConnection",
    "ProcessSource",
    "Ros1Connection",
    "Ros2Connection",
    "Ros2Settings",
    "RosSource",
    "RosbridgeConnection",
    "SocketioConnection",
    "SocketioSource",
    "Source",
    "SourceShape",
    "VideoConnection",
    "VideoSource",
    "alpaca_device_of",
    "keys_given",
    "kind_of",
    "own_keys",
    "rules_of",
    "source_as",
    "topic_of",
]

Connection = (
    Ros2Connection
    | Ros1Connection
    | RosbridgeConnection
    | IndiConnection
    | ProcessConnection
    | VideoConnection
    | MqttConnection
    | HttpConnection
    | SocketioConnection
    | AlpacaConnection
    | OnvifConnection
    | ExtensionConnection
)

# Where a signal or a picture comes from: which of them goes by the connection of its device, but
# what a camera sees, and what is worked out from other signals, is made by the gateway itself.
Source = (
    RosSource
    | IndiSource
    | ProcessSource
    | VideoSource
    | MqttSource
    | HttpSource
    | SocketioSource
    | AlpacaSource
    | OnvifSource
    | ExtensionSource
    | DetectionSource
    | DerivedSource
)

_ALL_RULES: tuple[type[ConnectionRules], ...] = (
    Ros2Rules,
    Ros1Rules,
    RosbridgeRules,
    IndiRules,
    ProcessRules,
    VideoRules,
    MqttRules,
    HttpRules,
    SocketioRules,
    AlpacaRules,
    OnvifRules,
    ExtensionKindRules,
)
RULES = {rules.kind: rules for rules in _ALL_RULES}


def rules_of(connection: Connection) -> ConnectionRules:
    """Give what a connection asks of what it reaches."""
    # No case for anything else: so the type checker sees that every kind is here.
    match connection:
        case Ros2Connection():
            return Ros2Rules(connection)
        case Ros1Connection():
            return Ros1Rules(connection)
        case RosbridgeConnection():
            return RosbridgeRules(connection)
        case IndiConnection():
            return IndiRules(connection)
        case ProcessConnection():
            return ProcessRules(connection)
        case VideoConnection():
            return VideoRules(connection)
        case MqttConnection():
            return MqttRules(connection)
        case HttpConnection():
            return HttpRules(connection)
        case SocketioConnection():
            return SocketioRules(connection)
        case AlpacaConnection():
            return AlpacaRules(connection)
        case OnvifConnection():
            return OnvifRules(connection)
        case ExtensionConnection():
            return ExtensionKindRules(connection)


def kind_of(connection: Connection) -> ConnectionKind:
    """Tell the protocol of a connection."""
    return rules_of(connection).kind


def source_as(source: SourceShape, shape: type[SourceT]) -> SourceT:
    """Give a source as one protocol reads it: for that protocol another's says nothing."""
    return source if isinstance(source, shape) else shape()


def topic_of(source: Source) -> str:
    """Name the ROS topic that a source reads; empty for one of another protocol."""
    return source.topic if isinstance(source, RosSource) else ""
