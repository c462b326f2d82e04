"""Cross-checks of connections, and of what devices take from them; part of `check`.

Long, because each protocol names things in its own way, and the ways are told apart here.
"""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia.model.camera_addresses import NO_ADDRESS, remedy_for, why_no_camera
from talaia.model.checks.identifiers import (
    Finding,
    above,
    field_fits,
    id_fits,
    topic_fits,
    type_fits,
)
from talaia.model.checks.indi_setup_checks import setup_findings
from talaia.model.checks.validity_checks import stamp_fits
from talaia.model.connection import (
    ROS_KINDS,
    ConnectionKind,
    ExtensionConnection,
    IndiConnection,
    ProcessConnection,
    Ros1Connection,
    Ros2Connection,
    RosbridgeConnection,
    VideoConnection,
    kind_of,
)
from talaia.model.errors import UnknownWord
from talaia.model.site import CommandKind, DeviceKind, SignalType

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.connection import Connection
    from talaia.model.site import Command, Device, Signal, Site, Source, Stream

__all__ = [
    "PLACEHOLDER",
    "command_fits",
    "connection_findings",
    "frames_fit",
    "link_of",
    "signal_source_fits",
    "stream_source_fits",
]

# A word of a command line that stands for an argument: `{ra}`.
PLACEHOLDER = re.compile(r"\{([A-Za-z][A-Za-z0-9_]*)\}")
# A whole FITS file, as a message.
_FILES = "std_msgs/msg/UInt8MultiArray"
_NODE = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_PARAMETER = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+/?[A-Za-z_][A-Za-z0-9_.]*\Z")
_MAX_INDI = 64
_COMMANDS = {
    CommandKind.SERVICE: ROS_KINDS,
    CommandKind.TOPIC: ROS_KINDS,
    CommandKind.ACTION: ROS_KINDS,
    CommandKind.PARAMETER: ROS_KINDS - {ConnectionKind.ROSBRIDGE},
    CommandKind.INDI: frozenset({ConnectionKind.INDI}),
    CommandKind.PROCESS: frozenset({ConnectionKind.PROCESS}),
    CommandKind.EXTENSION: frozenset({ConnectionKind.EXTENSION}),
}
_STAMP_KEYS = ("stamp", "synchronized")
_ROS_KEYS = ("topic", "type", "field", "name", "parameter", *_STAMP_KEYS)
_INDI_KEYS = ("property", "element", "device", *_STAMP_KEYS)
_PROCESS_KEYS = ("run", "pattern", "messages")
_VIDEO_KEYS = ("url", "file")
_EXTENSION_KEYS = ("keys",)
# As the kernel names them: /dev/video0, or /dev/v4l/by-id/….
_SEEN_KEYS = ("stream", "sees", "within")
_CAMERA_FILE = re.compile(r"/dev/(video[0-9]{1,3}|v4l/by-(id|path)/[A-Za-z0-9_.:+-]{1,200})\Z")
_EXAMPLES = {
    ConnectionKind.VIDEO: "url: rtsp://camera.local/stream, or file: /dev/video0",
    ConnectionKind.ROS2: "topic: /odom, type: nav_msgs/msg/Odometry, field: …",
    ConnectionKind.ROS1: "topic: /odom, type: nav_msgs/msg/Odometry, field: …",
    ConnectionKind.ROSBRIDGE: "topic: /odom, type: nav_msgs/msg/Odometry, field: …",
    ConnectionKind.INDI: "property: EQUATORIAL_EOD_COORD, element: RA",
    ConnectionKind.PROCESS: "run: dome_servcli client status",
    ConnectionKind.EXTENSION: "keys: {…}",
}


# ── the connections themselves ──


