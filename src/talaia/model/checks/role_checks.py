"""Whether each role fits the signal or command that it stands on. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding
from talaia.model.roles import (
    ANY_MEANINGS,
    COMMAND_FITS,
    SIGNAL_FITS,
    CommandForm,
    CommandRole,
    SignalRole,
)
from talaia.model.site import ArgumentType, SignalType
from talaia.model.units.unit import unit_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from talaia.model.roles import StateMeaning
    from talaia.model.site import Command, Device, Signal

__all__ = ["role_findings"]

_NUMBERS = (ArgumentType.NUMBER, ArgumentType.INTEGER)


def role_findings(where: str, device: Device) -> Iterator[Finding]:
    """Check the roles that a device's description says; what is proposed fits by itself."""
    # Who has each role of which a device has one.
    holders: dict[SignalRole | CommandRole, str] = {}
    for signal_id, signal in device.signals.items():
        at = f"{where}.signals.{signal_id}"
        yield from _meanings_fit(at, signal)
        if signal.role in SIGNAL_FITS:
            yield from _signal_fits(at, signal)
            if not SIGNAL_FITS[signal.role].many:
                yield from _is_free(at, signal.role, signal_id, holders)
    # Emptied: ``camera.cooler`` is a role of signals and one of commands, and both are one word.
    holders = {}
    for command_id, command in device.commands.items():
        at = f"{where}.commands.{command_id}"
        if command.role in COMMAND_FITS:
            yield from _command_fits(at, command)
            if not COMMAND_FITS[command.role].many:
                yield from _is_free(at, command.role, command_id, holders)


def _is_free(
    where: str,
    role: SignalRole | CommandRole,
    name: str,
    holders: dict[SignalRole | CommandRole, str],
) -> Iterator[Finding]:
    other = holders.setdefault(role, name)
    if other != name:
        problem = f"{other!r} of this device is its {role} already"
        yield Finding(f"{where}.role", problem, "a device has one of each role: leave one out")


def _is_other_unit(found: str, wanted: tuple[str, ...]) -> bool:
    """Tell whether a unit is none of those wanted."""
    return bool(wanted) and unit_of(found).symbol not in wanted


def _signal_fits(where: str, signal: Signal) -> Iterator[Finding]:
    role, fit = signal.role, SIGNAL_FITS[signal.role]
    if signal.type not in fit.types:
        expected = " or ".join(fit.types)
        problem = f"{role} stands on a signal of type {expected}, found {signal.type}"
        yield Finding(f"{where}.role", problem, f"write: type: {fit.types[0]}")
    elif signal.type is SignalType.NUMBER and _is_other_unit(signal.unit, fit.units):
        expected = " or ".join(fit.units)
        problem = f"{role} is in {expected}, found {signal.unit or 'no unit'}"
        yield Finding(f"{where}.role", problem, f"write: unit: {fit.units[0]}")
    elif fit.states and len(signal.states) != fit.states:
        problem = f"{role} has {fit.states} states, off and on, found {len(signal.states)}"
        yield Finding(f"{where}.role", problem, "leave the role out")


def _meanings_fit(where: str, signal: Signal) -> Iterator[Finding]:
    if not signal.meanings:
        return
    at = f"{where}.meanings"
    if signal.type is not SignalType.STATE:
        yield Finding(at, f"states have meanings, found type {signal.type}", "leave them out")
        return
    fit = SIGNAL_FITS.get(signal.role)
    allowed = (fit.meanings if fit else ()) or ANY_MEANINGS
    if len(signal.meanings) != len(signal.states):
        problem = f"expected one for each of the {len(signal.states)} states"
        yield Finding(at, f"{problem}, found {len(signal.meanings)}")
    for index, meaning in enumerate(signal.meanings):
        if meaning not in allowed:
            problem = f"no state of {_role_text(signal.role)} means {str(meaning)!r}"
            yield Finding(f"{at}[{index}]", problem, _meaning_advice(meaning, allowed))


def _role_text(role: SignalRole) -> str:
    return role if role in SIGNAL_FITS else "a signal without a role"


def _meaning_advice(meaning: StateMeaning, allowed: Iterable[StateMeaning]) -> str:
    advice = f"one of: {', '.join(allowed)}"
    if allowed is not ANY_MEANINGS:
        return advice
    known = [role for role, fit in SIGNAL_FITS.items() if meaning in fit.meanings]
    return f"{advice}; or write the role: {' or '.join(known)}"


def _command_fits(where: str, command: Command) -> Iterator[Finding]:
    role, fit = command.role, COMMAND_FITS[command.role]
    if not any(_has_form(command, form, fit.unit) for form in fit.forms):
        expected = ", or ".join(fit.forms) + (f" in {fit.unit}" if fit.unit else "")
        found = ", ".join(command.arguments) or "none"
        problem = f"{role} asks for {expected}; its arguments: {found}"
        yield Finding(f"{where}.role", problem, "change the arguments, or write: role: none")


def _has_form(command: Command, form: CommandForm, unit: str) -> bool:
    arguments = list(command.arguments.values())
    match form:
        case CommandForm.PLAIN:
            return all(argument.default is not None for argument in arguments)
        case CommandForm.SWITCH:
            return [argument.type for argument in arguments] == [ArgumentType.BOOLEAN]
        case CommandForm.NUMBER:
            return len(arguments) == 1 and (
                arguments[0].type in _NUMBERS and arguments[0].unit == unit
            )
        case CommandForm.NUMBERS:
            return bool(arguments) and all(argument.type in _NUMBERS for argument in arguments)
        case CommandForm.TEXT:
            return [argument.type for argument in arguments] == [ArgumentType.TEXT]
        case CommandForm.DURATION:
            return any(argument.unit == "s" and argument.type in _NUMBERS for argument in arguments)
        case CommandForm.PLACE:
            return sum(argument.type in _NUMBERS for argument in arguments) >= 2
        case CommandForm.POSE:
            return _asks_for_pose(command)


def _asks_for_pose(command: Command) -> bool:
    """Tell whether a command can be given by a place and a heading alone."""
    found = command.arguments
    numbers = {name for name, argument in found.items() if argument.type in _NUMBERS}
    frame = found.get("frame")
    # In which frame it is meant has to be said: a goal in another one is somewhere else.
    if not {"x", "y"} <= numbers or frame is None or frame.type is not ArgumentType.TEXT:
        return False
    turned = "yaw" in numbers and found["yaw"].unit in {"rad", "°"}
    known = {"x", "y", "yaw", "qz", "qw", "frame"}
    rest = [argument for name, argument in found.items() if name not in known]
    return (turned or {"qz", "qw"} <= numbers) and all(one.default is not None for one in rest)
