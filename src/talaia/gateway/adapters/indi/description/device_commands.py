"""The commands of one INDI device, from what its driver has defined. Pure.

Standard commands come first (`standard_tables`), then what is asked for in several properties
(pointing, exposing); any other property that can be written is set by its own labels. A command is
given only where the driver has all that it sets, and at most `MAX_COMMANDS` plus the standard ones.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.adapters.indi.description.labels import (
    is_describable,
    label_without_unit,
    shown_name,
    unit_in_label,
    word_of,
)
from talaia.gateway.adapters.indi.description.shown_properties import is_property_shown
from talaia.gateway.adapters.indi.description.standard_tables import STANDARD_COMMANDS
from talaia.gateway.adapters.indi.goals import CHOICE
from talaia.gateway.adapters.indi.protocol import PropertyPermission, SwitchRule, VectorKind
from talaia.model.site import Argument, ArgumentType, Command, CommandKind

if TYPE_CHECKING:
    from talaia.gateway.adapters.indi.description.standard_tables import CommandRow
    from talaia.gateway.adapters.indi.protocol import Element
    from talaia.gateway.adapters.indi.state import IndiDevice, StoredVector

__all__ = ["MAX_COMMANDS", "commands_of"]

# After so many no more settings are added; the standard ones come before.
MAX_COMMANDS = 60
# A form with more fields than that is no command any more.
_MAX_ARGUMENTS = 12
# How the field begins that takes one of several labels.
_ONE_OF = "One of "


def commands_of(device: IndiDevice) -> dict[str, Command]:
    """Give a device's commands by their words: known ones first, then settings."""
    made: dict[str, Command] = {}
    known: set[str] = {row.target for row in STANDARD_COMMANDS}
    if "EQUATORIAL_EOD_COORD" in device.vectors:
        made |= _pointing_commands(device)
    if "CCD_EXPOSURE" in device.vectors:
        made["expose"] = _expose_command(device)
    known |= {"EQUATORIAL_EOD_COORD", "CCD_EXPOSURE"}
    for row in STANDARD_COMMANDS:
        held = device.vectors.get(row.target)
        if (
            held is not None
            and held.perm is not PropertyPermission.READ
            and _has_all_of(device, row)
        ):
            made[word_of(row.id, made)] = _standard_command(held, row)
    for held in device.vectors.values():
        if len(made) >= MAX_COMMANDS:
            break
        if (
            held.perm is not PropertyPermission.READ
            and held.name not in known
            and is_property_shown(held, device)
        ):
            _add_setting(made, held)
    return _distinguish_names(made)


def _distinguish_names(commands: dict[str, Command]) -> dict[str, Command]:
    """Add to names that several commands have what each of them sets.

    Drivers call a property and its switch alike: "Backlash" is on or off, and so many steps.
    """
    counts = Counter(command.name for command in commands.values())
    named = {}
    for word, command in commands.items():
        what = ", ".join(argument.name for argument in command.arguments.values())
        if counts[command.name] > 1 and what:
            name = f"{command.name} ({what.removeprefix(_ONE_OF)})"[:100]
            command = msgspec.structs.replace(command, name=name)
        named[word] = command
    return named


def _has_all_of(device: IndiDevice, row: CommandRow) -> bool:
    """Tell whether a driver has every element that a command sets."""
    wanted = [name for name, _ in row.fixed] + ([row.element] if row.element else [])
    for field in wanted:
        before, _, element = field.rpartition("/")
        if device.element_value(before or row.target, element) is None:
            return False
    return True


def _standard_command(held: StoredVector, row: CommandRow) -> Command:
    arguments = {}
    if row.element:
        element = held.elements[row.element]
        arguments[row.argument] = _number_argument(element, row.argument.capitalize(), row.unit)
    return Command(
        name=row.name,
        kind=CommandKind.INDI,
        target=row.target,
        fixed=dict(row.fixed),
        arguments=arguments,
        timeout=row.timeout,
        confirm=row.confirm,
        description=row.description,
    )


def _number_argument(element: Element, name: str, unit: str) -> Argument:
    # Equal limits are the protocol's way to say that there are none.
    limited = element.minimum < element.maximum
    return Argument(
        type=ArgumentType.NUMBER,
        field=element.name,
        name=name,
        unit=unit,
        minimum=element.minimum if limited else None,
        maximum=element.maximum if limited else None,
    )