def connection_findings(site: Site) -> Iterator[Finding]:
    """List what is wrong with a site's connections."""
    if site.ros2 is not None and "ros2" in site.connections:
        yield Finding(
            "$.connections.ros2", "ros2 is described twice", "leave out the key ros2 of the site"
        )
    for name, connection in site.links().items():
        short = site.ros2 is not None and name == "ros2"
        where = "$.ros2" if short else f"$.connections.{name}"
        yield from id_fits(where, name)
        yield from _connection(where, connection)


def _connection(where: str, connection: Connection) -> Iterator[Finding]:
    match connection:
        case Ros2Connection():
            if connection.domain is not None and not 0 <= connection.domain <= 232:
                problem = f"expected a ROS domain id from 0 to 232, found {connection.domain}"
                yield Finding(f"{where}.domain", problem)
            yield from _node_fits(where, connection.node)
        case Ros1Connection():
            if connection.master:
                master = f"{where}.master"
                yield from _url_fits(master, connection.master, ("http",), "robot:11311")
            if connection.namespace != "/":
                yield from topic_fits(f"{where}.namespace", connection.namespace)
            yield from _node_fits(where, connection.node)
            if not connection.python.startswith("/"):
                problem = f"{connection.python!r} is not an absolute path"
                yield Finding(f"{where}.python", problem, "write /usr/bin/python3")
        case RosbridgeConnection():
            yield from _url_fits(f"{where}.url", connection.url, ("ws", "wss"), "robot:9090")
            if connection.ros not in (1, 2):
                yield Finding(f"{where}.ros", f"expected 1 or 2, found {connection.ros}")
            if connection.token_file and connection.token_env:
                yield Finding(f"{where}.token_env", "token_file is given, too", "leave one out")
        case IndiConnection():
            if not connection.host or not connection.host.isprintable():
                yield Finding(f"{where}.host", "there is no host", "write: host: 127.0.0.1")
            if not 1 <= connection.port <= 65_535:
                yield Finding(f"{where}.port", f"expected 1 to 65535, found {connection.port}")
        case ProcessConnection():
            yield from above(f"{where}.poll", connection.poll, 0)
            yield from above(f"{where}.timeout", connection.timeout, 0)
            yield from _line_fits(f"{where}.prefix", connection.prefix, empty=True)
        case ExtensionConnection():
            # See `extension_rules`.
            pass
        case VideoConnection():
            if connection.password_file and not connection.user:
                yield Finding(f"{where}.user", "whose password is it?", "write: user: viewer")


def _node_fits(where: str, node: str) -> Iterator[Finding]:
    if not _NODE.match(node):
        yield Finding(f"{where}.node", f"{node!r} is not the name of a node", "as talaia_gateway")


def _url_fits(
    where: str,
    url: str,
    schemes: tuple[str, ...],
    example: str,
    instead: str = "use token_file or token_env",
) -> Iterator[Finding]:
    remedy = f"write it as {schemes[0]}://{example}"
    try:
        parts = urlsplit(url)
        fits = parts.scheme in schemes and bool(parts.hostname) and parts.port != 0
    except ValueError:
        yield Finding(where, "it is not an address", remedy)
        return
    if not fits:
        yield Finding(where, f"expected {' or '.join(schemes)}://host:port", remedy)
    elif parts.username or parts.password:
        yield Finding(where, "there is a password in it", instead)


def _line_fits(where: str, line: str, *, empty: bool = False) -> Iterator[Finding]:
    try:
        words = shlex.split(line)
    except ValueError as error:
        yield Finding(where, f"cannot be cut into arguments: {error}", "close every quote")
        return
    if not words and not empty:
        yield Finding(where, "there is no command", "write: dome_servcli client status")
    if any(ord(letter) < 32 for letter in line):
        yield Finding(where, "there are control characters in it", "write it on one line")


# ── what devices take from them ──


