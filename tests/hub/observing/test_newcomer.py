"""Chances of a request that is being typed, held against plans that have it."""

from __future__ import annotations

import pytest

from talaia.hub.observing.newcomer import NewcomerChances, newcomer_chances
from talaia.model.observing.plan import Instrument
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    ImageType,
    Proposal,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.targets import IcrsTarget
from talaia.planner.sky import TelescopePlace, compute_sky, find_night
from talaia.planner.week import OPEN_SHARE, WeekForecast, forecast_nights

# 2027-01-18, 12:00 UTC.
NOON = 1_800_273_600.0
DAY = 86_400.0
PLACE = TelescopePlace(42.05, 0.73)
PROPOSAL = Proposal(id="p", share=1.0, hours_allocated=1000.0)
POLE = IcrsTarget(ra=100.0, dec=80.0)


def one(name: str, *, hours: float = 0.5, target: IcrsTarget | None = POLE, **more) -> Request:
    exposure = hours * 3600.0 / 6
    return Request(
        id=name,
        target=target,
        configurations=(Configuration(exposure=exposure, count=6, **more),),
        windows=(Window(start=NOON, end=NOON + 30 * DAY),),
    )


def group(*requests: Request, priority: float = 10.0, many: bool = True) -> RequestGroup:
    operator = GroupOperator.MANY if many else GroupOperator.SEQUENCE
    return RequestGroup(
        id="g-" + requests[0].id,
        proposal="p",
        priority=priority,
        operator=operator,
        requests=requests,
    )


def week(*groups: RequestGroup, nights: int = 2) -> WeekForecast:
    return forecast_nights(
        PLACE, NOON, instrument=Instrument(), proposals=[PROPOSAL], groups=groups, nights=nights
    )


def find_sky(time: float):
    start, length = find_night(PLACE, time)
    return start, length, compute_sky(PLACE, start, length)


def chances(known: WeekForecast, asked: RequestGroup, now: float = NOON) -> list[NewcomerChances]:
    return newcomer_chances(known, find_sky, asked, Instrument(), now=now)


@pytest.fixture(scope="module")
def full() -> WeekForecast:
    """Give two nights whose every minute somebody of priority 10 wants."""
    return week(group(*(one(f"r{at}", hours=1.0) for at in range(40))))


def test_in_empty_nights_all_that_can_be_seen_has_the_chance_that_the_roof_is_open() -> None:
    (found,) = chances(week(), group(one("new")))
    assert found.tonight == pytest.approx(OPEN_SHARE)
    assert found.week == pytest.approx(1.0 - (1.0 - OPEN_SHARE) ** 2)
    (south,) = chances(week(), group(one("new", target=IcrsTarget(ra=0.0, dec=-80.0))))
    assert (south.tonight, south.week) == (0.0, 0.0)


def test_in_full_nights_its_priority_decides(full) -> None:
    (high,) = chances(full, group(one("new"), priority=20.0))
    (low,) = chances(full, group(one("new"), priority=4.0))
    assert high.tonight == pytest.approx(OPEN_SHARE, abs=0.02)
    assert low.week == pytest.approx(0.0, abs=0.02)


def test_what_a_whole_plan_has_or_leaves_out_has_the_same_chance_without_it(full) -> None:
    for priority in (5.0, 20.0):
        asked = group(one("new"), priority=priority)
        plan = week(group(*(one(f"r{at}", hours=1.0) for at in range(40))), asked, nights=1)
        (found,) = chances(full, asked)
        planned = plan.nights[0].chances.get("new", 0.0)
        assert found.tonight == pytest.approx(planned, abs=0.1)


def test_requests_of_one_group_do_not_take_the_same_hours() -> None:
    # A night of January has some twelve hours in which the pole can be seen.
    asked = group(*(one(f"new{at}", hours=3.0) for at in range(6)))
    found = [one.tonight for one in chances(week(), asked)]
    assert found[:3] == pytest.approx([OPEN_SHARE] * 3)
    assert sum(found) < 5.0 * OPEN_SHARE


def test_a_sequence_waits_for_what_comes_first() -> None:
    asked = group(one("first"), one("then"), many=False)
    first, then = chances(week(), asked)
    assert first.tonight == pytest.approx(OPEN_SHARE)
    assert then.tonight == pytest.approx(OPEN_SHARE**2)


def test_nothing_is_promised_of_hours_that_are_over() -> None:
    known = week(nights=1)
    end = known.nights[0].plan.night_end
    (found,) = chances(known, group(one("new", hours=2.0)), now=end - 3600.0)
    assert found.tonight == 0.0


def test_frames_under_a_closed_roof_are_in_no_plan() -> None:
    (found,) = chances(week(), group(one("dark", target=None, type=ImageType.DARK)))
    assert (found.tonight, found.week) == (None, None)
