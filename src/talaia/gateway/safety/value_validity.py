"""What makes a value unknown although it arrives: out of range, frozen, or with an old stamp. Pure.

A station's error codes (-999 km/h), a sensor whose driver repeats its last word for ever, and a
relay that passes on old messages all look fresh. Unknown is unsafe, so whatever is judged for
safety is asked here first.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, NamedTuple

from talaia.clock import SECOND
from talaia.model.connection import IndiSource, RosSource
from talaia.model.site import SignalType

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.ports import ChannelReading, ReadingSource
    from talaia.model.interlocks.enclosure import Sighting
    from talaia.model.site import Signal, Site

__all__ = ["ValueValidity", "range_problem", "span_of", "within_sighting", "word_of"]


class _Same(NamedTuple):
    """The bits of a value, and since when they are the same (ns, monotonic)."""

    bits: bytes
    since_ns: int


class ValueValidity:
    """Judges the newest readings of a site by what is described of their signals."""

    def __init__(self, readings: ReadingSource, wall_ns: Callable[[], int]) -> None:
        """Know nothing yet.

        Args:
            readings: the newest values.
            wall_ns: the gateway's clock (UTC), for stamps of robots whose clocks agree with it.

        """
        self._readings = readings  # The newest value of each guarded signal.
        # UTC in ns; compared with stamps only where the description says that clocks agree.
        self._wall_ns = wall_ns
        # By address, of signals that can freeze alone.
        self._same: dict[str, _Same] = {}

    def observe_site(self, site: Site, now_ns: int) -> None:
        """Note which values have changed since the last look; wants to be called often."""
        for address in site.safety_signals():
            signal = site.signal(address)
            # A signal that no longer freezes begins anew if it does so again later.
            if signal is None or signal.frozen_after <= 0:
                self._same.pop(address, None)
            elif (reading := self._readings.latest(address)) is not None:
                self._observe_value(address, reading, now_ns)

    def _observe_value(self, address: str, reading: ChannelReading, now_ns: int) -> _Same:
        # Bits, not numbers: NaN differs from itself, and 0.0 from -0.0; a true sensor wavers in the
        # last bit.
        numbers = reading.numbers or (reading.value,)
        bits = struct.pack(f"<{len(numbers)}d", *numbers)
        same = self._same.get(address)
        if same is None or same.bits != bits:
            same = self._same[address] = _Same(bits, now_ns)
        return same

    def value_problem(
        self,
        address: str,
        signal: Signal,
        reading: ChannelReading,
        *,
        max_age: float,
        now_ns: int,
    ) -> str:
        """Say why a reading is unknown, whether or not it is fresh; empty when it counts.

        Args:
            address: ``device/signal``.
            signal: its description.
            reading: its newest.
            max_age: what is older counts for nothing (s).
            now_ns: monotonic.

        """
        return (
            # The plainest first, for only one is told.
            range_problem(signal, reading.value)
            or self._stamp_problem(signal, reading, max_age, now_ns)
            or self._frozen_problem(address, signal, reading, now_ns)
        )

    def _stamp_problem(
        self, signal: Signal, reading: ChannelReading, max_age: float, now_ns: int
    ) -> str:
        source = signal.source
        # Only these carry a stamp of the robot's own.
        if not isinstance(source, RosSource | IndiSource) or not source.stamp:
            return ""
        limit_ns = round(max_age * SECOND)
        # Messages come, but say again and again the time of one measurement: a relay repeats it.
        if now_ns - reading.arrived_ns <= limit_ns < now_ns - reading.mono_ns:
            still = span_of((now_ns - reading.mono_ns) / SECOND)
            return f"{signal.name}: its own time stamp has stood still for {still}"
        # Without synchronised clocks the difference says nothing.
        if not source.synchronized:
            return ""
        lag_ns = self._wall_ns() - reading.stamp_ns
        # Ahead counts as well: a stamp from the future makes old values look fresh.
        if abs(lag_ns) <= limit_ns:
            return ""
        side = "behind" if lag_ns > 0 else "ahead of"
        away = span_of(abs(lag_ns) / SECOND)
        return f"{signal.name}: its own time stamp is {away} {side} the gateway's clock"

    def _frozen_problem(
        self, address: str, signal: Signal, reading: ChannelReading, now_ns: int
    ) -> str:
        if signal.frozen_after <= 0:
            return ""
        still_ns = now_ns - self._observe_value(address, reading, now_ns).since_ns
        if still_ns < round(signal.frozen_after * SECOND):
            return ""
        shown = f"{reading.value:g}{_with_unit(signal)}"
        return f"{signal.name}: exactly {shown} for {span_of(still_ns / SECOND)}, so it is frozen"


def range_problem(signal: Signal, value: float) -> str:
    """Say that a number is outside its signal's own minimum and maximum; empty when it is not."""
    low, high, unit = signal.minimum, signal.maximum, _with_unit(signal)
    if signal.type is not SignalType.NUMBER:
        return ""
    if (low is None or value >= low) and (high is None or value <= high):
        return ""
    if low is not None and high is not None:
        return f"{signal.name}: {value:g}{unit} is outside {low:g} … {high:g}{unit}"
    limit, side = (low, "below its minimum") if high is None else (high, "above its maximum")
    return f"{signal.name}: {value:g}{unit} is {side}, {limit:g}{unit}"


def within_sighting(sighting: Sighting, value: float) -> bool:
    """Tell whether a number is as a sighting wants it."""
    high = sighting.above is None or value > sighting.above
    return high and (sighting.below is None or value < sighting.below)


def word_of(signal: Signal, value: float) -> str:
    """Give a value as people say it: ``100 %``, ``closed``."""
    if signal.type is SignalType.STATE and value == int(value) and 0 <= value < len(signal.states):
        return signal.states[int(value)]
    return f"{value:g}{_with_unit(signal)}"


def span_of(seconds: float) -> str:
    """Give a time as people say it: ``12 s``, ``10 min``, ``3 h``."""
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.0f} h"


def _with_unit(signal: Signal) -> str:
    return f" {signal.unit}" if signal.unit else ""
