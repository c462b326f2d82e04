"""The founding observatory's JSON command file, read as devices of a site. Pure.

``command.ros`` is the prefix of every command, ``devices.<device>.commands`` maps an action to the
client's arguments, ``commands.info`` maps status fields to the arguments that read them, and
``messages.<field>`` maps an answer to a sentence.
"""

from __future__ import annotations

import json
from typing import NamedTuple, NoReturn

from talaia.model.connection import ProcessConnection, ProcessSource
from talaia.model.discovery.role_proposal import with_roles
from talaia.model.errors import DescriptionError, NotReadable
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    Device,
    DeviceKind,
    Signal,
    SignalType,
    Site,
)

__all__ = ["Classic", "read_classic", "site_of"]

MAX_BYTES = 1024 * 1024
# A client of ROS takes most of a second to start, and a dome its time to move.
MAX_AGE_S = 6.0
COMMAND_S = 180.0
# Actions whose optional parameters the founding clients knew, as arguments that can be checked.
_ARGUMENTS: dict[str, tuple[tuple[str, str, float, float], ...]] = {
    "goto": (("ra", "h", 0.0, 24.0), ("dec", "°", -90.0, 90.0)),
    "goto_altaz": (("alt", "°", 0.0, 90.0), ("az", "°", 0.0, 360.0)),
    "expose": (("seconds", "s", 0.0, 3600.0),),
}
# Numbers that stand in a longer answer: Alt:10.000000 Az:10.000000.
_NUMBERS = {
    "getcoord": (
        ("altitude", "Altitude", "°", r"Alt:\s*(-?\d+(?:\.\d+)?)"),
        ("azimuth", "Azimuth", "°", r"Az:\s*(-?\d+(?:\.\d+)?)"),
    )
}


class Classic(NamedTuple):
    """What a command file says.

    Attributes:
        prefix: stands before every command.

    """

    prefix: str
    devices: dict[str, Device]


def site_of(text: str, name: str) -> Site:
    """Make a whole site of a command file.

    Raises:
        DescriptionError: see `read_classic`.

    """
    found = read_classic(text)
    connection = ProcessConnection(prefix=found.prefix)
    return Site(
        talaia=1,
        site=name,
        name="Observatory",
        connections={"commands": connection},
        devices=found.devices,
    )


def read_classic(text: str, connection: str = "") -> Classic:
    """Read a command file.

    Args:
        text: the JSON.
        connection: the name of the connection that the devices are reached by.

    Raises:
        DescriptionError: with the path to the mistake and what was expected.

    """
    if len(text) > MAX_BYTES:
        raise NotReadable("$", f"the command file is longer than {MAX_BYTES // 1024} KiB")
    try:
        # JSON allows a key twice and Python keeps the last: a command would be lost without a word.
        document = json.loads(text, object_pairs_hook=_reject_duplicates)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise NotReadable(where, f"is not JSON: {error.msg}") from error
    except RecursionError as error:
        raise NotReadable("$", "is not JSON: it is nested too deeply") from error
    except DescriptionError:
        raise
    except ValueError as error:
        # Python makes no whole number of more than some thousand digits.
        raise NotReadable("$", "is not JSON: a number is too long") from error
    top = _expect_mapping("$", document, known=("command", "devices"))
    command = _expect_mapping("$.command", top.get("command", {}), known=("ros",))
    prefix = _expect_text("$.command.ros", command.get("ros", ""))
    devices = {
        name: _read_device(f"$.devices.{name}", name, described, connection)
        for name, described in _expect_mapping("$.devices", top.get("devices")).items()
    }
    if not devices:
        raise DescriptionError("$.devices", "there is no device", "describe at least one")
    return Classic(prefix, devices)


def _reject_duplicates(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found: dict[str, object] = {}
    for key, value in pairs:
        if key in found:
            raise NotReadable("$", f"the key {key!r} is written twice")
        found[key] = value
    return found


def _read_device(where: str, name: str, found: object, connection: str) -> Device:
    device = _expect_mapping(where, found, known=("commands", "messages"))
    commands = _expect_mapping(f"{where}.commands", device.get("commands", {}))
    messages = _expect_mapping(f"{where}.messages", device.get("messages", {}))
    info = _expect_mapping(f"{where}.commands.info", commands.get("info", {}))
    for field in messages:
        if field not in info:
            known = ", ".join(info) or "nothing"
            problem = f"there is no commands.info.{field}; it reads {known}"
            raise DescriptionError(f"{where}.messages.{field}", problem)
    signals: dict[str, Signal] = {}
    for field, line in info.items():
        at = f"{where}.messages.{field}"
        words = {
            answer: _expect_text(f"{at}.{answer}", said)
            for answer, said in _expect_mapping(at, messages.get(field, {})).items()
        }
        signals |= _read_signals(field, _expect_text(f"{where}.commands.info.{field}", line), words)
    # What such files call the power device.
    kinds = {kind.value: kind for kind in DeviceKind} | {"pdu": DeviceKind.POWER}
    return with_roles(
        Device(
            name=name.replace("_", " ").capitalize(),
            kind=kinds.get(name, DeviceKind.OTHER),
            connection=connection,
            signals=signals,
            commands={
                action: _make_command(action, _expect_text(f"{where}.commands.{action}", line))
                for action, line in commands.items()
                if action != "info"
            },
        )
    )


def _read_signals(field: str, line: str, messages: dict[str, str]) -> dict[str, Signal]:
    title = field.replace("_", " ").capitalize()
    # One answer that has a sentence is not yet a state; with two it can be one or the other.
    if len(messages) > 1:
        state = Signal(
            name=title,
            type=SignalType.STATE,
            states=tuple(messages),
            max_age=MAX_AGE_S,
            source=ProcessSource(run=line, messages=messages),
        )
        return {field: state}
    source = ProcessSource(run=line, messages=messages)
    text = Signal(name=title, type=SignalType.TEXT, max_age=MAX_AGE_S, source=source)
    numbers = {
        name: Signal(
            name=title,
            unit=unit,
            max_age=MAX_AGE_S,
            source=ProcessSource(run=line, pattern=pattern),
        )
        for name, title, unit, pattern in _NUMBERS.get(field, ())
    }
    return {field: text, **numbers}


def _make_command(action: str, line: str) -> Command:
    arguments = {
        name: Argument(
            type=ArgumentType.NUMBER, field=name, name=name, unit=unit, minimum=low, maximum=high
        )
        for name, unit, low, high in _ARGUMENTS.get(action, ())
    }
    # What else its client takes is not known: one text, and none by default.
    if not arguments:
        optional = Argument(
            type=ArgumentType.TEXT, field="parameters", name="Parameters", default=""
        )
        arguments = {"parameters": optional}
    places = " ".join(f"{{{name}}}" for name in arguments)
    return Command(
        name=action.replace("_", " ").capitalize(),
        kind=CommandKind.PROCESS,
        target=f"{line} {places}",
        arguments=arguments,
        timeout=COMMAND_S,
    )


def _expect_mapping(where: str, found: object, known: tuple[str, ...] = ()) -> dict[str, object]:
    if not isinstance(found, dict):
        kind = "nothing" if found is None else type(found).__name__
        raise DescriptionError(where, f"expected an object {{…}}, found {kind}")
    for key in found:
        if known and key not in known:
            raise DescriptionError(f"{where}.{key}", "unknown key", f"one of {', '.join(known)}")
    return found


def _expect_text(where: str, found: object) -> str:
    if isinstance(found, str):
        return found
    return _no_text(where, found)


def _no_text(where: str, found: object) -> NoReturn:
    raise DescriptionError(where, f"expected a text, found {found!r}")
