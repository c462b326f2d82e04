"""Readers of what robots, drivers and devices say to a gateway, and of its own torn files."""

from __future__ import annotations

from talaia.gateway.adapters.alpaca.protocol import (
    AlpacaRefused,
    parse_configured,
    parse_discovery,
    parse_value,
)
from talaia.gateway.adapters.cloudconnect import parse_metric
from talaia.gateway.adapters.indi.errors import IndiError
from talaia.gateway.adapters.indi.numbers import format_number, parse_number
from talaia.gateway.adapters.indi.protocol import IndiParser
from talaia.gateway.adapters.onvif.answers import (
    parse_axes,
    parse_clock,
    parse_paths,
    parse_presets,
    parse_profiles,
    parse_status,
    parse_uri,
)
from talaia.gateway.adapters.onvif.http_digest import authorization_of, best_challenge
from talaia.gateway.adapters.onvif.search import parse_matches
from talaia.gateway.adapters.onvif.soap import CameraFault, fault_in
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, parse_xml
from talaia.gateway.adapters.ros1.decode import decoder_of
from talaia.gateway.adapters.ros1.robot_messages import read_log_head
from talaia.gateway.adapters.ros2.nodes.log_lines import read_head
from talaia.gateway.adapters.rosbridge.protocol import bytes_of, read_message
from talaia.gateway.errors import FieldError
from talaia.gateway.spool.packing import unpack_record
from talaia.gateway.spool.segment import read_records
from talaia.wire.errors import PeerError

from .target import FuzzTarget


def _read_indi(data: bytes) -> None:
    """Read as one piece, and cut where a byte of it says."""
    IndiParser().parse_data(data)
    cut = data[0] if data else 0
    parser = IndiParser(max_blob=1000)
    parser.parse_data(data[:cut])
    parser.parse_data(data[cut:])


def _read_number(data: bytes) -> None:
    text = data.decode("utf-8", "replace")
    format_number(parse_number(text), text)


def _read_rosbridge_server(data: bytes) -> None:
    said = read_message(data[1:] if data[:1] == b"\1" else data.decode("utf-8", "replace"))
    bytes_of(said.body)


def _read_alpaca(data: bytes) -> None:
    parse_discovery(data)
    for read in (parse_configured, lambda answer: parse_value(answer, 1)):
        try:
            read(data)
        except AlpacaRefused:
            continue


def _read_onvif(data: bytes) -> None:
    parse_matches(data, "192.0.2.8", "urn:uuid:1")
    challenge = best_challenge([data.decode("latin-1")])
    if challenge is not None:
        authorization_of(challenge, "me", "secret", path="/", count=1, cnonce="c")
    if (fault := fault_in(data)) is not None:
        raise fault
    # Whatever was asked, the answer may be to anything.
    for answer in parse_xml(data).walk_nodes():
        for read in (parse_clock, parse_paths, parse_profiles, parse_presets, parse_status):
            read(answer)
        parse_uri(answer)
        parse_axes(answer, "node")


def _read_ros1(data: bytes) -> None:
    """Read a message of a type as its publisher has defined it: type, definition, message."""
    name, _, rest = data.partition(b"\0")
    definition, _, message = rest.partition(b"\0\0")
    decode = decoder_of(name.decode("utf-8", "replace"), definition.decode("utf-8", "replace"))
    decode(message)


def _read_logs(data: bytes) -> None:
    read_head(data)
    read_log_head(data)


def _read_metric(data: bytes) -> None:
    parse_metric(data.decode("utf-8", "replace"))


def _read_spool(data: bytes) -> None:
    for _, record in read_records(data):
        unpack_record(record)


TARGETS = (
    FuzzTarget("indi", _read_indi, (IndiError,)),
    FuzzTarget("indi_number", _read_number, ()),
    FuzzTarget("rosbridge_server", _read_rosbridge_server, (FieldError,)),
    FuzzTarget("alpaca", _read_alpaca, ()),
    FuzzTarget("onvif", _read_onvif, (UnreadableXml, CameraFault), longest=8192),
    FuzzTarget("ros1_message", _read_ros1, (FieldError,), share=0.2),
    FuzzTarget("robot_log", _read_logs, ()),
    FuzzTarget("cloudconnect", _read_metric, (FieldError,)),
    FuzzTarget("spool", _read_spool, (PeerError,)),
)
