"""From answers and messages in JSON, or plain text, to samples; the same for MQTT and HTTP.

What is read is told by a key: a topic, or what a server was asked for. All signals of a key share
one reading of it. No sockets here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from talaia.gateway.adapters.topic_readers import SampleBuffer
from talaia.gateway.errors import FieldError
from talaia.gateway.ports import ChannelReading
from talaia.gateway.samples.field_paths import text_of
from talaia.gateway.samples.rate_limit import Sampler, rule_of
from talaia.model.connections.json_path import parse_json_path
from talaia.model.site import SignalType
from talaia.wire.nested_json import decode_nested

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.model.site import Signal
    from talaia.wire.columns import Columns

__all__ = ["JsonSignals", "JsonText", "parse_payload", "signal_value"]

# ``null`` is a value, so `None` cannot say that there is none.
_NOWHERE = object()


class JsonText(NamedTuple):
    """What came, as text, and what it is as JSON where it is any."""

    text: str
    # A number or a truth alone is JSON, too; a text without quotes is not.
    value: object
    is_json: bool


class _Row(NamedTuple):
    """One signal of a key."""

    address: str
    channel: int
    signal: Signal
    path: tuple[str | int, ...]
    sampler: Sampler | None  # None where every value is kept.
    guarded: bool  # Its newest reading is kept for interlocks.


def parse_payload(data: bytes) -> JsonText:
    """Read what came.

    Raises:
        FieldError: it is no text at all.

    """
    try:
        text = data.decode()
    except UnicodeDecodeError:
        raise FieldError("", "it is not UTF-8 text") from None
    try:
        return JsonText(text, decode_nested(data), is_json=True)
    # Beside what is plainly none: NaN, which JSON has not, and dozens of brackets.
    except ValueError:
        return JsonText(text, None, is_json=False)


def signal_value(
    signal: Signal, path: tuple[str | int, ...], payload: JsonText
) -> float | str | None:
    """Find a signal's value; none where the sender says that it knows none (``null``).

    Raises:
        FieldError: it is not there, or no value of this signal.

    """
    found = _follow_path(path, payload) if path else _whole_value(payload)
    if found is None:
        return None
    if signal.type is SignalType.TEXT and not path:
        # As it was sent: 1.50 stays 1.50, and an object its letters.
        return text_of(found if isinstance(found, str) else payload.text)
    if isinstance(found, dict | list):
        what = "an object" if isinstance(found, dict) else "a list"
        raise FieldError(_written(path), f"is {what}; say which field of it is meant")
    if signal.type is SignalType.TEXT:
        return text_of(_json_word(found))
    if signal.type is SignalType.STATE:
        return _state_number(signal, path, found)
    value = _number(path, found) * signal.scale
    if not math.isfinite(value):
        raise FieldError(_written(path), f"{str(found)[:60]!r} is too large a number")
    return value


def _follow_path(path: tuple[str | int, ...], payload: JsonText) -> object:
    if not payload.is_json:
        raise FieldError(_written(path), f"it is not JSON: {payload.text[:60]!r}")
    found = payload.value
    for depth, step in enumerate(path, 1):
        inner: object = _NOWHERE
        if isinstance(found, dict):
            inner = found.get(step, _NOWHERE)
        elif isinstance(found, list) and isinstance(step, int) and step < len(found):
            inner = found[step]
        if inner is _NOWHERE:
            raise FieldError(_written(path[:depth]), f"is not in {payload.text[:60]!r}")
        found = inner
    return found


def _whole_value(payload: JsonText) -> object:
    # Not JSON: a word, as most switches and sensors without fields send it.
    return payload.value if payload.is_json else payload.text.strip()


def _number(path: tuple[str | int, ...], found: object) -> float:
    try:
        # A truth is 0 or 1, and many devices write numbers in quotes.
        number = float(found) if isinstance(found, int | float | str) else math.nan
    except (ValueError, OverflowError):
        number = math.nan
    # `float` reads "nan" and "inf", and neither is a reading.
    if not math.isfinite(number):
        raise FieldError(_written(path), f"expected a number, found {str(found)[:60]!r}")
    return number


def _state_number(signal: Signal, path: tuple[str | int, ...], found: object) -> float:
    said = _json_word(found)
    if said in signal.states:
        return float(signal.states.index(said))
    # A truth of two states, and a number that counts them.
    counted = isinstance(found, bool) and len(signal.states) == 2
    whole = isinstance(found, int | float) and not isinstance(found, bool) and found == found // 1
    if counted or (whole and 0 <= _number(path, found) < len(signal.states)):
        return _number(path, found)
    raise FieldError(_written(path), f"{said[:60]!r} is none of its states")


def _json_word(found: object) -> str:
    # As JSON writes them: people copy words from what they see.
    return str(found).lower() if isinstance(found, bool) else str(found)


def _written(path: tuple[str | int, ...]) -> str:
    return "$" + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)


class JsonSignals:
    """The signals of a connection, by key. Used by one thread, but for `latest`.

    Attributes:
        keys: what is to be read: each key with the devices that it has signals of.
        latest: newest readings of guarded signals, by address; other threads read it.

    """

    def __init__(
        self,
        scope: ConnectionScope,
        place_of: Callable[[Signal], tuple[str, str]],
        complain: Callable[[str, str], None],
    ) -> None:
        """Compile every path.

        Args:
            scope: what the connection serves.
            place_of: gives the key and the path of a signal; an empty key for one of another
                protocol.
            complain: told once for each address that cannot be read, with the problem.

        """
        self._complain = complain
        self._rows: dict[str, list[_Row]] = {}  # By key, in the description's order.
        self._unreadable: set[str] = set()  # Addresses that were told.
        self._known: set[str] = set()  # Addresses whose last value was one.
        self._gathered = SampleBuffer()  # What was read and is not given out yet.
        self.latest: dict[str, ChannelReading] = {}
        for device_id, device in scope.devices.items():
            for signal_id, signal in device.signals.items():
                key, path = place_of(signal)
                if not key:
                    continue
                address, rule = f"{device_id}/{signal_id}", rule_of(signal)
                row = _Row(
                    address=address,
                    channel=scope.channel[address],
                    signal=signal,
                    path=parse_json_path(path),
                    sampler=None if rule is None else Sampler(rule),
                    guarded=address in scope.guarded,
                )
                self._rows.setdefault(key, []).append(row)
        self.keys = {
            key: frozenset(row.address.partition("/")[0] for row in rows)
            for key, rows in self._rows.items()
        }
        # Those that can hold a value back.
        self._thinned = [
            (row, row.sampler)
            for rows in self._rows.values()
            for row in rows
            if row.sampler is not None
        ]

    def read_payload(
        self, key: str, data: bytes, time_us: int, mono_ns: int, *, fresh: bool = True
    ) -> bool:
        """Read what came for a key; tell whether any signal had its value in it.

        Args:
            key: see `keys`.
            data: as it came.
            time_us: when, by the wall clock.
            mono_ns: when, by the monotonic clock.
            fresh: it is of now; else nobody knows of when it is, and interlocks get no reading.

        """
        try:
            payload = parse_payload(data)
        except FieldError as error:
            for row in self._rows.get(key, []):
                self._report_unreadable(row.address, key, error)
            return False
        return self.read_parsed(key, payload, time_us, mono_ns, fresh=fresh)

    def read_parsed(
        self, key: str, payload: JsonText, time_us: int, mono_ns: int, *, fresh: bool = True
    ) -> bool:
        """Read what came as values already; see `read_payload`."""
        read = False
        for row in self._rows.get(key, []):
            try:
                value = signal_value(row.signal, row.path, payload)
            except FieldError as error:
                # Only this signal: the others of the message are read all the same.
                self._report_unreadable(row.address, key, error)
                continue
            # Said to be unknown is an answer, and no value.
            read = True
            if value is not None:
                self._known.add(row.address)
            if isinstance(value, str):
                self._gathered.add_text(row.channel, time_us, value)
            elif value is not None:
                # Before the sampler: interlocks see every reading.
                if row.guarded and fresh:
                    self.latest[row.address] = ChannelReading(value, mono_ns)
                if row.sampler is None or row.sampler.accept_sample(time_us, (value,)):
                    self._gathered.add_number(row.channel, time_us, value)
        return read

    def lose_key(self, key: str, time_us: int) -> None:
        """Make a key's signals unknown, told once: nobody answers for it, or with an error."""
        for row in self._rows.get(key, []):
            self.latest.pop(row.address, None)
            if row.address not in self._known:
                continue
            self._known.discard(row.address)
            if row.sampler is not None:
                row.sampler.forget_values()
            if row.signal.type is SignalType.TEXT:
                self._gathered.add_text(row.channel, time_us, "")
            else:
                self._gathered.add_number(row.channel, time_us, math.nan)

    def holds_states(self, key: str) -> bool:
        """Tell whether a key's values are counted as states."""
        return any(row.signal.type is SignalType.STATE for row in self._rows.get(key, []))

    def gather_due(self, time_us: int) -> None:
        """Let held-back values out whose turn has come; ``time_us`` is now, by the wall clock."""
        for row, sampler in self._thinned:
            values = sampler.due_values(time_us)
            if values is not None:
                self._gathered.add_number(row.channel, time_us, values[0])

    def take_columns(self) -> Columns | None:
        """Give what was gathered, and begin anew; none if that is nothing."""
        return self._gathered.take_columns()

    def forget_readings(self, device: str = "") -> None:
        """Have no reading of a device, or of anything, until it is heard anew."""
        gone = [at for at in self.latest if not device or at.startswith(f"{device}/")]
        for address in gone:
            self.latest.pop(address, None)

    def _report_unreadable(self, address: str, key: str, error: FieldError) -> None:
        if address not in self._unreadable:
            self._unreadable.add(address)
            self._complain(address, f"{key}: {error}")
