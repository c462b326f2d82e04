"""Whether what a description fills into messages of ROS, or shows of them, can be that at all.

Beside `ros_type_checks`, which tells types and fields that are not there; findings, raises nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import FIELD, Finding
from talaia.model.checks.ros_types.field_walk import field_ends, list_names, part_names
from talaia.model.closed_lists import ArgumentType, SignalType
from talaia.model.connections.ros import RosSource

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.checks.ros_types.field_walk import FieldEnd, KnownTypes
    from talaia.model.site import Command, Site

__all__ = ["filled_findings", "picture_findings", "text_notes"]

_TRUTHS = {"bool", "boolean"}
_TEXTS = {"string", "wstring"}
# What says how the bytes of a picture are to be read.
_OF_PICTURES = ({"data", "encoding"}, {"data", "format"})


def picture_findings(site: Site, known: KnownTypes) -> Iterator[Finding]:
    """List cameras whose messages hold no picture."""
    for device_id, device in site.devices.items():
        for stream_id, stream in device.streams.items():
            if not isinstance(stream.source, RosSource) or stream.source.type.count("/") != 2:
                continue
            versions = [set(fields) for fields in known.versions_of(stream.source.type)]
            if versions and not any(own <= has for has in versions for own in _OF_PICTURES):
                yield Finding(
                    f"$.devices.{device_id}.streams.{stream_id}.source.type",
                    f"{stream.source.type} holds no picture",
                    "take a topic of sensor_msgs/msg/Image or sensor_msgs/msg/CompressedImage",
                )


def text_notes(site: Site, known: KnownTypes) -> Iterator[Finding]:
    """Name numbers that are read from texts: that is right only where each text is a number."""
    for device_id, device in site.devices.items():
        for signal_id, signal in device.signals.items():
            source = signal.source
            if not isinstance(source, RosSource) or signal.type is not SignalType.NUMBER:
                continue
            end = _leaf_of(known, source.type, "", source.field)
            # Of a topic that carries sensors by name, the name says which; there is no field.
            if source.name or end is None or end.kind is None or end.kind.base not in _TEXTS:
                continue
            yield Finding(
                f"$.devices.{device_id}.signals.{signal_id}.source.field",
                f"{source.field} of {source.type} is a text, and the signal is a number: "
                "of a text that is no number nothing is shown",
                "if it holds words, write: type: text, or type: state with its words as states",
            )


def filled_findings(
    where: str, command: Command, part: str, known: KnownTypes
) -> Iterator[Finding]:
    """List arguments that their fields never take.

    Args:
        where: the command's place.
        command: one with a type.
        part: of that type which is filled: ``_Request``, ``_Goal``.
        known: what knows types.

    """
    for name, argument in command.arguments.items():
        at = f"{where}.arguments.{name}.type"
        end = _leaf_of(known, command.type, part, argument.field)
        if end is None or end.kind is None or end.is_list:
            continue
        leaf, said = end.kind, f"{argument.field} of {command.type}"
        if leaf.base in _TRUTHS and argument.type is not ArgumentType.BOOLEAN:
            problem = f"{said} is true or false, and the argument is of type {argument.type}"
            yield Finding(at, problem, "write: type: boolean")
        elif "/" in leaf.base:
            parts = list_names(part_names(known, leaf, argument.field))
            remedy = f"write which of it: {parts}" if parts else ""
            at = f"{where}.arguments.{name}.field"
            yield Finding(at, f"{said} is more than one value", remedy)
        elif leaf.base not in _TEXTS and argument.type is ArgumentType.TEXT:
            kind = "number" if leaf.base.startswith(("float", "double")) else "integer"
            problem = f"{said} is a number, and the argument is of type text"
            yield Finding(at, problem, f"write: type: {kind}")


def _leaf_of(known: KnownTypes, type_name: str, part: str, path: str) -> FieldEnd | None:
    """Follow a path to the first end that is there; none where that is not known."""
    # A type or a path that is none has its own finding.
    if type_name.count("/") != 2 or not FIELD.match(path):
        return None
    ends = (
        end
        for fields in known.versions_of(type_name, part)
        for end in field_ends(known, fields, type_name, path.split("."))
    )
    return next((end for end in ends if end.kind is not None), None)