def link_of(site: Site, where: str, device: Device) -> tuple[Connection | None, list[Finding]]:
    """Find the connection of a device, or what is wrong about it."""
    links = site.links()
    if device.connection:
        link = links.get(device.connection)
        if link is None and links:
            word = UnknownWord(f"{where}.connection", "connection", device.connection, links)
            return None, [Finding(word.where, word.problem, word.remedy)]
        if link is not None:
            return link, _fits_link(where, device, link)
    needs = device.signals or device.streams or device.commands or device.frames
    if not links:
        if not needs:
            return None, []
        problem = "its signals need a connection, and the site has none"
        return None, [Finding(where, problem, "add: ros2: {}")]
    if len(links) == 1:
        link = next(iter(links.values()))
        return link, _fits_link(where, device, link)
    if not needs and device.drive is None:
        return None, []
    problem = "the site has several connections, and which one is meant is not said"
    remedy = f"write one of: {', '.join(sorted(links))}"
    return None, [Finding(f"{where}.connection", problem, remedy)]


def _fits_link(where: str, device: Device, link: Connection) -> list[Finding]:
    kind = kind_of(link)
    found = []
    if device.drive is not None and kind not in ROS_KINDS:
        problem = f"a connection of kind {kind} cannot drive"
        found.append(Finding(f"{where}.drive", problem, "reach the device by ROS"))
    if device.indi and kind is not ConnectionKind.INDI:
        problem = f"its connection is of kind {kind}"
        found.append(Finding(f"{where}.indi", problem, "leave it out"))
    if device.indi:
        found += _indi_word_fits(f"{where}.indi", device.indi, "INDI device")
    found += setup_findings(where, device)
    has = [
        part_of_device.source
        for part in (device.signals, device.streams)
        for part_of_device in part.values()
    ]
    nameless = device.commands or any(not source.device for source in has)
    if kind is ConnectionKind.INDI and nameless and not device.indi:
        problem = "the name of the device at the INDI server is missing"
        found.append(Finding(f"{where}.indi", problem, "write: indi: Telescope Simulator"))
    return found


def signal_source_fits(where: str, signal: Signal, link: Connection) -> Iterator[Finding]:
    """List what is wrong with where a signal comes from."""
    kind, source = kind_of(link), signal.source
    yield from _keys_fit(where, source, kind)
    yield from stamp_fits(where, signal, kind)
    if kind is ConnectionKind.ROSBRIDGE and source.parameter:
        yield Finding(f"{where}.parameter", "a rosbridge reads no parameters", "take a topic")
    elif kind in ROS_KINDS and source.parameter:
        if not _PARAMETER.match(source.parameter):
            problem = f"{source.parameter!r} is not the name of a parameter"
            yield Finding(f"{where}.parameter", problem, "write it as /node/name")
        if source.topic:
            yield Finding(f"{where}.parameter", "a topic is given, too", "leave one out")
    elif kind in ROS_KINDS:
        yield from _ros_source(where, source)
        if signal.type is not SignalType.POSITION and not source.field and not source.name:
            problem = "which field of the message is meant?"
            yield Finding(f"{where}.field", problem, "write: field: data")
    elif kind is ConnectionKind.EXTENSION:
        # What its keys must be is the extension's to say: see `extension_rules`.
        return
    elif kind is ConnectionKind.VIDEO:
        yield Finding(where, "a camera gives no signals", "take another connection for them")
    elif signal.type is SignalType.POSITION:
        problem = f"a connection of kind {kind} gives no positions"
        yield Finding(where, problem, "make a signal of each number")
    elif kind is ConnectionKind.INDI:
        yield from _indi_word_fits(f"{where}.property", source.property, "INDI property")
        if signal.type is SignalType.NUMBER and not source.element:
            yield Finding(f"{where}.element", "which element is meant?", "write: element: RA")
    else:
        yield from _line_fits(f"{where}.run", source.run)
        yield from _pattern_fits(f"{where}.pattern", source.pattern)


