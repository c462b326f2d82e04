"""What the conditions of interlocks and the sensors of roofs say now. Pure.

Unknown is unsafe everywhere here: what is too old, out of range, frozen or not a number is never
taken for a value.

Long, because every kind of condition is judged here.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND
from talaia.gateway.freeze_watchdog import FreezeCredit
from talaia.gateway.safety.derived_conditions import judge_dew_point, judge_difference, judge_sun
from talaia.gateway.safety.interlock_state import InterlockVerdict
from talaia.gateway.safety.value_validity import ValueValidity, within_sighting
from talaia.model.connection import DetectionSource, source_as
from talaia.model.derived_signals import camera_meaning
from talaia.model.interlocks.interlock import Condition
from talaia.model.maps.zone_watch import ZoneWatch
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from talaia.gateway.ports import ChannelReading, ReadingSource
    from talaia.gateway.safety.link_losses import LinkLosses
    from talaia.model.interlocks.enclosure import Sighting
    from talaia.model.interlocks.interlock import Interlock
    from talaia.model.site import Signal, Site

__all__ = ["ConditionJudge", "join_verdicts", "judge_reading", "signal_meaning"]

# Characters: what the wire takes of a reason.
LONGEST_WHY = 500


def judge_reading(
    *,
    condition: Condition,
    signal: Signal,
    reading: ChannelReading | None,
    age_ns: int,
    problem: str = "",
) -> InterlockVerdict:
    """Say what is unsafe about a signal.

    Args:
        condition: what is unsafe.
        signal: its description.
        reading: its newest, if there ever was one.
        age_ns: of the reading; where there is none, how long it has been listened for.
        problem: what makes it unknown however fresh it is, see `ValueValidity`.

    """
    max_age = signal.max_age if condition.max_age is None else condition.max_age
    # Age by when it came, not by its stamp; what stamps add is `ValueValidity`'s.
    fresh = age_ns <= round(max_age * SECOND)
    if reading is None:
        # Not certain while the signal's first value may still be on its way: it locks, but runs no
        # sequence.
        return InterlockVerdict(f"{signal.name}: no value yet", certain=not fresh, unknown=True)
    # A frozen or impossible value is unknown even if it is newer than everything else.
    if problem:
        return InterlockVerdict(problem, unknown=True)
    if not fresh:
        return InterlockVerdict(f"{signal.name}: no value newer than {max_age:g} s", unknown=True)
    value = reading.value
    # NaN is how robots say that a sensor has nothing; it would be inside every limit.
    if not math.isfinite(value):
        return InterlockVerdict(f"{signal.name}: not a number", unknown=True)
    if signal.type is SignalType.STATE:
        return InterlockVerdict(_state_problem(condition, signal, value))
    unit = f" {signal.unit}" if signal.unit else ""
    if condition.above is not None and value > condition.above:
        return InterlockVerdict(f"{signal.name} is above {condition.above:g}{unit}")
    if condition.below is not None and value < condition.below:
        return InterlockVerdict(f"{signal.name} is below {condition.below:g}{unit}")
    return InterlockVerdict()


def join_verdicts(parts: Sequence[InterlockVerdict]) -> InterlockVerdict:
    """Say what is unsafe about conditions that are unsafe only all at once.

    One that is unknown counts as unsafe, as everywhere; it makes the whole uncertain for as long
    as it is itself.
    """
    # One part that is safe keeps the whole safe: the conditions are joined by "and".
    if not parts or not all(part.why for part in parts):
        return InterlockVerdict()
    why = " and ".join(part.why for part in parts)
    # Cut, for the wire refuses a longer reason; the first of them says most.
    return InterlockVerdict(why[:LONGEST_WHY], all(part.certain for part in parts))


def _state_problem(condition: Condition, signal: Signal, value: float) -> str:
    # Not a state's number: a newer driver may know states that the description does not.
    if value != int(value) or not 0 <= value < len(signal.states):
        return f"{signal.name}: an unknown state"
    word = signal.states[int(value)]
    if word in condition.is_one_of or (condition.is_not and word not in condition.is_not):
        return f"{signal.name} is {word}"
    return ""


class ConditionJudge:
    """Judges conditions and sightings by the newest readings, and by what is described of them."""

    def __init__(
        self,
        *,
        site: Site,
        readings: ReadingSource,
        losses: LinkLosses,
        now_ns: int,
        wall_ns: Callable[[], int],
    ) -> None:
        """Begin to listen now.

        Args:
            site: the description.
            readings: the newest values, see `Site.safety_signals`.
            losses: since when there is no hub.
            now_ns: monotonic.
            wall_ns: UTC, for where the Sun stands and for stamps of robots.

        """
        self._site = site  # Replaced by `redescribe`.
        self._readings = readings  # The newest value of each guarded signal, by address.
        self._losses = losses  # Since when the hub is away, for conditions on the link.
        self._wall_ns = wall_ns
        self._zones = zone_watches(site)
        # What makes a value unknown although it arrives.
        self._validity = ValueValidity(readings, wall_ns)
        # From when on a signal that has never said anything has been listened to (monotonic).
        self._began_ns = dict.fromkeys(site.safety_signals(), now_ns)
        # What this process slept through is no silence of a station.
        self._credit = FreezeCredit(now_ns)

    def redescribe(self, site: Site, now_ns: int) -> None:
        """Judge by another description; a signal that means something else is heard anew."""
        before, self._site = self._site, site
        self._zones = zone_watches(site)
        # Listened to for the first time now: its max_age counts from here.
        had = before.safety_signals()
        fresh = {
            command
            for command in site.safety_signals()
            if command not in had
            or _signal_origin(before, command) != _signal_origin(site, command)
        }
        self._began_ns = {
            command: now_ns if command in fresh else self._began_ns.get(command, now_ns)
            for command in site.safety_signals()
        }

    def observe_values(self, now_ns: int) -> None:
        """See which values have changed since the last look; wants to be called often."""
        self._validity.observe_site(self._site, now_ns)

    def mark_running(self, now_ns: int) -> None:
        """Take in that this process runs now, see `FreezeCredit`."""
        self._credit.mark_running(now_ns)

    def age_ns(self, since_ns: int, now_ns: int) -> int:
        """Say how old something is; a standstill of our own is no silence of a station."""
        return self._credit.age_ns(since_ns, now_ns)

    def unheard_problem(self, rule: Interlock, now_ns: int) -> str:
        """Say what has not been heard since a standstill of our own: nothing opens by its leave."""
        if not self._credit.is_settling(now_ns):
            return ""
        for condition in [part for outer in rule.when for part in (outer, *outer.all_of)]:
            # None is no reason here: a signal without a value locks by itself, see `judge_reading`.
            device, _, name = condition.signal.partition("/")
            reading = self._readings.latest(condition.signal) if condition.signal else None
            if reading is None:
                continue
            signal = self._site.devices[device].signals[name]
            max_age = signal.max_age if condition.max_age is None else condition.max_age
            if now_ns - reading.mono_ns > round(max_age * SECOND):
                return f"{signal.name}: nothing was heard since the gateway stood still"
        return ""

    def fresh_value(self, address: str, now_ns: int) -> float | None:
        """Give a signal's value, or none when it is unknown or too old."""
        device, _, signal = address.partition("/")
        described = self._site.devices[device].signals[signal]
        reading = self._readings.latest(address)
        if reading is None or self.age_ns(reading.mono_ns, now_ns) > round(
            described.max_age * SECOND
        ):
            return None
        if self._validity.value_problem(
            address, described, reading, max_age=described.max_age, now_ns=now_ns
        ):
            return None
        return reading.value if math.isfinite(reading.value) else None

    def sighting_holds(self, sighting: Sighting, now_ns: int) -> bool | None:
        """Tell whether a sensor says so; none when it says nothing."""
        # A sensor that is invalid says neither closed nor open.
        value = self.fresh_value(sighting.signal, now_ns)
        device, _, signal = sighting.signal.partition("/")
        described = self._site.devices[device].signals[signal]
        if described.type is SignalType.NUMBER:
            return None if value is None else within_sighting(sighting, value)
        states = described.states
        if value is None or value != int(value) or not 0 <= value < len(states):
            return None
        return states[int(value)] in sighting.is_one_of

    def judge_condition(self, condition: Condition, now_ns: int) -> InterlockVerdict:
        """Say what is unsafe by one condition; its debouncing is `DebouncedCondition`'s."""
        if condition.all_of:
            return join_verdicts([self.judge_condition(part, now_ns) for part in condition.all_of])
        if condition.link_lost is not None:
            # Counted with the credit: what this process slept through is no loss of the link.
            lost = self._losses.lost_ns
            if lost is None or self.age_ns(lost, now_ns) < round(condition.link_lost * SECOND):
                return InterlockVerdict()
            return InterlockVerdict(f"the hub has been out of reach for {condition.link_lost:g} s")
        if condition.sun is not None:
            place = self._site.place
            if place is None:
                return InterlockVerdict("it is not known where the site is", unknown=True)
            return judge_sun(condition, place, self._wall_ns())
        if condition.zone:
            return self._judge_position(condition, now_ns)
        other = condition.minus or condition.humidity
        if not other:
            return self._judge_signal(condition, condition.signal, now_ns)
        # Each by itself first: one that is unknown makes the difference unknown.
        alone = Condition(max_age=condition.max_age)
        for address in (condition.signal, other):
            verdict = self._judge_signal(alone, address, now_ns)
            # `_judge_two` reads both again and may trust them then.
            if verdict.why:
                return verdict
        return self._judge_two(condition, other)

    def _judge_position(self, condition: Condition, now_ns: int) -> InterlockVerdict:
        # Fresh, and neither frozen nor with an old stamp, before it is asked where it lies.
        alone = Condition(max_age=condition.max_age)
        verdict = self._judge_signal(alone, condition.signal, now_ns)
        if verdict.why:
            return verdict
        signal = self._site.signal(condition.signal)
        reading = self._readings.latest(condition.signal)
        if signal is None or reading is None:
            return InterlockVerdict("no value yet", unknown=True)
        watch = self._zones.get(condition)
        if watch is None:
            return InterlockVerdict(f"there is no zone {condition.zone}", unknown=True)
        unsafe, why = watch.judge(reading.numbers)
        # Only what is known to be on the right side is safe.
        return (
            InterlockVerdict() if unsafe is False else InterlockVerdict(why, unknown=unsafe is None)
        )

    def _judge_two(self, condition: Condition, other: str) -> InterlockVerdict:
        first, second = self._site.signal(condition.signal), self._site.signal(other)
        one, two = self._readings.latest(condition.signal), self._readings.latest(other)
        if first is None or second is None or one is None or two is None:
            return InterlockVerdict("no value yet", unknown=True)
        if condition.humidity:
            return judge_dew_point(
                condition=condition,
                name=first.name,
                temperature=one.value,
                humidity=two.value,
                unit=first.unit,
            )
        values = (one.value, two.value)
        return judge_difference(condition, (first.name, second.name), values, first.unit)

    def _judge_signal(self, condition: Condition, address: str, now_ns: int) -> InterlockVerdict:
        device, _, signal = address.partition("/")
        reading = self._readings.latest(address)
        # A signal that never spoke is as old as our listening.
        since = self._began_ns[address] if reading is None else reading.mono_ns
        described = self._site.devices[device].signals[signal]
        problem = ""
        if reading is not None:
            max_age = described.max_age if condition.max_age is None else condition.max_age
            problem = self._validity.value_problem(
                address, described, reading, max_age=max_age, now_ns=now_ns
            )
        return judge_reading(
            condition=condition,
            signal=described,
            reading=reading,
            age_ns=self.age_ns(since, now_ns),
            problem=problem,
        )


