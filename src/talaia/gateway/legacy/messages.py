"""The founding observatory's WebSocket messages: what was asked, and the answers. Pure.

A client asks ``{"msg": "status"}`` once a second, and acts with
``{"msg": {"action": {"dome": {"action": {"open": " "}}}}}``, whose last value carries optional
parameters as one text.
"""

from __future__ import annotations

import json
import math
import shlex
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.model.connection import ProcessSource, source_as
from talaia.model.list_texts import LIST_TYPES
from talaia.model.site import ArgumentType, SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.ports import Field, SampleSink
    from talaia.model.site import Command, Signal, Site
    from talaia.wire.columns import Columns

__all__ = [
    "MAX_MESSAGE",
    "UNKNOWN",
    "LegacyAction",
    "LegacyRequestError",
    "NewestValues",
    "read_message",
    "status_of",
]

MAX_MESSAGE = 16 * 1024  # Bytes; a longer one ends the connection.
MAX_ACTIONS = 8  # In one message.
UNKNOWN = "unknown"  # Said of what is not known, or is too old.


class LegacyRequestError(Exception):
    """A message that asks for nothing that there is; its text says why."""


class LegacyAction(NamedTuple):
    """One thing that was asked for, with its arguments by name."""

    device: str
    command: str
    args: dict[str, Field]


class _Value(NamedTuple):
    value: float
    text: str
    mono_ns: int  # When it came (monotonic).


class NewestValues:
    """A `SampleSink` that keeps the newest value of each channel, and passes all on. Any thread."""

    def __init__(
        self, first: Mapping[str, int], onward: SampleSink, now_ns: Callable[[], int]
    ) -> None:
        """Stand before another sink; ``now_ns`` gives monotonic time.

        ``first`` has the number of each signal's first channel by its address; see
        `ChannelNumbering`.
        """
        self._onward = onward  # Where all samples go after this.
        self._now_ns = now_ns
        # By channel number; written by adapters' threads, one assignment each.
        self._values: dict[int, _Value] = {}
        self._first = first  # By address; replaced whole, so threads see the old or the new one.

    def redescribe(self, first: Mapping[str, int]) -> None:
        """Know the signals of another description from here on."""
        self._first = first

    def put_samples(self, columns: Columns) -> None:
        """See `SampleSink.put_samples`."""
        now = self._now_ns()
        # In the order they came, so the last of a channel stays.
        for index, channel in enumerate(columns.channel.tolist()):
            value = float(columns.value[index])
            self._values[channel] = _Value(value, columns.texts.get(index, ""), now)
        self._onward.put_samples(columns)

    def value_word(self, address: str, signal: Signal, now_ns: int) -> str:
        """Give a signal's newest value as a word; see `UNKNOWN`."""
        found = self._values.get(self._first[address])
        # By the monotonic clock, as everywhere: a value that is too old is not shown as one.
        if found is None or now_ns - found.mono_ns > round(signal.stale_after * SECOND):
            return UNKNOWN
        if signal.type is SignalType.TEXT:
            return found.text
        if not math.isfinite(found.value):
            return UNKNOWN
        if signal.type is SignalType.STATE:
            index = int(found.value)
            return signal.states[index] if 0 <= index < len(signal.states) else UNKNOWN
        return f"{found.value:g}"


def status_of(
    site: Site, newest: NewestValues, answers: Mapping[str, str], now_ns: int
) -> dict[str, dict[str, str]]:
    """Give what every device says now.

    A device of the command file says what its client printed, letter by letter, but for answers
    that ``messages`` names: those are given as it names them. Others say their signals' values.
    """
    status: dict[str, dict[str, str]] = {}
    for device_id, device in site.devices.items():
        said: dict[str, str] = {}
        for signal_id, signal in device.signals.items():
            address = f"{device_id}/{signal_id}"
            source = source_as(signal.source, ProcessSource)
            if source.pattern:  # a part of another field's answer
                continue
            if source.run:
                text = answers.get(address, UNKNOWN)
                word = text.strip()
                said[signal_id] = word if word in source.messages else text
            else:
                said[signal_id] = newest.value_word(address, signal, now_ns)
        status[device_id] = said
    return status


