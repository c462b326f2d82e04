"""Payloads as JSON: values with unit, time and quality; commands with the time of their asking."""

from __future__ import annotations

import datetime as dt
import math
from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

from talaia.wire.errors import PeerError
from talaia.wire.gateway_messages.field_types import Arguments, Word

__all__ = [
    "MOST_COMMAND_BYTES",
    "OFFLINE",
    "ONLINE",
    "AskedCommand",
    "ValueQuality",
    "encode_answer",
    "encode_value",
    "read_command_payload",
]

ONLINE, OFFLINE = b"online", b"offline"
# Of a command (bytes).
MOST_COMMAND_BYTES = 64 * 1024
_EPOCH = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)
_MICRO = dt.timedelta(microseconds=1)
# Of a time of asking (s, UTC): the year 2255, far from what an i64 of microseconds holds.
_LAST_S = 9e9


class ValueQuality(StrEnum):
    """How far a value can be trusted: only a good one is of now."""

    GOOD = "good"
    # Older than its limit.
    STALE = "stale"
    # The device is not reached, or the site's gateway is away.
    LOST = "lost"


class _Value(msgspec.Struct, frozen=True):
    value: float | str | None
    unit: str
    time: str
    quality: str


class _Answer(msgspec.Struct, frozen=True):
    id: str
    phase: str
    message: str
    progress: float


class _Command(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    time: float | Annotated[str, Meta(max_length=100)]
    args: Arguments = {}
    id: Word = ""


class AskedCommand(msgspec.Struct, frozen=True):
    """A command as it was asked for.

    Attributes:
        time_us: when, by the asker's clock (UTC).
        args: by name.
        id: the asker's own name of it; may be empty.

    """

    time_us: int
    args: Arguments
    id: str


def encode_value(value: float | str, *, unit: str, time_us: int, quality: ValueQuality) -> bytes:
    """Write a value; a number that is none becomes ``null``."""
    shown = value if isinstance(value, str) or math.isfinite(value) else None
    return msgspec.json.encode(_Value(shown, unit, _iso_time(time_us), quality.value))


def encode_answer(number: str, phase: str, message: str, progress: float = 0.0) -> bytes:
    """Write what became of a command."""
    shown = progress if math.isfinite(progress) else 0.0
    return msgspec.json.encode(_Answer(number, phase, message, shown))


def read_command_payload(payload: bytes) -> AskedCommand:
    """Read a command.

    Raises:
        PeerError: it is none, or does not say when it was asked.

    """
    if len(payload) > MOST_COMMAND_BYTES:
        raise PeerError(f"a command of {len(payload)} bytes is over {MOST_COMMAND_BYTES}", 1009)
    try:
        read = msgspec.json.decode(payload, type=_Command)
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise PeerError(
            f"not a command: {str(error)[:200]}; write it like"
            ' {"time": 1767225600.5, "args": {"angle": 90}}'
        ) from error
    return AskedCommand(_read_time(read.time), read.args, read.id)


def _read_time(said: float | str) -> int:
    if isinstance(said, str):
        try:
            moment = dt.datetime.fromisoformat(said)
        except ValueError as error:
            raise PeerError(f"time {said[:50]!r} is neither a number nor ISO 8601") from error
        if moment.tzinfo is None:
            raise PeerError(f"time {said[:50]!r} names no zone; add Z for UTC")
        # Without `timestamp`, whose floats lose microseconds.
        return (moment - _EPOCH) // _MICRO
    if not 0 <= said <= _LAST_S:
        raise PeerError("time is not in seconds since 1970 (UTC)")
    return round(said * 1e6)


def _iso_time(time_us: int) -> str:
    try:
        moment = _EPOCH + dt.timedelta(microseconds=time_us)
    except OverflowError:
        # A clock that says something else is no reason to say nothing.
        return ""
    return moment.strftime("%Y-%m-%dT%H:%M:%S.%fZ")
