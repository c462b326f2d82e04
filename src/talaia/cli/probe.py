"""``talaia probe``: what is out there, for people to read or as JSON for `talaia init`.

Long, because what is asked for, what is looked at and what is told of it belong together.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import msgspec

from talaia.cli.errors import CliError, PartMissing
from talaia.cli.probe_servers import (
    add_server_options,
    look_at_alpaca,
    look_at_bridge,
    look_at_broker,
    look_at_cameras,
    look_at_server,
    read_server_address,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.model.discovery.probe_report import Found, NodeFound, PropertyFound, TopicFound

__all__ = ["add_options", "main", "probe_robot"]

MAX_SECONDS = 600.0
# INDI: at the most, for looking ends when nothing new comes.
SECONDS, INDI_SECONDS = 5.0, 20.0
# Registered for INDI at IANA.
INDI_PORT = 7624
# What people look for first in a list of topics.
_KNOWN = {
    "cameras": ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"),
    "positions": (
        "sensor_msgs/msg/NavSatFix",
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
    ),
    "odometry": ("nav_msgs/msg/Odometry",),
    "batteries": ("sensor_msgs/msg/BatteryState",),
}


def main(argv: Sequence[str]) -> int:
    """Look and print; 0 when something was found, 1 when there is nothing."""
    parser = argparse.ArgumentParser(
        "talaia probe",
        description="List what a live robot offers: topics of ROS 2 or ROS 1 with fields and "
        "rates, services, actions, also behind a rosbridge server; the devices of an INDI or "
        "Alpaca server; network cameras with ONVIF; the topics of an MQTT broker; the fields that "
        "an HTTP address answers with. It only listens, or asks once.",
    )
    add_options(parser)
    parser.add_argument("--fields", action="store_true", help="list every field and property, too")
    parser.add_argument("--json", action="store_true", help="print JSON, as talaia init reads it")
    options = parser.parse_args(argv)
    found = probe_robot(options)
    if options.json:
        print(msgspec.json.format(msgspec.json.encode(found), indent=1).decode())
    elif found.protocol in ("indi", "alpaca", "onvif"):
        print(_devices_told(found, fields=options.fields))
    else:
        print(_as_text(found, fields=options.fields))
    return 0 if found.topics or found.services or found.devices else 1


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what looking needs to know."""
    parser.add_argument(
        "--seconds",
        type=_parse_seconds,
        help="how long to listen (default: 5; at an INDI server until nothing new comes, 20 at "
        "most)",
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--ros2", action="store_true", help="look at ROS 2 (the default)")
    which.add_argument(
        "--ros1",
        nargs="?",
        const="",
        metavar="MASTER",
        help="look at ROS 1 (default: the master of ROS_MASTER_URI, or http://localhost:11311); "
        "where ROS_MASTER_URI is set and its master answers, this is the default",
    )
    which.add_argument(
        "--indi",
        nargs="?",
        const="127.0.0.1",
        metavar="HOST[:PORT]",
        help="look at an INDI server (default: 127.0.0.1:7624)",
    )
    which.add_argument(
        "--alpaca",
        nargs="?",
        const="",
        metavar="HOST[:PORT]",
        help="look at an ASCOM Alpaca server (default: the one that answers Alpaca's discovery)",
    )
    which.add_argument(
        "--onvif",
        nargs="?",
        const="",
        metavar="URL",
        help="look for ONVIF cameras in the network, or at the one at http://HOST (with its user)",
    )
    which.add_argument(
        "--rosbridge",
        metavar="URL",
        help="look at ROS 1 or 2 behind a rosbridge server with rosapi: ws://HOST[:9090], wss://…",
    )
    which.add_argument(
        "--mqtt", metavar="URL", help="look at an MQTT broker: mqtt://HOST or mqtts://HOST[:PORT]"
    )
    which.add_argument(
        "--http", metavar="URL", help="look at an address that answers with JSON, asked for once"
    )
    add_server_options(parser)
    parser.add_argument("--domain", type=int, help="ROS 2 domain (default: ROS_DOMAIN_ID, or 0)")
    parser.add_argument(
        "--definitions",
        type=Path,
        metavar="PATH",
        help="ROS 2: a folder with .msg files (a workspace's src) or a recording, for types that "
        "are not installed and that their nodes do not describe",
    )
    parser.add_argument(
        "--connect",
        action="store_true",
        help="INDI, Alpaca: tell drivers to connect to their hardware first, as the gateway does; "
        "before that most of them show little",
    )


def _parse_seconds(text: str) -> float:
    value = float(text)
    if not 0.5 <= value <= MAX_SECONDS:
        raise argparse.ArgumentTypeError(f"expected 0.5 to {MAX_SECONDS:g} seconds, found {text}")
    return value


def probe_robot(options: argparse.Namespace) -> Found:
    """Look at what the options of `add_options` name.

    Raises:
        PartMissing: what it takes is not installed here.
        CliError: an option cannot be meant so.
        AdapterLost: the robot's side cannot be reached.

    """
    if options.connect and options.indi is None and options.alpaca is None:
        raise CliError("--connect is for --indi and --alpaca; ROS needs no such step")
    if options.mqtt is not None:
        return look_at_broker(options, options.seconds or SECONDS)
    if options.http is not None:
        return look_at_server(options)
    if options.onvif is not None:
        return look_at_cameras(options, options.seconds or SECONDS)
    if options.user or options.password_file:
        raise CliError("--user and --password-file are for --mqtt, --http and --onvif")
    if options.rosbridge is not None:
        return look_at_bridge(options, options.seconds or SECONDS)
    if options.token_file or options.ca:
        raise CliError("--token-file and --ca are for --mqtt, --http and --rosbridge")
    if options.alpaca is not None:
        return look_at_alpaca(options, options.seconds or SECONDS)
    if options.indi is not None:
        return _look_at_indi(options.indi, options.seconds or INDI_SECONDS, options.connect)
    seconds = options.seconds or SECONDS
    master = options.ros1
    # Only where nothing was asked for: a domain is ROS 2's, and says enough.
    if master is None and not options.ros2 and options.domain is None:
        master = _answering_master()
    return (
        _look_at_ros2(options.domain, seconds, options.definitions)
        if master is None
        else _look_at_ros1(master, seconds)
    )


def _look_at_ros2(domain: int | None, seconds: float, definitions: Path | None) -> Found:
    # Above 232, DDS's ports would be beyond 65535.
    if domain is not None and not 0 <= domain <= 232:
        raise CliError(f"--domain: expected a ROS domain id from 0 to 232, found {domain}")
    if definitions is not None:
        if not definitions.exists():
            raise CliError(f"--definitions {definitions}: there is no such folder or recording")
        # As it goes into a description, which may lie elsewhere.
        definitions = definitions.resolve()
    try:
        # Here, not at the top: the other protocols can be looked at without ROS.
        from talaia.gateway.adapters.ros2.probe import probe_graph
    except ImportError as error:
        raise PartMissing("talaia probe", error.name or "rclpy", "ros2") from error
    _print_listening(seconds)
    return probe_graph(domain, seconds, definitions)


def _answering_master() -> str | None:
    """Give the master of the environment, if there is one and it answers."""
    named = os.environ.get("ROS_MASTER_URI", "")
    if not named:
        return None
    from talaia.gateway.adapters.ros1.master import RosMaster
    from talaia.gateway.errors import AdapterLost

    try:
        # The variable alone says little: it may stay set on machines whose ROS 1 is long gone.
        RosMaster(named).check_master()
    except AdapterLost:
        return None
    # Errors' stream: with --json the output must be JSON and nothing else.
    print(f"looking at ROS 1, master {named}; --ros2 looks at ROS 2", file=sys.stderr)
    return named


def _look_at_ros1(master: str, seconds: float) -> Found:
    try:
        from talaia.gateway.adapters.ros1.probe import DEFAULT_MASTER, probe_graph as look_at_ros1
    except ImportError as error:
        raise PartMissing("talaia probe --ros1", error.name or "rosbags", "gateway") from error
    uri = master or os.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER
    where = urlsplit(uri)
    if where.scheme != "http" or not where.hostname:
        raise CliError(f"--ros1: expected http://HOST:11311, found {uri!r}")
    _print_listening(seconds)
    return look_at_ros1(uri, seconds)


def _look_at_indi(place: str, seconds: float, connect: bool) -> Found:  # noqa: FBT001
    from talaia.gateway.adapters.indi.probe import probe_server as look_at_indi

    host, port = read_server_address("--indi", place, INDI_PORT)
    print("asking …", file=sys.stderr, flush=True)
    return look_at_indi(host, port, seconds, connect=connect)


def _print_listening(seconds: float) -> None:
    print(f"listening for {seconds:g} s …", file=sys.stderr, flush=True)


def _as_text(found: Found, *, fields: bool) -> str:
    lines = [f"{found.where}, after {found.seconds:g} s"]
    lines += ["", "published topics"]
    for topic in found.topics:
        if topic.publishers:
            lines.append(_topic_line(topic))
            lines += _field_lines(topic) if fields else []
    if not any(topic.publishers for topic in found.topics):
        lines.append("  none")
    heard = [topic for topic in found.topics if not topic.publishers]
    if heard:
        lines += ["", "topics with subscribers only"]
        lines += [f"  {topic.topic:<36} {topic.type}" for topic in heard]
    for title, rows in (
        (
            "services",
            [(service.service, service.type, service.problem) for service in found.services],
        ),
        ("actions", [(action.action, action.type, action.problem) for action in found.actions]),
        ("nodes", [(node.node, _what_it_has(node), "") for node in found.nodes]),
    ):
        if rows:
            lines += ["", title]
            lines += [
                f"  {name:<36} {kind}" + (f"   ({problem})" if problem else "")
                for name, kind, problem in rows
            ]
    known = [(title, _of_types(found, types)) for title, types in _KNOWN.items()]
    if any(topics for _, topics in known):
        lines += ["", "of these"]
        lines += [f"  {title:<12} {', '.join(topics)}" for title, topics in known if topics]
    if not found.topics and not found.services:
        if found.url:
            return "\n".join([*lines, "", "Nothing was said meanwhile; --seconds listens longer."])
        same = f"ROS domain ({found.domain})" if found.protocol == "ros2" else "master"
        more = ", with the same RMW_IMPLEMENTATION" if found.protocol == "ros2" else ""
        lines += [
            "",
            f"Nothing was heard. Is the robot running, in the same {same},",
            f"on the same network{more}?",
        ]
    return "\n".join(lines)


def _what_it_has(node: NodeFound) -> str:
    count = len(node.parameters)
    parts = [f"life cycle: {node.state}"] if node.lifecycle else []
    parts += [f"{count} parameter{'s' if count > 1 else ''}"] if count else []
    return ", ".join(parts)


def _of_types(found: Found, types: tuple[str, ...]) -> list[str]:
    return [topic.topic for topic in found.topics if topic.publishers and topic.type in types]


def _field_lines(topic: TopicFound) -> list[str]:
    named = [f"      {name}" for name in topic.names]
    return named or [
        f"      {field.path:<36} {field.type}" + (f" in {field.unit}" if field.unit else "")
        for field in topic.fields
    ]


def _devices_told(found: Found, *, fields: bool) -> str:
    lines = [f"{found.where}, after {found.seconds:g} s", "", "devices"]
    for device in found.devices:
        state = "connected" if device.connected else "not connected"
        if found.protocol == "onvif":
            state = device.address
        count = f"{len(device.properties)} properties"
        lines.append(f"  {device.device:<28} {device.driver:<36} {state:<14} {count}")
        lines += [f"      {device.problem}"] if device.problem else []
        lines += [_property_line(one) for one in device.properties] if fields else []
    if not found.devices:
        asked = "Does indiserver run any driver?" if found.protocol == "indi" else ""
        lines += ["  none", "", asked]
    if found.protocol == "onvif":
        return "\n".join(lines)
    if any(not device.connected for device in found.devices):
        lines += ["", "A driver that is not connected shows little; --connect connects them."]
    return "\n".join(lines)


def _property_line(found: PropertyFound) -> str:
    shown = ", ".join(
        f"{element.element} {element.value}".strip() for element in found.elements[:4]
    )
    more = ", …" if len(found.elements) > 4 else ""
    kind = f"{found.type}{' (can be set)' if found.writable else ''}"
    return f"      {found.property:<28} {kind:<22} {shown}{more}"


def _topic_line(topic: TopicFound) -> str:
    what = topic.problem or (
        f"{len(topic.names)} sensors by name"
        if topic.names
        else f"{len(topic.fields)} field{'s' if len(topic.fields) != 1 else ''}"
    )
    return f"  {topic.topic:<36} {topic.type:<36} {topic.rate:>7.1f} Hz   {what}"
