"""Whether types and fields of ROS exist that a description names; findings, raises nothing.

Asked for beside `check_site`, where something knows the types: a description may well be for a
robot whose packages are on no other machine.
"""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.checks.identifiers import FIELD, Finding
from talaia.model.checks.ros_types.field_walk import field_ends, list_names, part_names
from talaia.model.checks.ros_types.ros_value_checks import (
    filled_findings,
    picture_findings,
    text_notes,
)
from talaia.model.closed_lists import CommandKind, PositionFrame, SignalType
from talaia.model.connections.ros import RosSource

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.model.checks.ros_types.field_walk import FieldEnd, KnownTypes
    from talaia.model.site import Command, Device, Signal, Site

__all__ = ["RosTypeFindings", "ros_type_findings"]

_TYPE = re.compile(r"[a-z][a-z0-9_]*/(msg|srv|action)/[A-Z][A-Za-z0-9]*\Z")
# What a position's field has in it, by its frame.
_PLACE = {
    PositionFrame.WGS84: ("latitude", "longitude", "altitude"),
    PositionFrame.LOCAL: ("x", "y"),
}
# What a command's arguments fill, by its kind.
_ASKED = {CommandKind.SERVICE: "_Request", CommandKind.TOPIC: "", CommandKind.ACTION: "_Goal"}


class RosTypeFindings(NamedTuple):
    """Mistakes, and notes on what nothing here knows."""

    mistakes: list[Finding]
    notes: list[Finding]


class _Named(NamedTuple):
    """A type that a description names, with fields of it.

    Attributes:
        where: the place of the type; ``fields`` are by their places.
        value_at: the place of a field that has to be one value, or empty.
        place: of a position, the field that holds it and what has to be in that.

    """

    where: str
    type: str
    part: str
    fields: tuple[tuple[str, str], ...]
    value_at: str = ""
    place: tuple[str, str] | None = None


def ros_type_findings(site: Site, known: KnownTypes) -> RosTypeFindings:
    """Look for all types and fields of a description; what no version of a type has is wrong."""
    mistakes: list[Finding] = []
    notes: dict[str, Finding] = {}
    for named in _named_types(site):
        # One that is no type's name has its own finding.
        if not _TYPE.match(named.type):
            continue
        problems = _field_problems(known, named)
        if problems is not None:
            mistakes += problems
            continue
        package, middle, name = named.type.split("/")
        names = known.names_in(package, middle)
        # There, but not to be read here.
        if name in names:
            continue
        if names:
            near = get_close_matches(name, names, n=1, cutoff=0.6)
            remedy = f"did you mean {near[0]}?" if near else f"it has: {list_names(names)}"
            mistakes.append(Finding(named.where, f"no type {name} in {package}/{middle}", remedy))
        elif package not in notes:
            notes[package] = _package_note(known, named.where, package)
    mistakes += picture_findings(site, known)
    for device_id, device in site.devices.items():
        for command_id, command in device.commands.items():
            if command.type and command.kind in _ASKED:
                where = f"$.devices.{device_id}.commands.{command_id}"
                mistakes += filled_findings(where, command, _ASKED[command.kind], known)
    return RosTypeFindings(mistakes, [*notes.values(), *text_notes(site, known)])


def _package_note(known: KnownTypes, where: str, package: str) -> Finding:
    packages = known.packages()
    near = get_close_matches(package, packages, n=1, cutoff=0.75)
    problem = f"nothing here knows the package {package}: its types and fields were not checked"
    if near:
        return Finding(where, problem, f"did you mean {near[0]}?")
    remedy = "check it where the package is installed, or name its .msg files with definitions"
    return Finding(where, problem, remedy)


def _named_types(site: Site) -> Iterator[_Named]:
    for device_id, device in site.devices.items():
        at = f"$.devices.{device_id}"
        for signal_id, signal in device.signals.items():
            yield from _types_of_signal(f"{at}.signals.{signal_id}", signal)
        for stream_id, stream in device.streams.items():
            if isinstance(stream.source, RosSource) and stream.source.type:
                where = f"{at}.streams.{stream_id}.source.type"
                yield _Named(where, stream.source.type, "", ())
        yield from _types_of_commands(at, device)


