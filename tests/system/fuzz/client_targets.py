"""Readers of what other tools say to the hub."""

from __future__ import annotations

from talaia.hub.clients.key_velocity import read_key
from talaia.hub.clients.published_message import read_published
from talaia.hub.clients.published_velocity import read_velocity
from talaia.hub.clients.rosbridge.ros_types import read_known_message
from talaia.hub.clients.socketio.founding_words import read_control
from talaia.hub.live.taps.message_tree import tree_reader
from talaia.hub.live.taps.type_texts import MessageUnreadable
from talaia.model.site import Drive
from talaia.wire.errors import PeerError
from talaia.wire.foxglove.codec import decode_client
from talaia.wire.gateway_messages.taps import TapSchema
from talaia.wire.mqtt.payloads import read_command_payload
from talaia.wire.prometheus.remote_read import decode_read_request
from talaia.wire.rosbridge.client_messages import RosbridgeFragment
from talaia.wire.rosbridge.codec import decode_rosbridge
from talaia.wire.rosbridge.fragments import FragmentAssembly
from talaia.wire.socketio.engine_packets import (
    EngineKind,
    EngineRevision,
    decode_body,
    decode_frame,
)
from talaia.wire.socketio.socket_packets import SocketAssembly
from talaia.wire.sparkplug.payloads import decode_sparkplug

from .target import FuzzTarget

_TWIST = "geometry_msgs/msg/Twist"
_STAMPED = "geometry_msgs/msg/TwistStamped"


def _read_foxglove(data: bytes) -> None:
    # As each of the two kinds of frames.
    decode_client(data[1:] if data[:1] == b"\1" else data.decode("utf-8", "replace"))


def _read_rosbridge(data: bytes) -> None:
    assembly = FragmentAssembly(10_000)
    for line in data.decode("utf-8", "replace").split("\n", 20):
        message = decode_rosbridge(line)
        if isinstance(message, RosbridgeFragment):
            whole = assembly.add_fragment(message)
            if whole is not None:
                decode_rosbridge(whole)


def _read_socketio(data: bytes) -> None:
    """Read a body, or a frame, as a client of either generation; its events one after the other."""
    if not data:
        return
    revision = EngineRevision.NEW if data[0] & 1 else EngineRevision.OLD
    rest = data[1:]
    if data[0] & 2:
        packets = decode_body(rest, revision)
    else:
        packets = [decode_frame(rest if data[0] & 4 else rest.decode("utf-8", "replace"), revision)]
    assembly = SocketAssembly()
    for packet in packets:
        if packet.kind is EngineKind.MESSAGE:
            event = assembly.add_message(packet.data)
            if event is not None and isinstance(event.data, list):
                read_control(event.data[0] if event.data else None, event.data[1:])


def _read_published(data: bytes) -> None:
    drive = Drive(topic="/cmd_vel", max_speed=1.0, max_turn=1.0)
    for encoding in ("json", "cdr"):
        for kind in (_TWIST, _STAMPED):
            read_velocity(encoding, kind, data)
    read_key(data, drive)
    for kind in (_TWIST, "sensor_msgs/msg/Image", "diagnostic_msgs/msg/DiagnosticArray"):
        for encoding in ("json", "cdr"):
            try:
                read_published(encoding, kind, data)
            except ValueError:
                continue
    try:
        read_known_message("diagnostic_msgs/msg/DiagnosticArray", data)
    except MessageUnreadable:
        return


def _read_topic(data: bytes) -> None:
    """Read a message of a type that a gateway has defined: type, definition, message."""
    name, _, rest = data.partition(b"\0")
    definition, _, message = rest.partition(b"\0\0")
    forms = (("ros2msg", "cdr"), ("ros2idl", "cdr"), ("ros1msg", "ros1"))
    encoding, written = forms[len(message) % len(forms)]
    schema = TapSchema(
        type=name.decode("utf-8", "replace"),
        encoding=encoding,
        definition=definition.decode("utf-8", "replace"),
        message_encoding=written,
    )
    tree_reader(schema)(message)


TARGETS = (
    FuzzTarget("foxglove", _read_foxglove, (PeerError,)),
    FuzzTarget("rosbridge", _read_rosbridge, (PeerError,)),
    FuzzTarget("socketio", _read_socketio, (PeerError,)),
    FuzzTarget("published_message", _read_published, (), share=0.5),
    FuzzTarget("topic_message", _read_topic, (MessageUnreadable,), share=0.2),
    FuzzTarget("prometheus", decode_read_request, (PeerError,)),
    FuzzTarget("sparkplug", decode_sparkplug, (PeerError,)),
    FuzzTarget("mqtt_command", read_command_payload, (PeerError,)),
)
