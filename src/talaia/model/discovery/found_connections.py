"""How a robot that was found is reached, as a description says it. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.camera_addresses import NO_ADDRESS, why_no_camera
from talaia.model.closed_lists import LogLevel
from talaia.model.connection import (
    AlpacaConnection,
    IndiConnection,
    OnvifConnection,
    Ros1Connection,
    RosbridgeConnection,
)
from talaia.model.discovery.json_devices import connection_of
from talaia.model.site import Ros2Settings

if TYPE_CHECKING:
    from talaia.model.connection import Connection
    from talaia.model.discovery.probe_report import DeviceFound, Found

__all__ = ["connections_of", "ros2_of"]


def ros2_of(found: Found) -> Ros2Settings | None:
    """Say how ROS 2 is joined; its log is read from warnings on, as ROS 1's is."""
    if found.protocol != "ros2":
        return None
    return Ros2Settings(
        domain=found.domain,
        # The gateway has to read the same.
        definitions=found.definitions,
        log=LogLevel.WARNING,
        use_sim_time=found.sim_time,
    )


def connections_of(found: Found) -> dict[str, Connection]:
    """Name how the robot is reached."""
    match found.protocol:
        case "ros1":
            return {"ros1": _ros1_of(found)}
        case "rosbridge":
            return {"rosbridge": _rosbridge_of(found)}
        case "indi":
            return {"indi": IndiConnection(host=found.host, port=found.port)}
        case "alpaca":
            return {"alpaca": _alpaca_of(found)}
        case "onvif":
            return {
                device.word: _onvif_of(found, device)
                for device in found.devices
                if device.described is not None
            }
        case "mqtt" | "http":
            named = connection_of(found)
            return dict([named]) if named else {}
        case _:
            # ROS 2 has a key of its own in a description; the others are named connections.
            return {}


def _ros1_of(found: Found) -> Ros1Connection:
    return Ros1Connection(master=found.master, log=LogLevel.WARNING, use_sim_time=found.sim_time)


def _rosbridge_of(found: Found) -> RosbridgeConnection:
    return RosbridgeConnection(
        url=found.url, ros=found.ros, ca=found.ca, token_file=found.token_file
    )


def _alpaca_of(found: Found) -> AlpacaConnection:
    # A server on the gateway's own computer has to be meant; whoever probed it there means it.
    here = why_no_camera(found.host) not in ("", NO_ADDRESS)
    return AlpacaConnection(host=found.host, port=found.port, here=here)


def _onvif_of(found: Found, device: DeviceFound) -> OnvifConnection:
    here = why_no_camera(urlsplit(device.address).hostname or "") not in ("", NO_ADDRESS)
    return OnvifConnection(
        url=device.address,
        profile=device.profile,
        user=found.user,
        password_file=found.password_file,
        ca=found.ca if device.address.startswith("https:") else "",
        here=here,
    )
