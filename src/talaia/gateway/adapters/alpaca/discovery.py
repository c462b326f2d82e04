"""From what an Alpaca device answers to a device with a page: signals and commands. Pure.

`questions_for` says what a device is asked once; `device_of` makes a description of the answers. A
property that a device says it has not (ASCOM's NotImplemented) becomes nothing.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.alpaca.standard_commands import STANDARD_COMMANDS
from talaia.gateway.adapters.alpaca.standard_signals import DEVICE_KINDS, STANDARD_SIGNALS
from talaia.model.connection import AlpacaSource
from talaia.model.discovery.role_proposal import with_roles
from talaia.model.roles import CommandRole, SignalRole
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    Device,
    DeviceKind,
    Signal,
    SignalType,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from talaia.gateway.adapters.alpaca.standard_commands import ArgumentRow, StandardMethod
    from talaia.gateway.adapters.alpaca.standard_signals import SignalRow

__all__ = [
    "MOST_SWITCHES",
    "FoundDevice",
    "device_of",
    "questions_for",
    "switch_questions",
    "unique_word",
]

MOST_SWITCHES = 32
_AGE = "timesincelastupdate"
# Of ``EquatorialSystem``: what goes behind right ascension and declination.
_EPOCHS = {1: "JNow", 2: "J2000", 3: "J2050", 4: "B1950"}
_NUMERIC = (ArgumentType.NUMBER, ArgumentType.INTEGER)
_STALE_S = 5.0
# Weather stations measure each minute or so.
_WEATHER_STALE_S = 120.0


class FoundDevice(NamedTuple):
    """A device and what it answered.

    Attributes:
        device: ``telescope/0``.
        name: as the server has it.
        answers: by property, with its query; one that it has not is missing, and one that it has
            but gives no value now is none.

    """

    device: str
    name: str
    answers: Mapping[str, object]

    @property
    def type(self) -> str:
        """Its ASCOM type, ``telescope``."""
        return self.device.partition("/")[0]


def questions_for(device_type: str) -> list[str]:
    """Name the properties that a device of a type is asked for."""
    names = [row.source for row in STANDARD_SIGNALS.get(device_type, ())]
    for command in STANDARD_COMMANDS.get(device_type, ()):
        names.append(command.needs)
        for argument in command.arguments:
            limits = (argument.low, argument.high, argument.needs)
            names += [limit.removeprefix("-") for limit in limits if isinstance(limit, str)]
            if argument.type in _NUMERIC and isinstance(argument.default, str):
                names.append(argument.default)
    names += {
        "telescope": ["equatorialsystem"],
        "focuser": ["absolute"],
        "filterwheel": ["names"],
        "switch": ["maxswitch"],
        "observingconditions": [
            f"{_AGE}?SensorName={row.source}" for row in STANDARD_SIGNALS["observingconditions"]
        ],
    }.get(device_type, [])
    return [name for name in dict.fromkeys(names) if name]


def switch_questions(count: object) -> list[str]:
    """Name what the switches of a device are asked for, by how many it says it has."""
    if isinstance(count, bool) or not isinstance(count, int):
        return []
    limits = ("minswitchvalue", "maxswitchvalue", "switchstep")
    parts = ("getswitchname", "canwrite", *limits, "getswitchvalue")
    return [f"{part}?Id={at}" for at in range(min(count, MOST_SWITCHES)) for part in parts]


def device_of(found: FoundDevice, connection: str) -> Device:
    """Describe a device."""
    signals: dict[str, Signal] = {}
    for row in STANDARD_SIGNALS.get(found.type, ()):
        if row.source in found.answers:
            signals[row.source] = _signal_of(found, row)
    commands = {
        row.id: _command_of(found, row)
        for row in STANDARD_COMMANDS.get(found.type, ())
        if _has(found, row)
    }
    if found.type == "switch":
        for at in range(MOST_SWITCHES):
            _add_switch(found, at, signals, commands)
    return with_roles(
        Device(
            name=_shown(found.name) or found.device,
            kind=DEVICE_KINDS.get(found.type, DeviceKind.OTHER),
            connection=connection,
            signals=signals,
            commands=commands,
        )
    )


def _signal_of(found: FoundDevice, row: SignalRow) -> Signal:
    states, kind = row.states, row.type
    if found.type == "filterwheel":
        names = found.answers.get("names")
        if isinstance(names, list) and names and len(set(map(str, names))) == len(names):
            # In the wheel's own order: its position counts them.
            states, kind = tuple(_shown(str(name)) or "?" for name in names), SignalType.STATE
            if len(set(states)) != len(states):
                states, kind = (), SignalType.NUMBER
    weather = found.type == "observingconditions"
    age = weather and f"{_AGE}?SensorName={row.source}" in found.answers
    epoch = _epoch_of(found) if row.source in ("rightascension", "declination") else ""
    return Signal(
        name=row.name + epoch,
        type=kind,
        unit="" if kind is SignalType.STATE else row.unit,
        states=states,
        role=row.role,
        meanings=row.meanings,
        minimum=row.minimum,
        maximum=row.maximum,
        primary=row.primary,
        max_age=_WEATHER_STALE_S if weather else _STALE_S,
        source=AlpacaSource(property=f"{found.device}/{row.source}", age=_AGE if age else ""),
    )


def _epoch_of(found: FoundDevice) -> str:
    system = found.answers.get("equatorialsystem")
    epoch = _EPOCHS.get(system) if isinstance(system, int) else None
    return f" ({epoch})" if epoch else ""


def _has(found: FoundDevice, row: StandardMethod) -> bool:
    if not row.needs:
        return True
    value = found.answers.get(row.needs)
    # A capability is a truth; what has a value is there.
    if row.needs.startswith("can"):
        return value is True
    if row.method == "move":
        # Of one that does not know where it stands, the position is how far it moves.
        relative = found.answers.get("absolute") is False
        return row.needs in found.answers and relative is (row.role is CommandRole.FOCUSER_MOVE)
    # 0: there is no cover.
    return row.needs in found.answers and not (row.needs == "coverstate" and value == 0)


def _command_of(found: FoundDevice, row: StandardMethod) -> Command:
    return Command(
        name=row.name,
        kind=CommandKind.ALPACA,
        target=f"{found.device}/{row.method}",
        role=row.role,
        fixed=dict(row.fixed),
        arguments={
            argument.id: _argument_of(found, argument)
            for argument in row.arguments
            if not argument.needs or argument.needs in found.answers
        },
        timeout=row.timeout,
        confirm=row.confirm,
        description=_filter_words(found) or row.description,
    )


def _filter_words(found: FoundDevice) -> str:
    """Say which filter stands at which place of a wheel; empty for another device."""
    names = found.answers.get("names")
    if found.type != "filterwheel" or not isinstance(names, list):
        return ""
    return ", ".join(f"{at} {_shown(str(name))}" for at, name in enumerate(names))[:200]


def _argument_of(found: FoundDevice, row: ArgumentRow) -> Argument:
    epoch = _epoch_of(found) if row.field in ("RightAscension", "Declination") else ""
    numeric = row.type in _NUMERIC
    # A text's own default is no property.
    default = (
        _limit(found, row.default) if numeric and isinstance(row.default, str) else row.default
    )
    return Argument(
        type=row.type,
        field=row.field,
        name=row.name + epoch,
        unit=row.unit,
        minimum=_limit(found, row.low) if numeric else None,
        maximum=_limit(found, row.high) if numeric else None,
        default=default,
        max_length=60 if row.type is ArgumentType.TEXT else 200,
    )


def _limit(found: FoundDevice, limit: float | str | None) -> float | None:
    if not isinstance(limit, str):
        return limit
    value = found.answers.get(limit.removeprefix("-"))
    if isinstance(value, list):
        return float(len(value) - 1) if value else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return -float(value) if limit.startswith("-") else float(value)


def _add_switch(
    found: FoundDevice, at: int, signals: dict[str, Signal], commands: dict[str, Command]
) -> None:
    """Describe one of a device's switches: a truth from 0 to 1 at once, else a number.

    A dimmer goes from 0 to 1 as well, in steps (ISwitchV2: of a truth the step is 1).
    """
    value = f"getswitchvalue?Id={at}"
    if value not in found.answers:
        return
    name = _shown(str(found.answers.get(f"getswitchname?Id={at}") or "")) or f"Switch {at}"
    low, high = (_limit(found, f"{end}switchvalue?Id={at}") for end in ("min", "max"))
    step = _limit(found, f"switchstep?Id={at}")
    boolean = (low, high) == (0.0, 1.0) and (step is None or step >= 1.0)
    signals[f"switch_{at}"] = Signal(
        name=name,
        type=SignalType.STATE if boolean else SignalType.NUMBER,
        states=("off", "on") if boolean else (),
        role=SignalRole.POWER_OUTLET if boolean else SignalRole.NONE,
        minimum=None if boolean else low,
        maximum=None if boolean else high,
        source=AlpacaSource(
            property=f"{found.device}/{'getswitch' if boolean else 'getswitchvalue'}?Id={at}"
        ),
    )
    if found.answers.get(f"canwrite?Id={at}") is not True:
        return
    argument = Argument(
        type=ArgumentType.BOOLEAN if boolean else ArgumentType.NUMBER,
        field="State" if boolean else "Value",
        name="On" if boolean else "Value",
        minimum=None if boolean else low,
        maximum=None if boolean else high,
    )
    commands[f"set_switch_{at}"] = Command(
        name=f"Set {name}"[:100],
        kind=CommandKind.ALPACA,
        target=f"{found.device}/{'setswitch' if boolean else 'setswitchvalue'}",
        role=CommandRole.POWER_SWITCH if boolean else CommandRole.NONE,
        fixed={"Id": at},
        arguments={"on" if boolean else "value": argument},
        timeout=30.0,
    )


def _shown(name: str) -> str:
    """Make a name that people can read of any text; may be empty."""
    seen = "".join(letter if letter.isprintable() else " " for letter in name)
    return " ".join(seen.split())[:100]


def unique_word(word: str, taken: Iterable[str]) -> str:
    """Give a word for an address, other than those that are taken."""
    used, unique, count = set(taken), word, 2
    while unique in used:
        unique, count = f"{word}_{count}", count + 1
    return unique
