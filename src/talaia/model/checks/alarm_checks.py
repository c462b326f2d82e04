"""Cross-checks of alarms, of a description and of those made in the page; part of `check`.

Long, because what fits every kind of alarm is checked here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.model.alarms.alarm import Alarm, AlarmKind
from talaia.model.alarms.cause_parts import cause_parts, watched_signals
from talaia.model.alarms.constant_parts import ZERO_REMEDY, zero_division_problem
from talaia.model.alarms.expression import ExpressionError, parse_condition
from talaia.model.alarms.signal_groups import groups_of
from talaia.model.checks.identifiers import (
    Finding,
    at_least,
    check_above,
    finding_of,
    id_fits,
    name_fits,
    number_text,
)
from talaia.model.derivation.plan import channel_kinds
from talaia.model.errors import UnknownWord
from talaia.model.maps.zone_checks import watched_zone_findings
from talaia.model.site import SignalType, parts_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Signal, Site

__all__ = ["Addresses", "alarm_findings", "alarms_findings", "signals_of"]

_DAY = 86_400.0
# Between two messages about one alarm (s).
_SHORTEST = 10.0
# Alarms of a site, and things at once on one picture.
_MOST = 1000
# In letters.
_MOST_ADVICE = 1000
# Which keys belong to which kind; those of none belong to all.
_OWN = {
    AlarmKind.LIMIT: {"signal", "above", "below", "hysteresis", "max_age"},
    AlarmKind.STATE: {"signal", "is_one_of", "is_not", "max_age"},
    AlarmKind.STALE: {"signal", "max_age"},
    AlarmKind.ANOMALY: {"signal", "device", "score", "max_age"},
    AlarmKind.DETECTION: {"stream", "label", "count", "confidence"},
    AlarmKind.EXPRESSION: {"expression", "max_age"},
    AlarmKind.ENCLOSURE: {"enclosure"},
    AlarmKind.ZONE: {"signal", "inside", "outside", "margin", "max_age"},
    AlarmKind.GATEWAY: set(),
}
# ``is`` cannot be the name of an attribute in Python.
_WRITTEN = {"is_one_of": "is"}


class Addresses:
    """What a description has, by address; made once for all of its alarms.

    Attributes:
        signals: the signal of each channel.
        streams: every camera.
        enclosures: their short names.
        groups: the groups of signals that are judged together, by their addresses.
        parts: by device, the devices among which anomalies that come together are one.
        watched: by device, the signals of its part at which a detector looks.
        device_names: what people call the devices.
        kinds: what each channel is in an expression: a state compares as the text of its name.
        positions: the positions, by the address of their signal.
        map: the zones that alarms go by, and where the local frame is.
        shown_units: in which unit the site wants values of another one shown.

    """

    def __init__(self, site: Site) -> None:
        """Look through ``site``."""
        self.signals = {
            channel.address: site.devices[channel.device].signals[channel.signal]
            for channel in site.channels()
        }
        self.groups = {group.address: group for group in groups_of(site)[0]}
        self.parts = cause_parts(site)
        self.watched = {
            device: tuple(one for one in watched_signals(site, part) if one in self.signals)
            for device, part in self.parts.items()
        }
        self.device_names = {key: device.name for key, device in site.devices.items()}
        self.kinds = channel_kinds(site)
        self.enclosures = list(site.enclosures)
        self.shown_units = site.shown_units
        self.map = site.map
        self.positions = {
            f"{device_id}/{signal_id}": signal
            for device_id, device in site.devices.items()
            for signal_id, signal in device.signals.items()
            if signal.type is SignalType.POSITION
        }
        self.streams = [
            f"{device_id}/{stream_id}"
            for device_id, device in site.devices.items()
            for stream_id in device.streams
        ]


def alarms_findings(site: Site) -> Iterator[Finding]:
    """List what does not fit in a description's alarms."""
    addresses = Addresses(site)
    if len(site.alarms) > _MOST:
        yield Finding("$.alarms", f"more than {_MOST} alarms")
    for alarm_id, alarm in site.alarms.items():
        where = f"$.alarms.{alarm_id}"
        yield from id_fits(where, alarm_id)
        yield from alarm_findings(addresses, where, alarm)


