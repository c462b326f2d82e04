"""Whether an alarm's condition holds, and why, by what is known now.

Long, because every kind of alarm is judged here.
"""

from __future__ import annotations

import math
from enum import Enum, auto
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.alarms.alarm import Alarm, AlarmKind
from talaia.model.alarms.expression import Expression, parse_condition
from talaia.model.checks.alarm_checks import signals_of
from talaia.model.connection import DerivedSource
from talaia.model.maps.zone_watch import ZoneWatch
from talaia.model.site import SignalType
from talaia.model.units.conversion import shown_units

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.model.alarms.expression import Value
    from talaia.model.checks.alarm_checks import Addresses
    from talaia.model.site import Signal
    from talaia.model.units.conversion import Conversion

__all__ = [
    "AlarmCondition",
    "ConditionReading",
    "ConditionVerdict",
    "DetectedThing",
    "Truth",
    "format_number",
]

# Smaller numbers are written without an exponent.
_PLAIN = 1e15


class Truth(Enum):
    """What can be said of a condition."""

    HOLDS = auto()
    FALSE = auto()
    # Neither: never taken for well.
    UNKNOWN = auto()


class ConditionVerdict(NamedTuple):
    """What is so, and why in words that people read."""

    truth: Truth
    why: str


class ConditionReading(NamedTuple):
    """The newest sample of a channel: its value, its text, and how long ago it came (s)."""

    value: float
    text: str
    age_s: float


class DetectedThing(NamedTuple):
    """What a detector says goes on now: an anomaly (its score), or things that a camera sees."""

    score: float = 0.0
    many: int = 0
    confidence: float = 0.0
    why: str = ""
    # Of several signals together: when it began, and what each of them has of it.
    began_us: int = 0
    shares: tuple[tuple[str, float, bool], ...] = ()


