"""Chances of requests over several nights."""

from __future__ import annotations

import pytest

from talaia.model.observing.plan import Instrument
from talaia.model.observing.requests import (
    Configuration,
    Proposal,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.targets import IcrsTarget
from talaia.planner.sky import TelescopePlace
from talaia.planner.week import forecast_nights

# 2027-01-18, 12:00 UTC.
NOON = 1_800_273_600.0
DAY = 86_400.0
PLACE = TelescopePlace(42.05, 0.73)
PROPOSAL = Proposal(id="p", share=1.0, hours_allocated=10.0)


def group(name: str, first: float, last: float) -> RequestGroup:
    """Half an hour at the pole, in a window of days after noon."""
    one = Request(
        id=name,
        target=IcrsTarget(ra=100.0, dec=80.0),
        configurations=(Configuration(exposure=300.0, count=6),),
        windows=(Window(start=NOON + first * DAY, end=NOON + last * DAY),),
    )
    return RequestGroup(id=f"g{name}", proposal="p", requests=(one,))


def test_what_tonight_misses_has_the_rest_of_its_chances_later() -> None:
    groups = [group("any", 0, 30), group("late", 2, 3), group("gone", -3, -2)]
    found = forecast_nights(
        PLACE, NOON, instrument=Instrument(), proposals=[PROPOSAL], groups=groups, nights=3
    ).nights
    assert [round((night.plan.night_start - NOON) / DAY) for night in found] == [0, 1, 2]
    assert all(night.plan.night_end > night.plan.night_start for night in found)
    assert [round(night.chances.get("any", 0.0), 3) for night in found] == [0.7, 0.21, 0.063]
    assert [night.chances.get("late", 0.0) for night in found] == [0.0, 0.0, 0.7]
    assert all("gone" not in night.chances for night in found)


def test_an_allocation_that_earlier_nights_use_up_is_not_promised_twice() -> None:
    short = Proposal(id="p", share=1.0, hours_allocated=0.6)
    groups = [group(name, 0, 30) for name in ("one", "two")]
    found = forecast_nights(
        PLACE, NOON, instrument=Instrument(), proposals=[short], groups=groups, nights=2,
        open_share=1.0,
    ).nights  # fmt: skip
    assert [len(night.chances) for night in found] == [1, 0]
    assert sum(sum(night.chances.values()) for night in found) == pytest.approx(1.0)
