"""What the simulated observatory measures, as samples for people who look on."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.model.site import SignalType
from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.cli.demo.in_process_observatory import InProcessObservatory
    from talaia.gateway.ports import SampleSink
    from talaia.model.site import Site

__all__ = ["SampleFeed"]

# Between two looks at what changes all the time, and at all of it (s, real): a page shows no more,
# and what is not said again grows old there.
CHANGED_S, ALL_S = 0.25, 0.9


class _Row(NamedTuple):
    address: str
    number: int
    type: SignalType
    scale: float


class SampleFeed:
    """Gives a sink what is new. States are told at once, numbers a few times a second.

    In a second of those who look on minutes pass for the observatory; each sample has its time.
    """

    def __init__(self, site: Site, numbers: Mapping[str, int], sink: SampleSink) -> None:
        """Give ``sink`` the signals of ``site``, by the numbers of their channels."""
        self._sink = sink
        self._rows = [
            _Row(f"{device}/{name}", numbers[f"{device}/{name}"], signal.type, signal.scale)
            for device, described in site.devices.items()
            for name, signal in described.signals.items()
            if hasattr(signal.source, "topic")
        ]
        self._said: dict[str, float | str] = {}
        self._changed_at = self._all_at = -math.inf

    def give_values(self, robot: InProcessObservatory, time_us: int) -> None:
        """Give what there is to say at this time (µs, UTC)."""
        now = time.monotonic()
        some, whole = now - self._changed_at >= CHANGED_S, now - self._all_at >= ALL_S
        due: list[tuple[int, float | str]] = []
        for row in self._rows:
            value = self._value_of(robot, row)
            if value is None:
                continue
            changed = value != self._said.get(row.address)
            if whole or (changed and (some or row.type is not SignalType.NUMBER)):
                self._said[row.address] = value
                due.append((row.number, value))
        if some:
            self._changed_at = now
        if whole:
            self._all_at = now
        if due:
            self._sink.put_samples(_columns_of(due, time_us))

    def _value_of(self, robot: InProcessObservatory, row: _Row) -> float | str | None:
        if row.type is SignalType.TEXT:
            return robot.text_of(row.address)
        reading = robot.latest(row.address)
        return None if reading is None else reading.value * row.scale


def _columns_of(due: list[tuple[int, float | str]], time_us: int) -> Columns:
    values = [math.nan if isinstance(value, str) else value for _, value in due]
    return Columns(
        np.array([number for number, _ in due], np.uint16),
        np.full(len(due), time_us, np.int64),
        np.array(values, np.float64),
        {at: value for at, (_, value) in enumerate(due) if isinstance(value, str)},
    )
