"""From a connection of the description to the adapter that speaks its protocol.

Each adapter is imported only when a description names its kind: what it needs is an extra.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError
from talaia.model.connection import (
    AlpacaConnection,
    ExtensionConnection,
    HttpConnection,
    IndiConnection,
    MqttConnection,
    OnvifConnection,
    ProcessConnection,
    Ros1Connection,
    Ros2Connection,
    RosbridgeConnection,
    SocketioConnection,
    VideoConnection,
)
from talaia.ros_installation import ForeignRos

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import Adapter, AdapterContext, AdapterStatus

__all__ = ["adapter_of"]


def adapter_of(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    """Make the adapter of one connection.

    Raises:
        SettingsError: what its protocol needs is not installed here.

    """
    make: Callable[[ConnectionScope, AdapterContext, AdapterStatus], Adapter]
    remedy = "install talaia[gateway]"
    match scope.connection:
        case Ros2Connection():
            make, remedy = _make_ros2, "see `talaia doctor`"
        case Ros1Connection():
            make = _make_ros1
        case RosbridgeConnection():
            make = _make_rosbridge
        case IndiConnection():
            make, remedy = _make_indi, "install talaia[indi]"
        case ProcessConnection():
            make = _make_process
        case VideoConnection():
            make, remedy = _make_video, "install talaia[camera]"
        case MqttConnection():
            make = _make_mqtt
        case HttpConnection():
            make = _make_http
        case SocketioConnection():
            make = _make_socketio
        case AlpacaConnection():
            make = _make_alpaca
        case OnvifConnection():
            make = _make_onvif
        case ExtensionConnection():
            make = _make_extension
    try:
        return make(scope, context, status)
    except ForeignRos as error:
        # It says by itself what to do.
        raise SettingsError(f"the connection {scope.name} of the description: {error}") from error
    except ImportError as error:
        raise SettingsError(
            f"the connection {scope.name} of the description cannot be used here ({error}); "
            f"{remedy}"
        ) from error


def _make_ros2(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.ros2.adapter import Ros2Adapter

    return Ros2Adapter(scope, context, status)


def _make_ros1(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.ros1.adapter import Ros1Adapter

    return Ros1Adapter(scope, context, status)


def _make_rosbridge(
    scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
) -> Adapter:
    from talaia.gateway.adapters.rosbridge.adapter import RosbridgeAdapter

    return RosbridgeAdapter(scope, context, status)


def _make_indi(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.indi.adapter import IndiAdapter

    return IndiAdapter(scope, context, status)


def _make_process(
    scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
) -> Adapter:
    from talaia.gateway.adapters.process import ProcessAdapter

    return ProcessAdapter(scope, context, status)


def _make_video(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.video.adapter import VideoAdapter

    return VideoAdapter(scope, context, status)


def _make_mqtt(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.mqtt.adapter import MqttAdapter

    return MqttAdapter(scope, context, status)


def _make_http(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.http.adapter import HttpAdapter

    return HttpAdapter(scope, context, status)


def _make_socketio(
    scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
) -> Adapter:
    from talaia.gateway.adapters.socketio.adapter import SocketioAdapter

    return SocketioAdapter(scope, context, status)


def _make_alpaca(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.alpaca.adapter import AlpacaAdapter

    return AlpacaAdapter(scope, context, status)


def _make_onvif(scope: ConnectionScope, context: AdapterContext, status: AdapterStatus) -> Adapter:
    from talaia.gateway.adapters.onvif.adapter import OnvifAdapter

    return OnvifAdapter(scope, context, status)


def _make_extension(
    scope: ConnectionScope, context: AdapterContext, status: AdapterStatus
) -> Adapter:
    from talaia.gateway.adapters.extension import ExtensionAdapterProcess

    return ExtensionAdapterProcess(scope, context, status)