def alarm_findings(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    """List what does not fit in one alarm."""
    yield from name_fits(f"{where}.name", alarm.name)
    for key in ("delay", "clear_delay"):
        found = getattr(alarm, key)
        # Written so that NaN is found as well.
        if not 0 <= found <= _DAY:
            yield Finding(f"{where}.{key}", f"expected 0 to {_DAY:g} s, found {number_text(found)}")
    if alarm.unknown_after is not None and not 0 <= alarm.unknown_after <= _DAY:
        at = f"{where}.unknown_after"
        yield Finding(at, f"expected 0 to {_DAY:g} s, found {number_text(alarm.unknown_after)}")
    if alarm.max_age is not None:
        yield from check_above(f"{where}.max_age", alarm.max_age, 0)
    if len(alarm.advice) > _MOST_ADVICE:
        yield Finding(f"{where}.advice", f"longer than {_MOST_ADVICE} letters")
    yield from _told_again(where, alarm)
    yield from _check_foreign_keys(where, alarm)
    match alarm.kind:
        case AlarmKind.DETECTION:
            yield from _check_detection(addresses, where, alarm)
        case AlarmKind.EXPRESSION:
            yield from _check_expression(addresses, where, alarm)
        case AlarmKind.ENCLOSURE:
            if alarm.enclosure and alarm.enclosure not in addresses.enclosures:
                at = f"{where}.enclosure"
                yield finding_of(
                    UnknownWord(at, "enclosure", alarm.enclosure, addresses.enclosures)
                )
        case AlarmKind.ZONE:
            yield from _check_zone(addresses, where, alarm)
        case AlarmKind.GATEWAY:
            pass
        case AlarmKind.ANOMALY if alarm.device:
            yield from _check_part(addresses, where, alarm)
        case _:
            yield from _of_signal(addresses, where, alarm)


def signals_of(addresses: Addresses, alarm: Alarm) -> tuple[str, ...]:
    """Name the channels that an alarm looks at; none for what a camera sees."""
    if alarm.kind is AlarmKind.EXPRESSION:
        try:
            return parse_condition(alarm.expression, addresses.kinds).signals
        # `alarm_findings` says what is wrong with it.
        except ExpressionError:
            return ()
    if alarm.kind is AlarmKind.ZONE:
        signal = addresses.positions.get(alarm.signal)
        parts = () if signal is None else parts_of(signal)[:2]
        return tuple(f"{alarm.signal}.{part}" for part in parts)
    if alarm.kind is AlarmKind.ANOMALY and alarm.device:
        return addresses.watched.get(alarm.device, ())
    group = addresses.groups.get(alarm.signal)
    # Who may see an alarm about a group is who may see all of its signals.
    if group is not None:
        return group.signals
    return (alarm.signal,) if alarm.signal else ()


def _told_again(where: str, alarm: Alarm) -> Iterator[Finding]:
    for key in ("repeat", "remind"):
        every = getattr(alarm, key)
        if every is not None and not _SHORTEST <= every <= _DAY:
            problem = f"expected {_SHORTEST:g} to {_DAY:g} s, found " + number_text(every)
            yield Finding(
                f"{where}.{key}",
                f"expected {_SHORTEST:g} to {_DAY:g} s, found " + number_text(every),
            )
    before = 0.0
    for index, stage in enumerate(alarm.escalate):
        at = f"{where}.escalate[{index}]"
        yield from name_fits(f"{at}.who", stage.who)
        if not before <= stage.after <= _DAY:
            problem = f"expected {before:g} to {_DAY:g} s, found {number_text(stage.after)}"
            yield Finding(f"{at}.after", problem, "list people in the order in which they are told")
            return
        before = stage.after
    if alarm.escalate and alarm.repeat is None:
        yield Finding(
            f"{where}.repeat",
            "how often escalate tells again is not said",
            "write: repeat: 300",
        )


def _check_foreign_keys(where: str, alarm: Alarm) -> Iterator[Finding]:
    # With every default of its kind: what differs from it was written.
    plain = Alarm(name="", kind=alarm.kind)
    others = set().union(*_OWN.values()) - _OWN[alarm.kind]
    for key in sorted(others):
        if getattr(alarm, key) != getattr(plain, key):
            written = _WRITTEN.get(key, key)
            yield Finding(
                f"{where}.{written}",
                f"an alarm of kind {alarm.kind} has no {written}",
                "leave it out",
            )


def _of_signal(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    described = addresses.signals
    # What stands here for no kind fits them all: ``stale`` asks only how old a value is.
    fitting = _fitting_types(alarm.kind)
    known = [address for address, signal in described.items() if signal.type in fitting]
    if alarm.kind is AlarmKind.ANOMALY:
        known += addresses.groups
    other = described.get(alarm.signal)
    # It is there, so no likeness of names would help.
    if other is not None and alarm.signal not in known:
        problem = f"{alarm.signal!r} is of type {other.type}, of which there is no {alarm.kind}"
        kind = "state" if other.type in _fitting_types(AlarmKind.STATE) else "limit"
        yield Finding(f"{where}.signal", problem, f"write kind: {kind}, or another signal")
        return
    if alarm.signal not in known:
        yield finding_of(UnknownWord(f"{where}.signal", "signal", alarm.signal, known))
        return
    if alarm.kind is AlarmKind.LIMIT:
        yield from _check_limits(where, alarm)
    elif alarm.kind is AlarmKind.STATE:
        yield from _check_states(where, alarm, described[alarm.signal])
    elif alarm.kind is AlarmKind.ANOMALY:
        yield from at_least(f"{where}.score", alarm.score, 0)


def _check_part(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    if alarm.signal:
        yield Finding(
            f"{where}.signal",
            "an anomaly alarm is about a signal or about a device, not both",
            "leave one of them out",
        )
    if alarm.device not in addresses.parts:
        known = list(addresses.parts)
        yield finding_of(UnknownWord(f"{where}.device", "device", alarm.device, known))
        return
    watched = addresses.watched[alarm.device]
    if not watched:
        problem = f"no detector of anomalies looks at any signal of {alarm.device}"
        remedy = "write services: {anomaly_detection: true}, or anomalies: at a signal"
        yield Finding(f"{where}.device", problem, remedy)
    if len(watched) > _MOST:
        problem = f"detectors look at {len(watched)} of its signals, more than {_MOST}"
        yield Finding(f"{where}.device", problem, "name a signal or a group instead")
    yield from at_least(f"{where}.score", alarm.score, 0)


def _fitting_types(kind: AlarmKind) -> set[SignalType]:
    return {
        AlarmKind.LIMIT: {SignalType.NUMBER, SignalType.POSITION},
        AlarmKind.ANOMALY: {SignalType.NUMBER, SignalType.POSITION},
        AlarmKind.STATE: {SignalType.STATE, SignalType.TEXT},
    }.get(kind, set(SignalType))


def _check_limits(where: str, alarm: Alarm) -> Iterator[Finding]:
    if alarm.above is None and alarm.below is None:
        yield Finding(where, "there is no limit", "write: above: or below:, and a number")
    for key in ("above", "below"):
        value = getattr(alarm, key)
        if value is not None and not math.isfinite(value):
            yield Finding(f"{where}.{key}", f"expected a finite number, found {number_text(value)}")
    yield from at_least(f"{where}.hysteresis", alarm.hysteresis, 0)
    if alarm.above is not None and alarm.below is not None and alarm.below >= alarm.above:
        yield Finding(
            f"{where}.below",
            f"below {alarm.below:g} or above {alarm.above:g} is nearly always true",
            "swap the two",
        )


def _check_states(where: str, alarm: Alarm, signal: Signal) -> Iterator[Finding]:
    if not alarm.is_one_of and not alarm.is_not:
        yield Finding(where, "there is no state", "write: is: or is_not:, and a list of states")
    if signal.type is not SignalType.STATE:
        return
    for key, words in (("is", alarm.is_one_of), ("is_not", alarm.is_not)):
        for index, word in enumerate(words):
            if word not in signal.states:
                at = f"{where}.{key}[{index}]"
                yield finding_of(UnknownWord(at, "state", word, signal.states))


def _check_detection(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    streams = addresses.streams
    if alarm.stream not in streams:
        yield finding_of(UnknownWord(f"{where}.stream", "stream", alarm.stream, streams))
    yield from name_fits(f"{where}.label", alarm.label)
    if not 1 <= alarm.count <= _MOST:
        yield Finding(f"{where}.count", f"expected 1 to {_MOST}, found {alarm.count}")
    if not 0 <= alarm.confidence <= 1:
        yield Finding(
            f"{where}.confidence", f"expected 0 to 1, found {number_text(alarm.confidence)}"
        )


def _check_zone(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    signal = addresses.positions.get(alarm.signal)
    if signal is None:
        known = list(addresses.positions)
        yield finding_of(UnknownWord(f"{where}.signal", "position", alarm.signal, known))
        return
    yield from watched_zone_findings(addresses.map, where, alarm, signal)


def _check_expression(addresses: Addresses, where: str, alarm: Alarm) -> Iterator[Finding]:
    try:
        found = parse_condition(alarm.expression, addresses.kinds)
    except ExpressionError as error:
        yield Finding(f"{where}.expression", str(error), error.remedy)
        return
    if not found.signals:
        yield Finding(f"{where}.expression", "there is no signal in it", "write {device/signal}")
    if problem := zero_division_problem(found):
        yield Finding(f"{where}.expression", problem, ZERO_REMEDY)
