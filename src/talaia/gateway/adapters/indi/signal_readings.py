"""What one INDI server's devices say, as samples and as readings for safety.

Three things hold for every signal. A change is given out at once, unless its rate limit says
later. A value that still holds is repeated before it looks old, for INDI's drivers say most things
only when they change. That nothing is known is said once, and only after something was.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.standard_properties import (
    read_number,
    read_state,
    read_text,
    stamp_of,
)
from talaia.gateway.ports import ChannelReading
from talaia.model.connection import IndiSource, source_as
from talaia.model.site import SignalType
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Iterable, Set as AbstractSet

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.indi.standard_properties import PropertyReading
    from talaia.gateway.adapters.indi.state import IndiDeviceTree
    from talaia.gateway.ports import SampleSink
    from talaia.model.site import Signal

__all__ = ["SignalReadings"]

_MAX_TEXT = 2000


class _Plan(NamedTuple):
    """One signal: what is read, and where it goes."""

    address: str
    channel: int
    # INDI's name of the device that is read; not always the one that the signal stands at.
    device: str
    signal: Signal
    source: IndiSource
    # Whether safety depends on it.
    tapped: bool


class _Published:
    """What was given out of one signal last."""

    __slots__ = ("at_ns", "value")

    def __init__(self) -> None:
        # None: nothing was ever known of it. NaN or the empty text: it is unknown now.
        self.value: float | str | None = None
        self.at_ns = 0


class SignalReadings:
    """All signals of one connection. On the event loop."""

    def __init__(
        self, scope: ConnectionScope, tree: IndiDeviceTree, clock: Clock, samples: SampleSink
    ) -> None:
        """Take what is read, from where, and where it goes."""
        self._tree = tree
        self._clock = clock
        self._samples = samples
        self._plans = _plans_of(scope)
        # By address: what was given out last.
        self._published = {plan.address: _Published() for plan in self._plans}
        # By address: newest readings of tapped signals, before any thinning.
        self._latest: dict[str, ChannelReading] = {}

    def latest_of(self, address: str) -> ChannelReading | None:
        """Give the newest reading of a tapped signal."""
        return self._latest.get(address)

    def publish_devices(self, devices: AbstractSet[str]) -> None:
        """Give out what is new at these INDI devices; the empty name stands for all of them."""
        self._publish_plans(plan for plan in self._plans if plan.device in devices or "" in devices)

    def publish_all(self) -> None:
        """Give out what is new, and repeat what still holds before it looks old."""
        self._publish_plans(self._plans)

    def forget_all(self) -> None:
        """Say of all that it is unknown; the tree has been cleared before."""
        self.publish_all()
        # Also what was too old and stayed: safety must count on nothing that a lost server said.
        self._latest.clear()

    def _publish_plans(self, plans: Iterable[_Plan]) -> None:
        now_ns, wall_us = self._clock.monotonic_ns(), self._clock.wall_ns() // 1000
        channels: list[int] = []
        values: list[float] = []
        texts: dict[int, str] = {}
        for plan in plans:
            # Read even where it is no news: a tapped reading must not wait for its rate.
            value = self._value_of(plan, now_ns)
            last = self._published[plan.address]
            if not _is_news(plan.signal, last, value, now_ns):
                continue
            last.value, last.at_ns = value, now_ns
            if isinstance(value, str):
                texts[len(channels)] = value
            channels.append(plan.channel)
            # A text's row has no number.
            values.append(math.nan if isinstance(value, str) else value)
        if channels:
            self._samples.put_samples(
                Columns(
                    np.array(channels, np.uint16),
                    np.full(len(channels), wall_us, np.int64),
                    np.array(values, np.float64),
                    texts,
                )
            )

    def _value_of(self, plan: _Plan, now_ns: int) -> float | str:
        """Give a signal's value now; NaN, or the empty text, where it is not known."""
        signal = plan.signal
        found = self._read_property(plan)
        unknown = found is None or now_ns - found.mono_ns > round(signal.stale_after * SECOND)
        if signal.type is SignalType.TEXT:
            return "" if found is None or unknown else str(found.value)[:_MAX_TEXT]
        if found is None or unknown:
            if found is None:
                # As if there never was one. One that is too old stays, and its age tells.
                self._latest.pop(plan.address, None)
            return math.nan
        value = float(found.value) * (signal.scale if signal.type is SignalType.NUMBER else 1.0)
        if plan.tapped:
            self._keep_reading(plan, value, found.mono_ns)
        return value

    def _read_property(self, plan: _Plan) -> PropertyReading | None:
        signal, source, device = plan.signal, plan.source, plan.device
        if signal.type is SignalType.TEXT:
            return read_text(self._tree, device, source.property, source.element)
        if signal.type is SignalType.STATE:
            return read_state(
                book=self._tree,
                device=device,
                name=source.property,
                element=source.element,
                states=signal.states,
            )
        return read_number(self._tree, device, source.property, source.element)

    def _keep_reading(self, plan: _Plan, value: float, mono_ns: int) -> None:
        """Keep a reading that safety depends on; with a stamp, from when that advanced."""
        source = plan.source
        if not source.stamp:
            self._latest[plan.address] = ChannelReading(value, mono_ns)
            return
        stamp = stamp_of(self._tree, plan.device, source.property)
        if stamp is None:
            return
        # A driver may go on sending an old measurement, and then arriving proves nothing. Where its
        # clock is the gateway's, the stamp tells the age; else only that it moved on counts.
        advanced_ns = stamp.arrived_ns if source.synchronized else stamp.advanced_ns
        if advanced_ns is None:
            self._latest.pop(plan.address, None)
        else:
            true_ns = min(mono_ns, advanced_ns)
            self._latest[plan.address] = ChannelReading(value, true_ns, stamp.stamp_ns, mono_ns)


def _is_news(signal: Signal, last: _Published, value: float | str, now_ns: int) -> bool:
    """Tell whether a value is to be given out, after what was given out last."""
    if last.value is None:
        # Nothing was ever known, and nothing is (NaN is unlike itself): no news.
        return value not in ("",) and value == value
    since = now_ns - last.at_ns
    if isinstance(value, str) or isinstance(last.value, str):
        changed = value != last.value
    elif math.isnan(value) or math.isnan(last.value):
        changed = math.isnan(value) != math.isnan(last.value)
        if not changed:
            return False  # unknown is said once
    else:
        changed = abs(value - last.value) > signal.deadband or (
            signal.deadband == 0 and value != last.value
        )
        rate = signal.max_rate
        if changed and rate > 0 and since < SECOND / rate:
            return False  # the next tick takes it up
    if value == "" and not changed:
        return False
    # Half of what it may grow old: a repetition that is lost has another behind it in time.
    return changed or since >= signal.stale_after * SECOND / 2


def _plans_of(scope: ConnectionScope) -> list[_Plan]:
    return [
        _Plan(
            f"{name}/{signal_name}",
            scope.channel[f"{name}/{signal_name}"],
            source_as(signal.source, IndiSource).device or device.indi,
            signal,
            source_as(signal.source, IndiSource),
            f"{name}/{signal_name}" in scope.guarded,
        )
        for name, device in scope.devices.items()
        for signal_name, signal in device.signals.items()
    ]