def _types_of_signal(at: str, signal: Signal) -> Iterator[_Named]:
    source = signal.source
    if not isinstance(source, RosSource) or not source.type:
        return
    where = f"{at}.source.field"
    paths = [(f"{at}.source.stamp", source.stamp)]
    # Of a topic that carries sensors by name, the name says which; there is no field.
    if signal.type is SignalType.POSITION:
        paths += [(where, path) for path in _parts_of(source.field, _PLACE[signal.frame])]
    elif not source.name:
        paths.insert(0, (where, source.field))
    if signal.yaw_from:
        paths += [(f"{at}.yaw_from", path) for path in _parts_of(signal.yaw_from, "xyzw")]
    fields = tuple((place, path) for place, path in paths if path)
    is_value = signal.type in (SignalType.NUMBER, SignalType.STATE)
    place = None
    if signal.type is SignalType.POSITION:
        place = (source.field, " and ".join(_PLACE[signal.frame][:2]))
    value_at = where if is_value else ""
    yield _Named(f"{at}.source.type", source.type, "", fields, value_at, place)


def _parts_of(path: str, names: Iterable[str]) -> list[str]:
    return [f"{path}.{name}" if path else name for name in names]


def _types_of_commands(at: str, device: Device) -> Iterator[_Named]:
    for command_id, command in device.commands.items():
        where = f"{at}.commands.{command_id}"
        if command.type and command.kind in _ASKED:
            yield _Named(
                f"{where}.type", command.type, _ASKED[command.kind], _asked_fields(where, command)
            )
            if command.kind is CommandKind.ACTION and command.progress:
                fields = ((f"{where}.progress", command.progress),)
                yield _Named(f"{where}.type", command.type, "_Feedback", fields)


def _asked_fields(where: str, command: Command) -> tuple[tuple[str, str], ...]:
    arguments = [
        (f"{where}.arguments.{name}.field", argument.field)
        for name, argument in command.arguments.items()
    ]
    return (*arguments, *((f"{where}.fixed.{path}", path) for path in command.fixed))


def _field_problems(known: KnownTypes, named: _Named) -> list[Finding] | None:
    """Tell what is wrong with the fields of a type; None where nothing knows the type.

    Right is what any version has; so further ones are read for what is missing in the first alone.
    """
    # A path that is none has its own finding.
    open_ = [(where, path) for where, path in named.fields if FIELD.match(path)]
    first: dict[str, tuple[str, str]] = {}
    is_known = False
    for fields in known.versions_of(named.type, named.part):
        is_known = True
        for where, path in list(open_):
            problems = [
                end.wrong or (_value_problem(known, end) if where == named.value_at else None)
                for end in field_ends(known, fields, named.type, path.split("."))
            ]
            if None in problems:
                open_.remove((where, path))
            else:
                # The first version is the installed one: what it lacks is told.
                first.setdefault(where, next(filter(None, problems)))
        if not open_:
            break
    if not is_known:
        return None
    if named.place is not None:
        field, parts = named.place
        said = f"{field} of {named.type}" if field else named.type
        told = f"{said} holds no position", f"name the field that holds {parts}"
        first = {at: told if at.endswith(".field") else found for at, found in first.items()}
    # Of the parts of one position the first that is missing says enough.
    return [Finding(where, *first[where]) for where in dict(open_)]


def _value_problem(known: KnownTypes, end: FieldEnd) -> tuple[str, str] | None:
    """Tell of an end that is no one value; none where nothing knows what is in it."""
    if end.kind is None:
        return None
    if end.is_list:
        remedy = f"write which of it: {end.step}[0], {end.step}[1], …"
        return f"{end.step} of {end.owner} is a list", remedy
    parts = part_names(known, end.kind, end.step)
    if not parts:
        return None
    problem = f"{end.step} of {end.owner} is more than one value"
    return problem, f"write which of it: {list_names(parts)}"