def _pointing_commands(device: IndiDevice) -> dict[str, Command]:
    arguments = {
        "ra": Argument(
            type=ArgumentType.NUMBER,
            field="RA",
            name="Right ascension (JNow)",
            unit="h",
            minimum=0.0,
            maximum=24.0,
        ),
        "dec": Argument(
            type=ArgumentType.NUMBER,
            field="DEC",
            name="Declination (JNow)",
            unit="°",
            minimum=-90.0,
            maximum=90.0,
        ),
    }
    made = {}
    for element, word, name, timeout in (
        ("TRACK", "goto", "Go to", 600.0),
        ("SYNC", "sync", "Sync", 15.0),
    ):
        if device.element_value("ON_COORD_SET", element) is None:
            continue
        # One property does both: what it means was set just before (ON_COORD_SET).
        made[word] = Command(
            name=name,
            kind=CommandKind.INDI,
            target="EQUATORIAL_EOD_COORD",
            fixed={f"ON_COORD_SET/{element}": True},
            arguments=arguments,
            timeout=timeout,
            # A wrong sync makes every later slew go wrong.
            confirm=element == "SYNC",
            description="" if element == "TRACK" else "The telescope points there now.",
        )
    return made


def _expose_command(device: IndiDevice) -> Command:
    element = device.vectors["CCD_EXPOSURE"].elements.get("CCD_EXPOSURE_VALUE")
    # A driver without a limit of its own: an hour, so that a slip of a digit is noticed.
    longest = element.maximum if element is not None and element.maximum > 0 else 3600.0
    arguments = {
        "seconds": Argument(
            type=ArgumentType.NUMBER,
            field="CCD_EXPOSURE_VALUE",
            name="Exposure",
            unit="s",
            minimum=max(0.0, element.minimum) if element is not None else 0.0,
            maximum=longest,
        )
    }
    if "CCD_FRAME_TYPE" in device.vectors:
        arguments["frame"] = Argument(
            type=ArgumentType.TEXT,
            field=f"CCD_FRAME_TYPE/{CHOICE}",
            name="Frame",
            default="Light",
            max_length=20,
        )
    if device.element_value("FITS_HEADER", "FITS_OBJECT") is not None:
        arguments["target"] = Argument(
            type=ArgumentType.TEXT,
            field="FITS_HEADER/FITS_OBJECT",
            name="Target",
            default="Unknown",
            max_length=60,
        )
    return Command(
        name="Expose",
        kind=CommandKind.INDI,
        target="CCD_EXPOSURE",
        arguments=arguments,
        # From one word of the driver to the next: it counts down each second, then reads out.
        timeout=120.0,
    )


def _add_setting(made: dict[str, Command], held: StoredVector) -> None:
    """Let any other property be set by its own labels."""
    title = shown_name(held.label or held.name)
    elements = [element for element in held.elements.values() if is_describable(element.name)]
    # A single switch is a button: there is nothing to choose.
    if (
        held.kind is VectorKind.SWITCH
        and len(held.elements) == 1
        and held.rule is not SwitchRule.ANY
    ):
        made[word_of(held.name, made)] = Command(
            name=title,
            kind=CommandKind.INDI,
            target=held.name,
            fixed={elements[0].name: True} if elements else {},
        )
        return
    arguments: dict[str, Argument] = {}
    # Of several switches one is chosen by its label; "any of many" are set one by one.
    if held.kind is VectorKind.SWITCH and held.rule is not SwitchRule.ANY:
        words = ", ".join(shown_name(element.label or element.name) for element in elements)
        arguments["choice"] = Argument(
            type=ArgumentType.TEXT, field=CHOICE, name=f"{_ONE_OF}{words}"[:100], max_length=64
        )
    else:
        for element in elements[:_MAX_ARGUMENTS]:
            name = shown_name(label_without_unit(element.label) or element.name)
            word = word_of(name, arguments, "value")
            if held.kind is VectorKind.NUMBER:
                arguments[word] = _number_argument(element, name, unit_in_label(element.label))
            else:
                boolean = held.kind is VectorKind.SWITCH
                arguments[word] = Argument(
                    type=ArgumentType.BOOLEAN if boolean else ArgumentType.TEXT,
                    field=element.name,
                    name=name,
                )
    if arguments:
        made[word_of(f"set_{held.name}", made)] = Command(
            name=f"Set {title}"[:100],
            kind=CommandKind.INDI,
            target=held.name,
            arguments=arguments,
        )
