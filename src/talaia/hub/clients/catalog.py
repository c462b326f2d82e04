"""The client protocols that there are: one row for each."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "ALPACA",
    "CLIENT_PROTOCOLS",
    "FOXGLOVE",
    "METRICS",
    "MQTT",
    "ROSBRIDGE",
    "SCRIPTS",
    "SOCKETIO",
    "ClientProtocolInfo",
]


class ClientProtocolInfo(NamedTuple):
    """What an admin is shown of a protocol before it is opened.

    Attributes:
        title: what people call it.
        path: where it is served; ``{site}`` stands for the site's short name. Empty where a
            file that the hub was started with says it.
        socket: it is a WebSocket (``wss://``), else HTTP.
        tools: what speaks it.

    """

    title: str
    path: str
    socket: bool
    tools: str


ALPACA = "alpaca"
FOXGLOVE = "foxglove"
METRICS = "metrics"
MQTT = "mqtt"
ROSBRIDGE = "rosbridge"
SCRIPTS = "scripts"
SOCKETIO = "socketio"

# By the short name, which stands in addresses, in the database and in the audit log.
CLIENT_PROTOCOLS: Mapping[str, ClientProtocolInfo] = {
    ALPACA: ClientProtocolInfo(
        "ASCOM Alpaca", "", socket=False, tools="N.I.N.A. and others that speak Alpaca"
    ),
    FOXGLOVE: ClientProtocolInfo(
        "Foxglove WebSocket",
        "/clients/foxglove/{site}",
        socket=True,
        tools="Foxglove, Lichtblick, PlotJuggler",
    ),
    METRICS: ClientProtocolInfo(
        "Prometheus metrics", "/metrics?site={site}", socket=False, tools="Prometheus, Grafana"
    ),
    MQTT: ClientProtocolInfo(
        "MQTT broker", "", socket=False, tools="Home Assistant, Node-RED and others, by a broker"
    ),
    ROSBRIDGE: ClientProtocolInfo(
        "rosbridge 2", "/clients/rosbridge/{site}", socket=True, tools="roslibjs, roslibpy"
    ),
    SCRIPTS: ClientProtocolInfo(
        "Driving by scripts", "/clients/scripts/{site}", socket=True, tools="talaia.client"
    ),
    # The path under it, ``/socket.io/``, clients add by themselves.
    SOCKETIO: ClientProtocolInfo(
        "Socket.IO",
        "/?site={site}",
        socket=False,
        tools="socketIO-client, python-socketio, socket.io-client",
    ),
}
