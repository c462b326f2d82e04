"""ASCOM Alpaca's words: what is asked, and what an answer says. Pure.

After "ASCOM Alpaca API Reference" (device API v1) and ASCOM's error numbers: an answer of status
200 has ``Value``, ``ErrorNumber`` and ``ErrorMessage``; 400 is a question that the server cannot
read, and 500 an error outside of what ASCOM knows, both with plain text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlencode

import msgspec

from talaia.gateway.errors import GatewayError

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = [
    "ERROR_NAMES",
    "NOT_CONNECTED",
    "NOT_IMPLEMENTED",
    "VALUE_NOT_SET",
    "AlpacaRefused",
    "Configured",
    "Scalar",
    "device_path",
    "parse_configured",
    "parse_discovery",
    "parse_value",
    "property_path",
    "put_form",
]

Scalar = float | int | bool | str

NOT_IMPLEMENTED = 0x400
VALUE_NOT_SET = 0x402
NOT_CONNECTED = 0x407
# ASCOM's own; those of drivers (0x500 to 0xFFF) have no name.
ERROR_NAMES = {
    0x400: "the device has no such thing",
    0x401: "the value is not one that the device takes",
    0x402: "it has no value yet",
    0x407: "the device is not connected to its hardware",
    0x408: "it is parked",
    0x409: "it is slaved to another device",
    0x40A: "the settings of the driver are wrong",
    0x40B: "it cannot be done now",
    0x40C: "the device has no such action",
    0x40D: "the driver is busy with something else",
    0x40E: "it was cancelled",
}
# With these nothing has happened; any other error may come from the middle of doing it.
_REFUSALS = frozenset(ERROR_NAMES) - {0x40E}
_MOST_WORDS = 400


class AlpacaRefused(GatewayError):
    """A device answers with an error.

    Attributes:
        number: ASCOM's, or 0 for what came as a plain status.
        refused: nothing was done; else it may have failed on the way.

    """

    def __init__(self, number: int, words: str, *, refused: bool | None = None) -> None:
        """Keep the number beside the sentence."""
        named = ERROR_NAMES.get(number, "the driver reports an error")
        shown = " ".join("".join(c if c.isprintable() else " " for c in words).split())
        code = f" (ASCOM error 0x{number:X})" if number else ""
        said = f": {shown[:_MOST_WORDS]}" if shown else ""
        super().__init__(f"{named}{code}{said}")
        self.number = number
        self.refused = number in _REFUSALS if refused is None else refused


class _Answer(msgspec.Struct):
    """What every answer has; names as ASCOM writes them."""

    error_number: int = msgspec.field(default=0, name="ErrorNumber")
    error_message: str | None = msgspec.field(default="", name="ErrorMessage")
    value: object = msgspec.field(default=None, name="Value")
    transaction: int = msgspec.field(default=0, name="ClientTransactionID")


class Configured(NamedTuple):
    """A device that a server says it has."""

    name: str
    device: str
    unique_id: str


class _ConfiguredWords(msgspec.Struct):
    name: str = msgspec.field(default="", name="DeviceName")
    type: str = msgspec.field(default="", name="DeviceType")
    number: int = msgspec.field(default=0, name="DeviceNumber")
    unique_id: str = msgspec.field(default="", name="UniqueID")


class _ConfiguredAnswer(msgspec.Struct):
    value: list[_ConfiguredWords] = msgspec.field(name="Value")


class _DiscoveryAnswer(msgspec.Struct):
    port: int = msgspec.field(name="AlpacaPort")


def device_path(address: str) -> str:
    """Give the path of what stands behind ``/api/v1/``."""
    return f"/api/v1/{address}"


def property_path(address: str, client: int, transaction: int) -> str:
    """Give the path that asks for a property (``telescope/0/rightascension``)."""
    path = device_path(address)
    numbers = urlencode({"ClientID": client, "ClientTransactionID": transaction})
    return f"{path}{'&' if '?' in path else '?'}{numbers}"


def put_form(fields: Mapping[str, Scalar], client: int, transaction: int) -> bytes:
    """Give a method's parameters as a form; truths as ``True`` and ``False``, as ASCOM has them."""
    numbers = {"ClientID": client, "ClientTransactionID": transaction}
    words = {
        # The shortest digits that mean this number, with a point: `1e-07` is a number to no driver
        # for certain.
        key: f"{value:.10f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
        for key, value in {**fields, **numbers}.items()
    }
    return urlencode(words).encode()


def parse_value(data: bytes, transaction: int) -> object:
    """Read an answer's value; none where a method gives none.

    Raises:
        AlpacaRefused: the device says that it is an error, or it is no answer of Alpaca's.

    """
    try:
        answer = msgspec.json.decode(data, type=_Answer)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise AlpacaRefused(0, f"its answer is none of Alpaca's: {data[:60]!r}") from error
    if answer.error_number:
        raise AlpacaRefused(answer.error_number, answer.error_message or "")
    # Some servers leave the number out; another question's answer must not count.
    if answer.transaction not in (0, transaction):
        raise AlpacaRefused(0, "its answer is that of another question")
    return answer.value


def parse_configured(data: bytes) -> list[Configured]:
    """Read ``/management/v1/configureddevices``.

    Raises:
        AlpacaRefused: it is no such answer.

    """
    try:
        answer = msgspec.json.decode(data, type=_ConfiguredAnswer)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise AlpacaRefused(0, f"its list of devices cannot be read: {data[:60]!r}") from error
    return [
        Configured(found.name, f"{found.type.lower()}/{found.number}", found.unique_id)
        for found in answer.value
        # What could not stand in an address is no device of ASCOM's.
        if found.type.isascii() and found.type.isalpha() and 0 <= found.number < 1_000_000_000
    ]


def parse_discovery(data: bytes) -> int | None:
    """Read the answer to `DISCOVERY_QUESTION`: the TCP port; none if it is something else."""
    try:
        port = msgspec.json.decode(data, type=_DiscoveryAnswer).port
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return None
    return port if 1 <= port <= 65_535 else None