def stream_source_fits(where: str, stream: Stream, link: Connection) -> Iterator[Finding]:
    """List what is wrong with where pictures come from."""
    kind, source = kind_of(link), stream.source
    yield from _keys_fit(where, source, kind)
    if kind in ROS_KINDS:
        yield from _ros_source(where, source)
    elif kind is ConnectionKind.INDI:
        yield from _indi_word_fits(f"{where}.property", source.property, "INDI property")
    elif isinstance(link, VideoConnection):
        yield from _camera_fits(where, source, link)
    else:
        problem = f"a connection of kind {kind} gives no pictures"
        yield Finding(where, problem, "reach the camera otherwise")


def frames_fit(where: str, device: Device, link: Connection) -> Iterator[Finding]:
    """List what is wrong with where a camera's FITS files come from."""
    kind, source = kind_of(link), device.frames
    if source is None:
        return
    if device.kind is not DeviceKind.CAMERA:
        problem = f"only a camera has FITS files, and this is of kind {device.kind}"
        yield Finding(where, problem, "write at the device: kind: camera")
    if kind is ConnectionKind.INDI:
        yield Finding(where, "FITS files of an INDI camera come by themselves", "leave it out")
        return
    if kind not in (ConnectionKind.ROS2, ConnectionKind.ROS1):
        problem = f"a connection of kind {kind} gives no FITS files"
        yield Finding(where, problem, "reach the camera by ros2, ros1 or indi")
        return
    yield from _keys_fit(where, source, kind)
    yield from topic_fits(f"{where}.topic", source.topic)
    if source.type != _FILES:
        problem = f"expected {_FILES}, found {source.type or 'nothing'}"
        yield Finding(f"{where}.type", problem, f"write: type: {_FILES}")
    for key in ("field", "name", "parameter"):
        if getattr(source, key):
            yield Finding(f"{where}.{key}", "the whole message is the file", "leave it out")


def _keys_fit(where: str, source: Source, kind: ConnectionKind) -> Iterator[Finding]:
    keys = {
        ConnectionKind.INDI: _INDI_KEYS,
        ConnectionKind.PROCESS: _PROCESS_KEYS,
        ConnectionKind.VIDEO: _VIDEO_KEYS,
        ConnectionKind.EXTENSION: _EXTENSION_KEYS,
    }
    fitting = keys.get(kind, _ROS_KEYS)
    known = (*_ROS_KEYS, *_INDI_KEYS, *_PROCESS_KEYS, *_VIDEO_KEYS, *_EXTENSION_KEYS)
    for key in dict.fromkeys(known):
        if key not in fitting and getattr(source, key):
            problem = f"a connection of kind {kind} knows no {key}"
            yield Finding(f"{where}.{key}", problem, f"write as: {_EXAMPLES[kind]}")
    for key in _SEEN_KEYS:
        if getattr(source, key):
            problem = "it belongs to a signal that counts what a camera sees"
            yield Finding(f"{where}.{key}", problem, "write both stream and sees, or leave it out")


def _camera_fits(where: str, source: Source, link: VideoConnection) -> Iterator[Finding]:
    if bool(source.url) == bool(source.file):
        yield Finding(where, "where is the camera?", f"write {_EXAMPLES[ConnectionKind.VIDEO]}")
    elif source.url:
        findings = [*_url_fits(
            f"{where}.url", source.url, ("rtsp", "rtsps"), "camera.local/stream",
            "write user and password_file at the connection",
        )]  # fmt: skip
        yield from findings
        host = "" if findings else urlsplit(source.url).hostname or ""
        # A name is looked up, and checked likewise, when the camera is opened.
        why = why_no_camera(host, here=link.here)
        if why and why != NO_ADDRESS:
            yield Finding(f"{where}.url", f"a camera may not be at {host}, {why}", remedy_for(why))
    elif not _CAMERA_FILE.match(source.file):
        problem = f"{source.file[:80]!r} is not a camera's device file"
        yield Finding(f"{where}.file", problem, "write it as /dev/video0")