class AlarmCondition:
    """One alarm's condition, made ready for one description.

    Attributes:
        channels: addresses that it looks at.
        happening: what it wants to know of a detector: ``(stream or channel, label)``; None: none.

    """

    def __init__(self, addresses: Addresses, alarm: Alarm) -> None:
        """Look the signals up; the alarm must be one in which `check` finds nothing."""
        self.alarm = alarm
        self.channels = signals_of(addresses, alarm)
        self.happening: tuple[str, str] | None = None
        self._part_name = ""
        # Of the devices of a part, by their short names.
        self._device_names: dict[str, str] = {}
        if alarm.kind is AlarmKind.ANOMALY:
            self.happening = (alarm.signal, "")
            if alarm.device:
                # Of all devices of a part the first names it.
                self.happening = (addresses.parts[alarm.device][0], "")
                self._device_names = {
                    one: addresses.device_names[one] for one in addresses.parts[alarm.device]
                }
                self._part_name = " and ".join(self._device_names.values())
        elif alarm.kind is AlarmKind.DETECTION:
            self.happening = (alarm.stream, alarm.label)
        self._group = addresses.groups.get(alarm.signal)
        # Their names, units and greatest ages, by address.
        self._signals = {channel: addresses.signals[channel] for channel in self.channels}
        # In a message, which many people read, the site's choice of units counts.
        self._shown = {
            channel: way
            for channel, signal in self._signals.items()
            if (way := _shown_by_site(signal, addresses.shown_units)) is not None
        }
        # Parsed once, judged at every sample; only of the kind EXPRESSION.
        self._expression: Expression | None = None
        if alarm.kind is AlarmKind.EXPRESSION:
            self._expression = parse_condition(alarm.expression, addresses.kinds)
        self._zone: ZoneWatch | None = None
        if alarm.kind is AlarmKind.ZONE and addresses.map is not None:
            self._zone = ZoneWatch(alarm, addresses.positions[alarm.signal], addresses.map)

    @property
    def aged(self) -> bool:
        """Whether time alone can change what is so."""
        # An anomaly is unknown once its channel's value is too old; a detection has no value.
        return self.happening is None or self.alarm.kind is AlarmKind.ANOMALY

    @property
    def shared(self) -> bool:
        """Whether it is about what becomes unusual together, and not about one signal."""
        return self.alarm.kind is AlarmKind.ANOMALY and bool(self.alarm.device)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Channels whose samples it is judged by: with several signals detectors tell it all."""
        return () if self.shared else self.channels

    def newest_thing(self, seen: tuple[DetectedThing, ...]) -> DetectedThing | None:
        """Give what began last of what is bad enough."""
        bad = [one for one in seen if one.score >= self.alarm.score]
        return max(bad, key=lambda one: one.began_us, default=None)

    def name_signal(self, address: str) -> str:
        """Give what people call a signal; where several devices are meant with the device's."""
        signal = self._signals.get(address)
        if signal is None:
            return address.lstrip("/")
        device = self._device_names.get(address.partition("/")[0], "")
        return f"{device} {signal.name}" if len(self._device_names) > 1 else signal.name

    def _subject_name(self) -> str:
        if self.shared:
            return self._part_name
        return self._signals[self.alarm.signal].name if self._group is None else self._group.name

    def judge_condition(
        self,
        readings: Mapping[str, ConditionReading],
        seen: tuple[DetectedThing, ...],
        *,
        held: bool,
        online: bool,
        enclosures: Mapping[str, str] | None = None,
    ) -> ConditionVerdict:
        """Tell whether it holds.

        Args:
            readings: the newest sample of each of `channels` that has one.
            seen: what goes on now of `happening`.
            held: it counts as true now, so that a limit lets go later (hysteresis).
            online: the site's gateway is connected.
            enclosures: what is told of each: why it should be closed and cannot be shown to be, or
                an empty text; those of which nothing was told are not in it.

        """
        match self.alarm.kind:
            case AlarmKind.STALE:
                return self._judge_staleness(readings)
            case AlarmKind.ANOMALY:
                return self._judge_anomaly(readings, seen, online=online)
            case AlarmKind.DETECTION:
                return self._judge_detection(seen, online=online)
            case AlarmKind.EXPRESSION:
                return self._judge_expression(readings)
            case AlarmKind.LIMIT:
                return self._judge_limit(readings, held=held)
            case AlarmKind.STATE:
                return self._judge_state(readings)
            case AlarmKind.ZONE:
                return self._judge_zone(readings)
            case AlarmKind.GATEWAY:
                # Never unknown: the missing link is what it watches.
                if online:
                    return ConditionVerdict(Truth.FALSE, "its gateway has a link")
                return ConditionVerdict(
                    Truth.HOLDS, "its gateway has no link: nothing is known of the site"
                )
            case AlarmKind.ENCLOSURE:
                return self._judge_enclosure(enclosures or {}, online=online)

    def current_value(self, address: str, readings: Mapping[str, ConditionReading]) -> Value:
        """Give what a channel says now: a number, or a state's or a text's words.

        None while it is not known, not a number, or too old.
        """
        reading = readings.get(address)
        if reading is None or reading.age_s > self.longest_s(address):
            return None
        signal = self._signals[address]
        if signal.type is SignalType.TEXT:
            return reading.text
        if not math.isfinite(reading.value):
            return None
        if signal.type is SignalType.STATE:
            # A number outside the list is shown as it is, not hidden.
            at = round(reading.value)
            return signal.states[at] if 0 <= at < len(signal.states) else f"{at}"
        return reading.value

    def longest_s(self, address: str) -> float:
        """Give how old a channel's value may be before it is unknown (s)."""
        own = self.alarm.max_age
        return self._signals[address].stale_after if own is None else own

    def _unknown_verdict(
        self, address: str, readings: Mapping[str, ConditionReading]
    ) -> ConditionVerdict:
        name, reading = self._signals[address].name, readings.get(address)
        if reading is None:
            return ConditionVerdict(Truth.UNKNOWN, f"{name} has never been heard of")
        if reading.age_s > self.longest_s(address):
            return ConditionVerdict(Truth.UNKNOWN, f"{name} is {_format_age(reading.age_s)} old")
        return ConditionVerdict(Truth.UNKNOWN, f"{name} is not a number")

    def _judge_limit(
        self, readings: Mapping[str, ConditionReading], *, held: bool
    ) -> ConditionVerdict:
        alarm, address = self.alarm, self.alarm.signal
        value = self.current_value(address, readings)
        if not isinstance(value, float):
            return self._unknown_verdict(address, readings)
        # Once on, it clears only when it is back by the hysteresis.
        slack = alarm.hysteresis if held else 0.0
        limits = [limit for limit in (alarm.above, alarm.below) if limit is not None]
        said = f"{self._signals[address].name} is {self._number_text(address, value, limits)}"
        if alarm.above is not None and value > alarm.above - slack:
            word = "above" if value > alarm.above else "not yet well below"
            limit = self._number_text(address, alarm.above)
            return ConditionVerdict(Truth.HOLDS, f"{said}, {word} {limit}")
        if alarm.below is not None and value < alarm.below + slack:
            word = "below" if value < alarm.below else "not yet well above"
            limit = self._number_text(address, alarm.below)
            return ConditionVerdict(Truth.HOLDS, f"{said}, {word} {limit}")
        return ConditionVerdict(Truth.FALSE, said)

    def _judge_state(self, readings: Mapping[str, ConditionReading]) -> ConditionVerdict:
        alarm, address = self.alarm, self.alarm.signal
        value = self.current_value(address, readings)
        if not isinstance(value, str):
            return self._unknown_verdict(address, readings)
        holds = value in alarm.is_one_of or bool(alarm.is_not and value not in alarm.is_not)
        said = f"{self._signals[address].name} is {value!r}"
        return ConditionVerdict(Truth.HOLDS if holds else Truth.FALSE, said)

    def _judge_staleness(self, readings: Mapping[str, ConditionReading]) -> ConditionVerdict:
        address = self.alarm.signal
        name, reading = self._signals[address].name, readings.get(address)
        # Never heard of is stale too.
        if reading is None:
            return ConditionVerdict(Truth.HOLDS, f"{name} has never been heard of")
        if reading.age_s > self.longest_s(address):
            return ConditionVerdict(Truth.HOLDS, f"{name} is {_format_age(reading.age_s)} old")
        return ConditionVerdict(Truth.FALSE, f"{name} is fresh")

    def _judge_anomaly(
        self,
        readings: Mapping[str, ConditionReading],
        seen: tuple[DetectedThing, ...],
        *,
        online: bool,
    ) -> ConditionVerdict:
        name = self._subject_name()
        if self.shared and (newest := self.newest_thing(seen)) is not None:
            return ConditionVerdict(Truth.HOLDS, newest.why)
        # One that goes on counts even while the channel is silent.
        for anomaly in seen:
            if anomaly.score >= self.alarm.score:
                return ConditionVerdict(
                    Truth.HOLDS, f"{name} is unusual: {anomaly.why}".rstrip(": ")
                )
        if self.shared:
            # Whether nothing is unusual is not known while nothing comes.
            if not online:
                return ConditionVerdict(Truth.UNKNOWN, "the site is away")
            return ConditionVerdict(Truth.FALSE, f"{name} is as usual")
        if all(self.current_value(channel, readings) is None for channel in self.channels):
            return self._unknown_verdict(self.channels[0], readings)
        return ConditionVerdict(Truth.FALSE, f"{name} is as usual")

    def _judge_detection(
        self, seen: tuple[DetectedThing, ...], *, online: bool
    ) -> ConditionVerdict:
        alarm = self.alarm
        for sighting in seen:
            if sighting.many >= alarm.count and sighting.confidence >= alarm.confidence:
                many = f"{sighting.many} × {alarm.label}" if sighting.many > 1 else alarm.label
                return ConditionVerdict(
                    Truth.HOLDS, f"{many} seen ({sighting.confidence:.0%} sure)"
                )
        # That nothing is seen while nobody looks proves nothing.
        if not online:
            return ConditionVerdict(Truth.UNKNOWN, "the site is away")
        return ConditionVerdict(Truth.FALSE, f"no {alarm.label} seen")

    def _judge_enclosure(self, enclosures: Mapping[str, str], *, online: bool) -> ConditionVerdict:
        if not online:
            return ConditionVerdict(Truth.UNKNOWN, "the site is away")
        of = [why for name, why in enclosures.items() if self.alarm.enclosure in {"", name}]
        if not of:
            return ConditionVerdict(Truth.UNKNOWN, "its gateway has not told of it yet")
        for why in of:
            if why:
                return ConditionVerdict(Truth.HOLDS, why)
        return ConditionVerdict(Truth.FALSE, "closed, or allowed to be open")

    def _judge_zone(self, readings: Mapping[str, ConditionReading]) -> ConditionVerdict:
        numbers = []
        for address in self.channels:
            value = self.current_value(address, readings)
            if not isinstance(value, float):
                return self._unknown_verdict(address, readings)
            numbers.append(value)
        holds, why = (None, "there is no map") if self._zone is None else self._zone.judge(numbers)
        truths = {True: Truth.HOLDS, False: Truth.FALSE, None: Truth.UNKNOWN}
        return ConditionVerdict(truths[holds], why)

    def _judge_expression(self, readings: Mapping[str, ConditionReading]) -> ConditionVerdict:
        values = {address: self.current_value(address, readings) for address in self.channels}
        found = self._expression.evaluate_expression(values) if self._expression else None
        # A channel without a value is the likelier reason, so it is named first.
        if found is None:
            missing = next((channel for channel in self.channels if values[channel] is None), None)
            if missing is not None:
                return self._unknown_verdict(missing, readings)
            return ConditionVerdict(Truth.UNKNOWN, "it has no outcome: a division by zero?")
        said = ", ".join(
            f"{self._signals[address].name} is {self._format_value(address, value)}"
            for address, value in values.items()
            if value is not None
        )
        return ConditionVerdict(Truth.HOLDS if found else Truth.FALSE, said[:400])

    def _format_value(self, address: str, value: Value) -> str:
        if not isinstance(value, float):
            return repr(value)
        return self._number_text(address, value, ())

    def _number_text(
        self, address: str, value: float, limits: Sequence[float] | None = None
    ) -> str:
        """Say a number with its unit, or a limit, which is said as it was written (``None``)."""
        unit, way = self._signals[address].unit, self._shown.get(address)
        if way is not None:
            unit, value = way.unit, way.convert(value)
            limits = None if limits is None else [way.convert(limit) for limit in limits]
        if limits is None:
            # As written; what was converted has digits that nobody wrote.
            number = f"{value:.15g}" if way is None else f"{value:.6g}"
        else:
            number = format_number(value, limits)
        return f"{number} {unit}" if unit else number


def _shown_by_site(signal: Signal, choice: Mapping[str, str]) -> Conversion | None:
    way = shown_units({signal.unit: choice.get(signal.unit, signal.unit)}).get(signal.unit)
    # What is worked out may be a difference, which has no zero: said as it is stored.
    derived = isinstance(signal.source, DerivedSource)
    return None if way is None or (derived and way.offset) else way


def format_number(value: float, limits: Sequence[float] = ()) -> str:
    """Say a number in four digits, or in as many as it takes to stand where it does to limits."""
    text = ""
    # 17 digits tell any two floats apart.
    for digits in range(4, 18):
        text = f"{value:.{digits}g}"
        said = float(text)
        # An exponent is harder to read than a few digits more.
        if abs(value) < _PLAIN and "e+" in text:
            continue
        if all((said > limit, said < limit) == (value > limit, value < limit) for limit in limits):
            break
    return text


def _format_age(age_s: float) -> str:
    return f"{age_s:.1f} s" if age_s < 60 else f"{age_s / 60:.0f} min"
