"""When a request can be observed, held against what an almanac says of a well-known place."""

from __future__ import annotations

import datetime as dt
from zoneinfo import ZoneInfo

import pytest

from talaia.hub.observing.outlook import NightSkies, request_outlook
from talaia.model.observing.plan import Instrument
from talaia.model.observing.requests import Configuration, Constraints, Request, Window
from talaia.model.observing.targets import FixedTarget, IcrsTarget
from talaia.planner.sky import TelescopePlace

# Montsec: 42° north.
SKIES = NightSkies(TelescopePlace(42.05, 0.73, 1570.0))
MADRID = ZoneInfo("Europe/Madrid")
ORION = IcrsTarget(ra=83.82, dec=-5.39)
# All that looks at a year begins here: to work a night out takes long, and SKIES keeps them.
JUNE = (2026, 6, 14, 12)
POLARIS = IcrsTarget(ra=37.95, dec=89.26)


def moment(*date: int) -> float:
    return dt.datetime(*date, tzinfo=dt.UTC).timestamp()


def outlook(target, begin, days=1.0, *, exposure=600.0, now=None, **limits):
    request = Request(
        id="new",
        target=target,
        configurations=(Configuration(exposure=exposure),),
        constraints=Constraints(**limits),
        windows=(Window(start=begin, end=begin + days * 86_400.0),),
    )
    return request_outlook(
        SKIES, request, Instrument(), now=begin if now is None else now, zone=MADRID
    )


def test_orion_culminates_in_december_at_midnight_as_high_as_its_declination_says() -> None:
    found = outlook(ORION, moment(2026, 12, 14, 12), min_altitude=30.0)
    # 90° - 42.05° - 5.4°; it stands in the south at 0:00 UTC in the middle of December.
    # The day of the time itself: it is after midnight in Madrid.
    assert "best on 15 December about 00:" in found.sentence
    assert max(found.curve.altitude) == pytest.approx(42.6, abs=0.2)
    assert abs(found.best - moment(2026, 12, 15, 0)) < 1800.0
    assert (found.nights, found.possible) == (1, 1)
    assert any(found.curve.allowed)
    assert not all(found.curve.allowed)


def test_in_june_it_is_never_up_and_the_sentence_says_when_it_is() -> None:
    found = outlook(ORION, moment(*JUNE), 3.0, min_altitude=30.0)
    assert (found.possible, found.best) == (0, None)
    assert found.sentence.startswith("never above 30° in its windows (")
    best = found.sentence.partition("; best on ")[2]
    assert best.split()[1] in {"November", "December", "January"}


@pytest.mark.parametrize(
    ("target", "limits", "said"),
    [
        (IcrsTarget(ra=0.0, dec=-80.0), {}, "never above 15° in its windows (-"),
        (POLARIS, {"max_sun_altitude": -75.0}, "the Sun is never below -75°"),
        (POLARIS, {"max_airmass": 1.2}, "its airmass is never below 1.2"),
        (POLARIS, {"exposure": 50_000.0}, "it does not fit: its windows leave"),
        (FixedTarget(altitude=10.0, azimuth=0.0), {}, "never above 15° in its windows (10°"),
    ],
    ids=str,
)
def test_what_can_never_be_says_why_and_that_a_year_does_not_help(target, limits, said) -> None:
    found = outlook(target, moment(*JUNE), **limits)
    assert found.sentence.startswith(said)
    assert found.sentence.endswith("; nor is it in the year to come")


def test_the_pole_star_can_be_seen_in_every_night_of_a_month() -> None:
    found = outlook(POLARIS, moment(2026, 12, 1), 20.0)
    assert found.nights == found.possible >= 19
    # What is over does not count.
    late = outlook(POLARIS, moment(2026, 12, 1), 20.0, now=moment(2026, 12, 19))
    assert late.nights <= 3


def test_windows_without_a_night_are_said_to_have_none() -> None:
    found = outlook(POLARIS, moment(*JUNE), 0.1)
    assert found.sentence.startswith("there is no night in its windows; best on ")
