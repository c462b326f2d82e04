"""What a gateway and the process of an extension's adapter say to each other: lines of JSON."""

from __future__ import annotations

import msgspec

__all__ = [
    "ActMessage",
    "AdapterJob",
    "CancelMessage",
    "DoneMessage",
    "EndMessage",
    "FromAdapter",
    "ReachableMessage",
    "ReportMessage",
    "SignalMessage",
    "ToAdapter",
    "UpMessage",
    "ValueMessage",
    "read_from_adapter",
    "read_to_adapter",
    "write_message",
]

Plain = bool | int | float | str


class SignalMessage(msgspec.Struct):
    """A signal to be read; see `WantedSignal`."""

    address: str
    device: str
    type: str
    unit: str
    states: tuple[str, ...]
    keys: dict[str, Plain]


class AdapterJob(msgspec.Struct, tag="job"):
    """The first line: which extension, with which keys."""

    connection: str
    extension: str
    keys: dict[str, Plain]
    folder: str
    devices: tuple[str, ...]
    signals: tuple[SignalMessage, ...]


class ActMessage(msgspec.Struct, tag="act"):
    """A command to be done."""

    # The gateway's own; `DoneMessage` and `CancelMessage` name it.
    number: int
    device: str
    command: str
    keys: dict[str, Plain]


class CancelMessage(msgspec.Struct, tag="cancel"):
    """A command to be ended early."""

    number: int


class UpMessage(msgspec.Struct, tag="up"):
    """The robot's side is reached."""


class ValueMessage(msgspec.Struct, tag="value"):
    """A value of a signal; now where there is no time."""

    address: str
    value: Plain
    time_us: int | None = None


class ReachableMessage(msgspec.Struct, tag="device"):
    """Whether one device answers."""

    device: str
    reachable: bool
    why: str = ""


class ReportMessage(msgspec.Struct, tag="report"):
    """Something to be written down."""

    kind: str
    message: str


class DoneMessage(msgspec.Struct, tag="done"):
    """How a command ended: ``succeeded``, ``failed``, ``refused`` or ``unknown``."""

    number: int
    phase: str
    message: str = ""


class EndMessage(msgspec.Struct, tag="end"):
    """The last line: why it ends, and whether that is the extension's own fault."""

    why: str
    broken: bool = False


ToAdapter = AdapterJob | ActMessage | CancelMessage
FromAdapter = UpMessage | ValueMessage | ReachableMessage | ReportMessage | DoneMessage | EndMessage
# Closed lists: a line of another kind is an error.
_TO: msgspec.json.Decoder[ToAdapter] = msgspec.json.Decoder(ToAdapter)
_FROM: msgspec.json.Decoder[FromAdapter] = msgspec.json.Decoder(FromAdapter)


def write_message(words: ToAdapter | FromAdapter) -> bytes:
    """Give a line."""
    return msgspec.json.encode(words) + b"\n"


def read_to_adapter(line: bytes) -> ToAdapter:
    """Read a line of the gateway's."""
    return _TO.decode(line)


def read_from_adapter(line: bytes) -> FromAdapter:
    """Read a line of the adapter's process; ``msgspec.MsgspecError`` where it is none."""
    return _FROM.decode(line)
