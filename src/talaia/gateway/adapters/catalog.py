"""From a connection of the description to the adapter that speaks its protocol.

Each adapter is imported only when a description names its kind: what it needs is an extra.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.gateway.errors import SettingsError
from talaia.model.connection import (
    IndiConnection,
    ProcessConnection,
    Ros1Connection,
    Ros2Connection,
    RosbridgeConnection,
    VideoConnection,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import Share
    from talaia.gateway.ports import Adapter, Outlets, Status

__all__ = ["adapter_of"]


def adapter_of(share: Share, outlets: Outlets, status: Status) -> Adapter:
    """Make the adapter of one connection.

    Raises:
        SettingsError: what its protocol needs is not installed here.

    """
    make: Callable[[Share, Outlets, Status], Adapter]
    remedy = "install talaia[gateway]"
    match share.connection:
        case Ros2Connection():
            make, remedy = _ros2, "install talaia[ros2], or source the ROS installation's setup"
        case Ros1Connection():
            make = _ros1
        case RosbridgeConnection():
            make = _rosbridge
        case IndiConnection():
            make, remedy = _indi, "install talaia[indi]"
        case ProcessConnection():
            make = _process
        case VideoConnection():
            make, remedy = _video, "install talaia[camera]"
    try:
        return make(share, outlets, status)
    except ImportError as error:
        raise SettingsError(
            f"the connection {share.name} of the description cannot be used here ({error}); "
            f"{remedy}"
        ) from error


def _ros2(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.ros2.adapter import Ros2

    return Ros2(share, outlets, status)


def _ros1(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.ros1.adapter import Ros1

    return Ros1(share, outlets, status)


def _rosbridge(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.rosbridge.adapter import Rosbridge

    return Rosbridge(share, outlets, status)


def _indi(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.indi.adapter import Indi

    return Indi(share, outlets, status)


def _process(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.process import Processes

    return Processes(share, outlets, status)


def _video(share: Share, outlets: Outlets, status: Status) -> Adapter:
    from talaia.gateway.adapters.video.adapter import Video

    return Video(share, outlets, status)
