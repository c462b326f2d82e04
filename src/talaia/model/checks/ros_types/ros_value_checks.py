"""Whether what a description fills into messages of ROS, or shows of them, can be that at all.

Beside `ros_type_checks`, which tells types and fields that are not there; findings, raises nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import FIELD, Finding
from talaia.model.closed_lists import ArgumentType
from talaia.model.connections.ros import RosSource

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from talaia.model.checks.ros_types.ros_type_checks import KnownTypes, RosFieldShape
    from talaia.model.site import Command, Site

__all__ = ["filled_findings", "picture_findings"]

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
        leaf = _leaf_of(known, command.type, part, argument.field)
        if leaf is None or leaf.many:
            continue
        said = f"{argument.field} of {command.type}"
        if leaf.base in _TRUTHS and argument.type is not ArgumentType.BOOLEAN:
            problem = f"{said} is true or false, and the argument is of type {argument.type}"
            yield Finding(at, problem, "write: type: boolean")
        elif "/" in leaf.base:
            yield Finding(f"{where}.arguments.{name}.field", *_parts_of(known, leaf, said))
        elif leaf.base not in _TEXTS and argument.type is ArgumentType.TEXT:
            kind = "number" if leaf.base.startswith(("float", "double")) else "integer"
            problem = f"{said} is a number, and the argument is of type text"
            yield Finding(at, problem, f"write: type: {kind}")


def _parts_of(known: KnownTypes, leaf: RosFieldShape, said: str) -> tuple[str, str]:
    fields = next(iter(known.versions_of(leaf.base)), {})
    name = said.partition(" ")[0]
    which = ", ".join(f"{name}.{field}" for field in list(fields)[:8])
    return f"{said} is more than one value", f"write which of it: {which}" if which else ""


def _leaf_of(known: KnownTypes, type_name: str, part: str, path: str) -> RosFieldShape | None:
    """Follow a path in the first version that has it; none where that is not known."""
    # A type or a path that is none has its own finding.
    if type_name.count("/") != 2 or not FIELD.match(path):
        return None
    for fields in known.versions_of(type_name, part):
        if (leaf := _follow(known, fields, path.split("."))) is not None:
            return leaf
    return None


def _follow(
    known: KnownTypes, fields: Mapping[str, RosFieldShape], steps: list[str]
) -> RosFieldShape | None:
    kind = fields.get(steps[0].partition("[")[0])
    # An element of a list is what the list is of.
    if kind is None or (kind.many and "[" in steps[0] and len(steps) == 1):
        return None
    if len(steps) == 1:
        return kind
    for version in known.versions_of(kind.base) if "/" in kind.base else ():
        if (leaf := _follow(known, version, steps[1:])) is not None:
            return leaf
    return None