def zone_watches(site: Site) -> dict[Condition, ZoneWatch]:
    """Lay out the zones that interlocks go by, once for a description: by condition."""
    found = {}
    for condition in _each_condition(site):
        signal, shown = site.signal(condition.signal), site.map
        if signal is not None and shown is not None and condition.zone in shown.zones:
            found[condition] = ZoneWatch(condition, signal, shown)
    return found


def _each_condition(site: Site) -> Iterator[Condition]:
    for rule in site.interlocks.values():
        for outer in rule.when:
            yield from (outer, *outer.all_of)


def signal_meaning(site: Site, address: str) -> tuple[object, ...] | None:
    """Give what is described of a signal, and of the camera it counts on, but for its name."""
    device, _, name = address.partition("/")
    described = site.devices.get(device)
    signal = None if described is None else described.signals.get(name)
    if signal is None:
        return None
    # Names are for people: a signal that is only renamed goes on with its dwell times.
    return msgspec.structs.replace(signal, name="", was=""), camera_meaning(
        site, device, source_as(signal.source, DetectionSource).stream
    )


def _signal_origin(site: Site, address: str) -> tuple[object, ...]:
    """Give all that decides whether a newest reading of a signal is at hand."""
    device = address.partition("/")[0]
    connection = site.connection_of(device) if device in site.devices else ""
    return signal_meaning(site, address), connection
