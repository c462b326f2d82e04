"""Which role each signal and command of a device has: what is said, then what is proposed. Pure.

A proposal goes by the device's kind and by type, unit, states, arguments and the words of id and
name, so that a description of before roles shows the pages that it always did. Who names things in
another language, or otherwise than the field does, says the role.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.discovery.command_roles import CommandRoles
from talaia.model.discovery.role_words import argument_with, is_number
from talaia.model.discovery.signal_roles import SignalRoles
from talaia.model.roles import SIGNAL_FITS, CommandRole, SignalRole, StateMeaning
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.site import Device, Signal

__all__ = [
    "DeviceRoles",
    "PlaceArguments",
    "meanings_of",
    "place_arguments",
    "roles_of",
    "with_roles",
]

# What states are called in English, by the role; the first that matches counts.
_MEANINGS: dict[SignalRole, tuple[tuple[re.Pattern[str], StateMeaning], ...]] = {
    SignalRole.DOME_SHUTTER: (
        (re.compile(r"open(ed)?", re.IGNORECASE), StateMeaning.OPEN),
        (re.compile(r"closed?", re.IGNORECASE), StateMeaning.CLOSED),
        (re.compile(r"opening", re.IGNORECASE), StateMeaning.OPENING),
        (re.compile(r"closing", re.IGNORECASE), StateMeaning.CLOSING),
        (re.compile(r"stopped|partial|partly.*|half.*|ajar", re.IGNORECASE), StateMeaning.PARTIAL),
        (re.compile(r"error|alert|fault|failed|stuck", re.IGNORECASE), StateMeaning.ERROR),
    ),
    SignalRole.CAMERA_STATE: (
        (re.compile(r"expos.*", re.IGNORECASE), StateMeaning.EXPOSING),
        (re.compile(r"reading|readout|download.*", re.IGNORECASE), StateMeaning.READING),
        (re.compile(r"idle|ready", re.IGNORECASE), StateMeaning.IDLE),
        (re.compile(r"error|alert|fault|failed", re.IGNORECASE), StateMeaning.ERROR),
    ),
    SignalRole.WEATHER_SAFETY: (
        (re.compile(r"unknown", re.IGNORECASE), StateMeaning.UNKNOWN),
        (re.compile(r"\W*(warn(ing)?|caution)\b.*", re.IGNORECASE), StateMeaning.WARNING),
        (
            re.compile(r"\W*(error|alert|fatal|critical|fault|unsafe)\b.*", re.IGNORECASE),
            StateMeaning.UNSAFE,
        ),
        # Any other word is shown as safe. Interlocks do not go by it: they name states themselves.
        (re.compile(r".*"), StateMeaning.SAFE),
    ),
}
# What a state of any other signal is called where something is wrong.
_GRAVE: tuple[tuple[re.Pattern[str], StateMeaning], ...] = (
    (re.compile(r"unknown", re.IGNORECASE), StateMeaning.UNKNOWN),
    (re.compile(r"\W*(warn(ing)?|caution)\b.*", re.IGNORECASE), StateMeaning.WARNING),
    (
        re.compile(r"\W*(error|alert|fatal|critical|fault|unsafe)\b.*", re.IGNORECASE),
        StateMeaning.ERROR,
    ),
    (re.compile(r".*"), StateMeaning.NORMAL),
)


class DeviceRoles(NamedTuple):
    """The roles of a device's signals and commands, by id; who has none is not in it."""

    signals: dict[str, SignalRole]
    commands: dict[str, CommandRole]


class PlaceArguments(NamedTuple):
    """A command that points a telescope, and its arguments for right ascension and declination."""

    command: str
    ra: str
    dec: str


def roles_of(device: Device) -> DeviceRoles:
    """Give every role of a device. What the description says wins; the rest is proposed."""
    signals = SignalRoles(device)
    # A twin is no second robot: pages that look for a robot's place or speed pass it over.
    if device.twin is None:
        signals.propose_roles()
    commands = CommandRoles(device, signals.roles)
    if device.twin is None:
        commands.propose_roles()
    return DeviceRoles(signals.roles, commands.roles)


def with_roles(device: Device) -> Device:
    """Give the device with each proposed role written down, as discovery hands it over."""
    roles = roles_of(device)
    replace = msgspec.structs.replace
    return replace(
        device,
        signals={
            name: replace(signal, role=roles.signals[name])
            if signal.role is SignalRole.AUTO and name in roles.signals
            else signal
            for name, signal in device.signals.items()
        },
        commands={
            name: replace(command, role=roles.commands[name])
            if command.role is CommandRole.AUTO and name in roles.commands
            else command
            for name, command in device.commands.items()
        },
    )


def meanings_of(signal: Signal, role: SignalRole | None) -> tuple[StateMeaning, ...]:
    """Say what each state of a signal means.

    Empty where nothing is out of the ordinary: no meaning is said, the role knows none, and no
    state is called as if something were wrong.
    """
    if signal.meanings or signal.type is not SignalType.STATE:
        return signal.meanings
    if role is not None and SIGNAL_FITS[role].meanings:
        return tuple(_meaning(word, _MEANINGS[role]) for word in signal.states)
    found = tuple(_meaning(word, _GRAVE) for word in signal.states)
    return found if {StateMeaning.WARNING, StateMeaning.ERROR} & set(found) else ()


def _meaning(word: str, known: Iterable[tuple[re.Pattern[str], StateMeaning]]) -> StateMeaning:
    found = (meaning for shape, meaning in known if shape.fullmatch(word))
    return next(found, StateMeaning.UNKNOWN)


def place_arguments(device: Device, roles: DeviceRoles) -> PlaceArguments | None:
    """Say by which command, and which of its arguments, the device is pointed; none by none."""
    for name, role in roles.commands.items():
        if role is not CommandRole.TELESCOPE_GOTO:
            continue
        command = device.commands[name]
        said = device.pointing.commands.get(name) if device.pointing is not None else None
        if said is not None and said.ra and said.dec:
            return PlaceArguments(name, said.ra, said.dec)
        ra, dec = (
            argument_with(command, "ra", "right"),
            argument_with(command, "dec", "declination"),
        )
        # Without telling names the first two numbers; see `CommandForm.PLACE`.
        if not ra or not dec:
            numbers = [key for key, argument in command.arguments.items() if is_number(argument)]
            # Filled up, so that there are always two.
            ra, dec = (*numbers, "", "")[:2]
        if ra and dec:
            return PlaceArguments(name, ra, dec)
    return None