def read_message(text: str | bytes, site: Site) -> list[LegacyAction]:
    """Read a message: none for the status, else the actions, all of which fit.

    Raises:
        LegacyRequestError: it is malformed, or names what there is not. Then nothing of it is to
            be done.

    """
    try:
        # RecursionError: lists within lists, from a client that means ill.
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise LegacyRequestError(f"the message is not JSON: {error}") from error
    asked = document.get("msg") if isinstance(document, dict) else None
    if asked == "status":
        return []
    devices = asked.get("action") if isinstance(asked, dict) else None
    if not isinstance(devices, dict) or not devices:
        raise LegacyRequestError('expected {"msg": "status"} or {"msg": {"action": {…}}}')
    # All are read before the first is done: a message that is half wrong does nothing.
    actions: list[LegacyAction] = []
    for device_id, found in devices.items():
        device = site.devices.get(device_id)
        if device is None:
            # Cut: what a client says comes back in the answer and stands in the log.
            raise LegacyRequestError(
                f"there is no device {device_id[:60]!r}: {_expected_list(site.devices)}"
            )
        asks = found.get("action") if isinstance(found, dict) else None
        if not isinstance(asks, dict) or not asks:
            raise LegacyRequestError(f'{device_id}: expected {{"action": {{…}}}}')
        for name, parameters in asks.items():
            command = device.commands.get(name)
            if command is None:
                known = _expected_list(device.commands)
                raise LegacyRequestError(f"{device_id} has no action {name[:60]!r}: {known}")
            said = f"{device_id}/{name}"
            actions.append(
                LegacyAction(device_id, name, _split_arguments(said, command, parameters))
            )
    if len(actions) > MAX_ACTIONS:
        raise LegacyRequestError(f"{len(actions)} actions in one message; at most {MAX_ACTIONS}")
    return actions


def _expected_list(known: Mapping[str, object]) -> str:
    return f"expected one of {', '.join(known)}" if known else "there is none"


def _split_arguments(where: str, command: Command, parameters: object) -> dict[str, Field]:
    """Cut the one text into the command's arguments, in the order of the description."""
    # A truth first, for it is an int to Python.
    if isinstance(parameters, bool) or not isinstance(parameters, str | int | float):
        raise LegacyRequestError(f"{where}: expected the parameters as one text")
    text = str(parameters).strip()
    arguments = command.arguments
    # A single text is taken as it is, with its quotes and spaces.
    if len(arguments) == 1 and next(iter(arguments.values())).type in {
        ArgumentType.TEXT,
        *LIST_TYPES,
    }:
        return {next(iter(arguments)): text} if text else {}
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise LegacyRequestError(f"{where}: {error}") from error
    if len(words) > len(arguments):
        names = " ".join(argument.upper() for argument in arguments) or "nothing"
        raise LegacyRequestError(f"{where}: {len(words)} parameters; expected {names}")
    return {
        name: _read_typed(where, name, argument.type, word)
        # Fewer words than arguments: the others have their defaults.
        for (name, argument), word in zip(arguments.items(), words, strict=False)
    }


def _read_typed(where: str, name: str, kind: ArgumentType, word: str) -> Field:
    match kind:
        case ArgumentType.BOOLEAN:
            if word.lower() in ("on", "true", "1"):
                return True
            if word.lower() in ("off", "false", "0"):
                return False
            raise LegacyRequestError(f"{where}: {name}: expected on or off, found {word[:60]!r}")
        case ArgumentType.INTEGER | ArgumentType.NUMBER:
            try:
                return int(word) if kind is ArgumentType.INTEGER else float(word)
            except ValueError:
                problem = f"{where}: {name}: expected a number, found {word[:60]!r}"
                raise LegacyRequestError(problem) from None
        case _:
            return word
