"""A process that makes one forecast: ``python -m talaia.hub.observing.forecast_child``.

It is asked in MessagePack on its input, answers on its output and ends. With hundreds of requests a
week takes tens of seconds of computing, which no thread beside the hub's loop has to spare.
"""

from __future__ import annotations

import os
import sys

import msgspec

from talaia.model.observing.plan import Instrument, PauseRules
from talaia.model.observing.requests import Proposal, RequestGroup  # noqa: TC001 - as above
from talaia.planner.sky import TelescopePlace
from talaia.planner.week import WeekForecast, forecast_nights

__all__ = ["ForecastQuestion", "main", "make_forecast"]


class ForecastQuestion(msgspec.Struct, frozen=True, kw_only=True):
    """What is forecast: a place (°, °, m), from when on, and what waits there."""

    latitude: float
    longitude: float
    elevation: float
    now: float
    instrument: Instrument
    pauses: PauseRules = PauseRules()
    proposals: tuple[Proposal, ...]
    groups: tuple[RequestGroup, ...]


def make_forecast(asked: ForecastQuestion) -> WeekForecast:
    """Make the forecast of a week."""
    return forecast_nights(
        TelescopePlace(asked.latitude, asked.longitude, asked.elevation),
        asked.now,
        instrument=asked.instrument,
        pauses=asked.pauses,
        proposals=asked.proposals,
        groups=asked.groups,
    )


def main() -> None:
    """Answer what stands on the input."""
    # Whoever looks after robots on this machine goes first.
    os.nice(10)
    asked = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=ForecastQuestion)
    sys.stdout.buffer.write(msgspec.msgpack.encode(make_forecast(asked)))


if __name__ == "__main__":
    main()
