"""What ROS 2, ROS 1 and rosbridge share: the source, topics, services, parameters, actions."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, ClassVar

from talaia.model.base import SourceShape
from talaia.model.checks.identifiers import Finding, field_fits, topic_fits, type_fits
from talaia.model.checks.validity_checks import stamp_fits
from talaia.model.closed_lists import CommandKind, DriveMessage, SignalType
from talaia.model.connections.rules import (
    ConnectionT,
    KindRules,
    argument_fields,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Command, Device, Signal

__all__ = [
    "DIAGNOSTICS",
    "LIFECYCLE_STATES",
    "LIFECYCLE_TRANSITIONS",
    "TRANSITION",
    "RosRules",
    "RosSource",
    "is_parameter_name",
    "node_fits",
]

# Names many parts of a robot, each with a level and words.
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
# The states of a life-cycle node between its transitions, and what it can be asked for.
LIFECYCLE_STATES = ("unconfigured", "inactive", "active", "finalized")
# By transition: the states from which it leads on (design.ros2.org/articles/node_lifecycle.html).
LIFECYCLE_TRANSITIONS = {
    "configure": ("unconfigured",),
    "activate": ("inactive",),
    "deactivate": ("active",),
    "cleanup": ("inactive",),
    "shutdown": ("unconfigured", "inactive", "active"),
}
# What a life-cycle command fills.
TRANSITION = "transition"
# A whole FITS file, as a message.
_FILES = "std_msgs/msg/UInt8MultiArray"
_NODE = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
# The node's absolute name, then the parameter's, in which dots may stand (ROS 2).
_PARAMETER = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+/?[A-Za-z_][A-Za-z0-9_.]*\Z")
# What stands in the middle of a type's name. Parameters are set without a type.
_MIDDLE = {
    CommandKind.SERVICE: "srv",
    CommandKind.TOPIC: "msg",
    CommandKind.ACTION: "action",
}


class RosSource(SourceShape, frozen=True, kw_only=True, tag="ros"):
    """Where a signal or a picture comes from in ROS 2, ROS 1 or behind a rosbridge.

    Attributes:
        topic: the topic, absolute (``/odom``).
        type: the topic's type, ``package/msg/Name``.
        field: the path of the field in the message: ``pose.pose.position.x``, ``ranges[0]``.
        name: for a topic that carries many sensors by name (CloudConnect's ``/metric``, ROS's
            ``/diagnostics``): which. Of diagnostics a state is the level and a text the message.
        parameter: a parameter instead of a topic, asked for once a second: ``/node/name``.
        lifecycle: ROS 2: a life-cycle node whose state it is, instead of a topic: ``/node``.
        stamp: the path of the value's own time, ``header.stamp``, which tells an old value that
            goes on arriving from a new one. Interlocks count a value from when its stamp last
            advanced.
        delay: instead of a field: by how much the stamp of a message's header lies before its
            arrival (s), where samples have the time of the stamp; else 0.
        synchronized: the clock behind ``stamp`` and the gateway's agree (NTP): a stamp that is
            further from the gateway's clock than ``max_age`` makes its value unknown.

    """

    topic: str = ""
    type: str = ""
    field: str = ""
    name: str = ""
    parameter: str = ""
    lifecycle: str = ""
    stamp: str = ""
    synchronized: bool = False
    delay: bool = False


class RosRules(KindRules[ConnectionT, RosSource]):
    """Checks what all three ways to ROS have in common."""

    source = RosSource
    example = "topic: /odom, type: nav_msgs/msg/Odometry, field: …"
    commands = frozenset(
        {CommandKind.SERVICE, CommandKind.TOPIC, CommandKind.ACTION, CommandKind.PARAMETER}
    )
    drives = True
    # Whether whole FITS files come as messages.
    files: ClassVar[bool] = True
    # Whether nodes have a life cycle (`rclcpp_lifecycle`).
    lifecycles: ClassVar[bool] = False

    def __init__(self, connection: ConnectionT) -> None:
        """Answer for this connection."""
        super().__init__(connection, RosSource)

    def device_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from super().device_findings(where, device)
        if device.drive is not None and device.drive.message is DriveMessage.PTZ:
            problem = "ptz is an ONVIF camera's, and no message of ROS"
            yield Finding(f"{where}.drive.message", problem, "reach the camera by kind: onvif")

    def signal_fits(self, where: str, signal: Signal, source: RosSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from stamp_fits(where, signal, source.stamp, synchronized=source.synchronized)
        judged = signal.type in (SignalType.NUMBER, SignalType.STATE)
        if source.stamp and judged and (what := _without_stamp(source)):
            yield Finding(f"{where}.stamp", f"{what} has no stamp", "leave the stamp out")
        elif source.stamp and judged:
            yield from field_fits(f"{where}.stamp", source.stamp)
        if source.lifecycle:
            yield from self.lifecycle_fits(where, signal, source)
            return
        # A parameter stands instead of a topic: no field and no type is asked for.
        if source.parameter:
            yield from self.parameter_fits(where, source)
            return
        yield from self.stream_fits(where, source)
        if source.delay:
            yield from _delay_fits(where, signal, source)
            return
        if signal.type is not SignalType.POSITION and not source.field and not source.name:
            problem = "which field of the message is meant?"
            yield Finding(f"{where}.field", problem, "write: field: data")

    def parameter_fits(self, where: str, source: RosSource) -> Iterator[Finding]:
        """Judge the name of a parameter."""
        if not is_parameter_name(source.parameter):
            problem = f"{source.parameter!r} is not the name of a parameter"
            yield Finding(f"{where}.parameter", problem, "write it as /node/name")
        if source.topic:
            yield Finding(f"{where}.parameter", "a topic is given, too", "leave one out")

    def lifecycle_fits(self, where: str, signal: Signal, source: RosSource) -> Iterator[Finding]:
        """Judge a signal that is the state of a life-cycle node."""
        at = f"{where}.lifecycle"
        if not self.lifecycles:
            problem = f"a connection of kind {self.kind} has no life-cycle nodes"
            yield Finding(at, problem, "take a topic")
            return
        yield from topic_fits(at, source.lifecycle)
        if signal.type not in (SignalType.STATE, SignalType.TEXT):
            problem = f"the state of a node is no {signal.type}"
            states = ", ".join(LIFECYCLE_STATES)
            yield Finding(at, problem, f"write: type: state, states: [{states}]")
        if source.topic or source.parameter:
            what = "topic" if source.topic else "parameter"
            yield Finding(at, f"a {what} is given, too", "leave one out")

    def stream_fits(self, where: str, source: RosSource) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from topic_fits(f"{where}.topic", source.topic)
        yield from type_fits(f"{where}.type", source.type, "msg")
        if source.field:
            yield from field_fits(f"{where}.field", source.field)
        if source.name and source.field:
            yield Finding(f"{where}.name", "both name and field are given", "leave one out")

    def frames_findings(self, where: str, device: Device) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        if not self.files:
            yield from super().frames_findings(where, device)
            return
        source = device.frames
        if source is None:
            return
        yield from self.foreign_findings(where, source)
        if not isinstance(source, RosSource):
            # Another protocol's, and perhaps an empty one, which has no foreign key to complain of.
            yield from topic_fits(f"{where}.topic", "")
            return
        yield from topic_fits(f"{where}.topic", source.topic)
        if source.type != _FILES:
            problem = f"expected {_FILES}, found {source.type or 'nothing'}"
            yield Finding(f"{where}.type", problem, f"write: type: {_FILES}")
        # A file is taken as it is: nothing in it is looked up.
        for key in ("field", "name", "parameter", "lifecycle"):
            if getattr(source, key):
                yield Finding(f"{where}.{key}", "the whole message is the file", "leave it out")

    def command_fits(self, where: str, command: Command) -> Iterator[Finding]:
        """See `ConnectionRules`."""
        yield from topic_fits(f"{where}.target", command.target)
        middle = _MIDDLE.get(command.kind)
        if middle is not None:
            yield from type_fits(f"{where}.type", command.type, middle)
        if command.kind is CommandKind.LIFECYCLE:
            yield from _transition_fits(where, command)
            return
        for at, field in argument_fields(where, command):
            yield from field_fits(at, field)


def _transition_fits(where: str, command: Command) -> Iterator[Finding]:
    """Judge which transition a command asks a life-cycle node for."""
    filled = {*command.fixed, *(argument.field for argument in command.arguments.values())}
    for field in sorted(filled - {TRANSITION}):
        problem = f"a life cycle has no field {field!r}"
        yield Finding(where, problem, f"write: fixed: {{{TRANSITION}: activate}}")
    if TRANSITION not in filled:
        yield Finding(
            where, "which transition is meant?", f"write: fixed: {{{TRANSITION}: activate}}"
        )
    asked = command.fixed.get(TRANSITION)
    if asked is not None and asked not in LIFECYCLE_TRANSITIONS:
        words = ", ".join(LIFECYCLE_TRANSITIONS)
        problem = f"{asked!r} is no transition"
        yield Finding(f"{where}.fixed.{TRANSITION}", problem, f"one of {words}")


def _delay_fits(where: str, signal: Signal, source: RosSource) -> Iterator[Finding]:
    """Judge a signal that tells by how much messages come after their stamps."""
    if signal.type is not SignalType.NUMBER:
        problem = f"a delay is a number of seconds, and no {signal.type}"
        yield Finding(f"{where}.delay", problem, "write: type: number")
    elif signal.unit != "s" or signal.scale != 1:
        yield Finding(f"{where}.delay", "a delay is in seconds", "write: unit: s")
    for key in ("field", "name"):
        if getattr(source, key):
            problem = f"{key} is given, too: which of the two is meant?"
            yield Finding(f"{where}.delay", problem, "leave one out")


def _without_stamp(source: RosSource) -> str:
    """Say what a source is that has no stamp; empty for one that may have one."""
    if source.lifecycle:
        return "a life cycle"
    if source.parameter:
        return "a parameter"
    if source.delay:
        return "a delay"
    return "a sensor by name" if source.name else ""


def is_parameter_name(name: str) -> bool:
    """Tell whether a description may name a parameter so."""
    return _PARAMETER.match(name) is not None


def node_fits(where: str, node: str) -> Iterator[Finding]:
    """Judge the gateway's node name of the connection at ``where``."""
    if not _NODE.match(node):
        problem = f"{node!r} is not the name of a node"
        yield Finding(f"{where}.node", problem, "write one word, as talaia_gateway")
