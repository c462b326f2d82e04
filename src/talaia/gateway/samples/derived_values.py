"""Signals that are worked out from others: a `SampleSink` that adds them to what it passes on.

What was heard goes on at once, as it came. What follows from it is worked out on the event loop, a
few times a second at the most, and goes the same way: to the spool, the hub and the history, like
any other sample. See decision 0077.

Long, because what is kept, when it is worked out and of what is one thing.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SECOND
from talaia.gateway.samples.rate_limit import Sampler, rule_of
from talaia.model.derivation.plan import plan_derivations
from talaia.model.site import SignalType, parts_of
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable, Collection, Mapping

    from talaia.clock import Clock
    from talaia.gateway.ports import SampleSink
    from talaia.model.alarms.expression import Expression, Value
    from talaia.model.site import Signal, Site

__all__ = ["PERIOD_S", "DerivedValues"]

# Not more often than this everything is worked out that has new inputs (s).
PERIOD_S = 0.05
# As many as fit the samples' column of channels.
_CHANNELS = 65_536


class _Input(NamedTuple):
    """A channel that an expression reads."""

    number: int
    device: str
    signal: Signal


class _Derived(NamedTuple):
    """A signal that is worked out."""

    address: str
    number: int
    signal: Signal
    expression: Expression
    # Numbers of all channels that it goes back to, through other derived signals.
    leaves: frozenset[int]
    sampler: Sampler | None


class _Newest(NamedTuple):
    """The newest sample of an input."""

    time_us: int
    mono_ns: int  # When it came.
    value: float | str


class _Found(NamedTuple):
    """What something amounts to now, and the time of the newest sample in it."""

    value: Value
    time_us: int


_UNKNOWN = _Found(None, 0)


class DerivedValues:
    """A `SampleSink`. Event loop only, but for `put_samples`."""

    def __init__(
        self,
        *,
        site: Site,
        numbers: Mapping[str, int],
        sink: SampleSink,
        clock: Clock,
        loop: asyncio.AbstractEventLoop,
    ) -> None:
        """Work out what ``site`` describes.

        Args:
            site: the description.
            numbers: of channels, by the signal's address; see `ChannelNumbering.numbers_of`.
            sink: takes what is heard, and what is worked out.
            clock: how old an input is goes by when it came.
            loop: where is worked.

        """
        self._sink, self._clock, self._loop = sink, clock, loop
        # Whether what a device said last counts for anything now.
        self._counts: Callable[[str], bool] = lambda _device: True
        self._inputs: dict[str, _Input] = {}  # By channel's address.
        self._derived: dict[str, _Derived] = {}  # By address, in the order of the working.
        # By channel's number: whether it is an input. Replaced whole; other threads read it.
        self._wanted = np.zeros(_CHANNELS, bool)
        self._lock = threading.Lock()  # Over the two below, which other threads write.
        self._newest: dict[int, _Newest] = {}  # By channel's number.
        self._fresh: set[int] = set()  # Inputs that came since the last working.
        self._due_ns = 0  # Not worked before this (monotonic).
        self._timer: asyncio.TimerHandle | None = None  # The next working.
        self.redescribe(site, numbers)

    def redescribe(self, site: Site, numbers: Mapping[str, int]) -> None:
        """Work out what another description says from here on."""
        before = self._derived
        inputs: dict[str, _Input] = {}
        derived: dict[str, _Derived] = {}
        # Each behind those that it needs, so that their leaves are known.
        for plan in plan_derivations(site):
            leaves: set[int] = set()
            for channel in plan.expression.signals:
                # Through another derived signal: what counts is what was heard.
                if channel in derived:
                    leaves |= derived[channel].leaves
                    continue
                inputs[channel] = _input_of(site, numbers, channel)
                leaves.add(inputs[channel].number)
            # One that is the same goes on with its sampler, so that nothing is said twice.
            known = before.get(plan.address)
            same = known is not None and known.signal == plan.signal
            sampler = known.sampler if known is not None and same else _make_sampler(plan.signal)
            number = numbers[plan.address]
            derived[plan.address] = _Derived(
                plan.address, number, plan.signal, plan.expression, frozenset(leaves), sampler
            )
        wanted = np.zeros(_CHANNELS, bool)
        wanted[[one.number for one in inputs.values()]] = True
        # Numbers stay with their signals, so what is known of an input stays known.
        with self._lock:
            self._newest = {
                number: newest for number, newest in self._newest.items() if wanted[number]
            }
        self._inputs, self._derived, self._wanted = inputs, derived, wanted

    def attach_reachability(self, counts: Callable[[str], bool]) -> None:
        """Ask this from here on whether what a device said last still counts."""
        self._counts = counts

    def forget_devices(self, devices: Collection[str]) -> None:
        """Take what these devices said as unknown, until they say it anew."""
        # By number: samples that are on their way come under it, too.
        gone = {one.number for one in self._inputs.values() if one.device in devices}
        with self._lock:
            for number in gone:
                self._newest.pop(number, None)

    def put_samples(self, columns: Columns) -> None:
        """Pass samples on, and note those that are inputs; any thread."""
        self._sink.put_samples(columns)
        # Most sites derive nothing.
        if not self._derived:
            return
        # One look at a table for each sample: most of a robot's are no inputs.
        places = np.flatnonzero(self._wanted[columns.channel])
        if not len(places):
            return
        mono_ns = self._clock.monotonic_ns()
        # Of several samples of a channel the last one stays.
        last = dict(zip(columns.channel[places].tolist(), places.tolist(), strict=True))
        with self._lock:
            # Once for all that come until the working.
            wake = not self._fresh
            self._fresh.update(last)
            for number, place in last.items():
                value = columns.texts.get(place, float(columns.value[place]))
                self._newest[number] = _Newest(int(columns.time_us[place]), mono_ns, value)
        if wake:
            self._loop.call_soon_threadsafe(self._arm_timer)

    def close(self) -> None:
        """Work no more."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _arm_timer(self, wait_s: float = 0.0) -> None:
        if self._timer is None:
            left_s = (self._due_ns - self._clock.monotonic_ns()) / SECOND
            self._timer = self._loop.call_later(max(wait_s, left_s, 0.0), self._work_out)

    def _work_out(self) -> None:
        """Work out all that has new inputs, and let out what was held back for its rate."""
        self._timer = None
        now_ns = self._clock.monotonic_ns()
        self._due_ns = now_ns + round(PERIOD_S * SECOND)
        # What comes from here on is for the next working.
        with self._lock:
            fresh, self._fresh = self._fresh, set()
        # Of this working: each is worked out once, however many others need it.
        known: dict[str, _Found] = {}
        gathered: list[tuple[int, int, float]] = []
        for derived in self._derived.values():
            # With no new input it would be said again, as if it were news.
            if not derived.leaves.isdisjoint(fresh):
                found = self._derive_value(derived, now_ns, known)
                if isinstance(found.value, bool | float):
                    self._gather_value(derived, found.time_us, float(found.value), gathered)
        holding = self._gather_held(gathered)
        if gathered:
            channel, time_us, value = zip(*gathered, strict=True)
            self._sink.put_samples(
                Columns(
                    np.array(channel, np.uint16),
                    np.array(time_us, np.int64),
                    np.array(value, np.float64),
                    {},
                )
            )
        if holding:
            self._arm_timer(PERIOD_S)

    @staticmethod
    def _gather_value(
        derived: _Derived, time_us: int, value: float, into: list[tuple[int, int, float]]
    ) -> None:
        if derived.sampler is None or derived.sampler.accept_sample(time_us, (value,)):
            into.append((derived.number, time_us, value))

    def _gather_held(self, into: list[tuple[int, int, float]]) -> bool:
        """Let out what its rate held back and whose turn has come; tell whether any still waits."""
        now_us, holding = self._clock.wall_ns() // 1000, False
        for derived in self._derived.values():
            sampler = derived.sampler
            if sampler is None or not sampler.holding:
                continue
            # Read before `due_values`, which begins the next interval.
            turn_us = sampler.turn_us
            values = sampler.due_values(now_us)
            if values is None:
                holding = True
            else:
                into.append((derived.number, turn_us, values[0]))
        return holding

    def _find_value(self, channel: str, now_ns: int, known: dict[str, _Found]) -> _Found:
        """Tell what a channel amounts to now, as expressions have it."""
        derived = self._derived.get(channel)
        if derived is None:
            return self._heard_value(self._inputs[channel], now_ns)
        found = self._derive_value(derived, now_ns, known)
        if isinstance(found.value, bool):
            # A state is the text of its name.
            return found._replace(value=derived.signal.states[found.value])
        return found

    def _derive_value(self, derived: _Derived, now_ns: int, known: dict[str, _Found]) -> _Found:
        """Work a signal out from what was heard, so that it is unknown as soon as that is."""
        if derived.address not in known:
            inputs = {
                name: self._find_value(name, now_ns, known) for name in derived.expression.signals
            }
            value = derived.expression.evaluate_value(
                {name: one.value for name, one in inputs.items()}
            )
            # `or` may be known though one side is not: only what is known has a time.
            times = [one.time_us for one in inputs.values() if one.value is not None]
            found = _UNKNOWN if value is None or not times else _Found(value, max(times))
            known[derived.address] = found
        return known[derived.address]

    def _heard_value(self, heard: _Input, now_ns: int) -> _Found:
        with self._lock:
            newest = self._newest.get(heard.number)
        # Asked each time: a device may be lost between its sample and now.
        if newest is None or not self._counts(heard.device):
            return _UNKNOWN
        if now_ns - newest.mono_ns > heard.signal.stale_after * SECOND:
            return _UNKNOWN
        value = _known_value(heard.signal, newest.value)
        return _UNKNOWN if value is None else _Found(value, newest.time_us)


def _known_value(signal: Signal, value: float | str) -> Value:
    """Give a heard value as expressions have it; none for one that says nothing."""
    if isinstance(value, str):
        return value
    if signal.type is SignalType.STATE:
        # NaN is equal to nothing, and so no whole number.
        whole = value == value // 1 and 0 <= value < len(signal.states)
        return signal.states[int(value)] if whole else None
    # As interlocks do: beyond its range a number is an error code. NaN is in no range.
    low = -np.inf if signal.minimum is None else signal.minimum
    high = np.inf if signal.maximum is None else signal.maximum
    return value if np.isfinite(value) and low <= value <= high else None


def _input_of(site: Site, numbers: Mapping[str, int], channel: str) -> _Input:
    address, _, part = channel.partition(".")
    signal = site.signal(address)
    assert signal is not None  # noqa: S101 - the expression was read with the site's channels
    number = numbers[address] + parts_of(signal).index(part)
    return _Input(number, address.partition("/")[0], signal)


def _make_sampler(signal: Signal) -> Sampler | None:
    rule = rule_of(signal)
    return None if rule is None else Sampler(rule)