def _ros_source(where: str, source: Source) -> Iterator[Finding]:
    yield from topic_fits(f"{where}.topic", source.topic)
    yield from type_fits(f"{where}.type", source.type, "msg")
    if source.field:
        yield from field_fits(f"{where}.field", source.field)
    if source.name and source.field:
        yield Finding(f"{where}.name", "both name and field are given", "leave one out")


def _indi_word_fits(where: str, word: str, what: str) -> Iterator[Finding]:
    if not word:
        yield Finding(where, f"the name of the {what} is missing")
    elif len(word) > _MAX_INDI or not word.isprintable():
        yield Finding(where, f"{word[:80]!r} is not the name of an {what}")


def _pattern_fits(where: str, pattern: str) -> Iterator[Finding]:
    if not pattern:
        return
    try:
        groups = re.compile(pattern).groups
    except (re.error, RecursionError, OverflowError) as error:
        yield Finding(where, f"is not a regular expression: {error}")
        return
    if groups != 1:
        yield Finding(where, f"expected one group, found {groups}", r"write as: Alt:(\S+)")


def command_fits(where: str, command: Command, link: Connection) -> Iterator[Finding]:
    """List what is wrong with what a command reaches, and with what its arguments fill."""
    kind = kind_of(link)
    if kind not in _COMMANDS[command.kind]:
        fitting = ", ".join(allowed for allowed, kinds in _COMMANDS.items() if kind in kinds)
        problem = f"{command.kind} is not for a connection of kind {kind}"
        yield Finding(f"{where}.kind", problem, f"write one of: {fitting}")
        return
    old = isinstance(link, RosbridgeConnection) and link.ros == 1
    if old and command.kind is CommandKind.ACTION:
        yield Finding(f"{where}.kind", "a rosbridge of ROS 1 has no actions", "call a service")
    fields = [(f"{where}.fixed.{field}", field) for field in command.fixed]
    for name, argument in command.arguments.items():
        fields.append((f"{where}.arguments.{name}.field", argument.field))
    match command.kind:
        case CommandKind.INDI:
            yield from _indi_word_fits(f"{where}.target", command.target, "INDI property")
            for at, field in fields:
                yield from _indi_word_fits(at, field, "INDI element")
        case CommandKind.PROCESS:
            yield from _process_command(where, command.target, fields)
        case CommandKind.EXTENSION:
            # See `extension_rules`.
            pass
        case _:
            yield from topic_fits(f"{where}.target", command.target)
            middle = {
                CommandKind.SERVICE: "srv",
                CommandKind.TOPIC: "msg",
                CommandKind.ACTION: "action",
            }.get(command.kind)
            if middle is not None:
                yield from type_fits(f"{where}.type", command.type, middle)
            for at, field in fields:
                yield from field_fits(at, field)
    if command.type and command.kind not in (
        CommandKind.SERVICE, CommandKind.TOPIC, CommandKind.ACTION,
    ):  # fmt: skip
        yield Finding(f"{where}.type", f"{command.kind} has no type", "leave it out")


def _process_command(where: str, target: str, fields: list[tuple[str, str]]) -> Iterator[Finding]:
    findings = [*_line_fits(f"{where}.target", target)]
    yield from findings
    if findings:
        return
    # A placeholder is a whole argument, so that what a person writes stays one argument.
    words = shlex.split(target)
    places = [found[1] for word in words if (found := PLACEHOLDER.fullmatch(word))]
    for at, field in fields:
        if field not in places:
            yield Finding(at, f"there is no {{{field}}} in the target", "write it as its own word")
    filled = {field for _, field in fields}
    for place in places:
        if place not in filled:
            problem = f"nothing fills {{{place}}}"
            yield Finding(f"{where}.target", problem, "add an argument with this field")
    for word in words:
        if not PLACEHOLDER.fullmatch(word) and PLACEHOLDER.search(word):
            problem = f"{word!r}: a placeholder is an argument of its own"
            yield Finding(f"{where}.target", problem, "put spaces round it")
