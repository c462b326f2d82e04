"""The first slew of a night, and after each closing: from where the telescope is parked."""

from __future__ import annotations

import math

import numpy as np
import pytest
from astropy import units
from astropy.coordinates import AltAz, EarthLocation, SkyCoord
from astropy.time import Time
from astropy.utils import iers

from talaia.model.observing.plan import Instrument, MountAxes
from talaia.model.observing.requests import (
    Configuration,
    Proposal,
    Request,
    RequestGroup,
    Urgency,
    Window,
)
from talaia.model.observing.targets import FixedTarget, IcrsTarget, Target
from talaia.planner.between.overheads import overheads_from
from talaia.planner.from_requests import make_night
from talaia.planner.night_problem import NightProblem, ParkPlace
from talaia.planner.session import PlanningSession
from talaia.planner.sky import TelescopePlace

pytestmark = pytest.mark.pure

MONTSEC = TelescopePlace(42.05, 0.73, 1570.0)
# 2027-01-18, 22:00 UTC.
EVENING = 1_800_309_600.0
TARGETS = [(83.8, 5.4), (170.0, 60.0), (20.0, 45.0), (110.0, -10.0)]
# Unparked, settled and centred.
REST_S = 20 + 3 + 20


def group(name: str, target: Target, **more: object) -> RequestGroup:
    asked = Request(
        id=name,
        target=target,
        configurations=(Configuration(filter="V", exposure=60.0, count=3),),
        windows=(Window(start=EVENING - 86_400, end=EVENING + 86_400),),
    )
    return RequestGroup(id=f"g-{name}", proposal="school", requests=(asked,), **more)


def night(*groups: RequestGroup, **instrument: object) -> NightProblem:
    return make_night(
        MONTSEC,
        EVENING,
        instrument=Instrument(**instrument),
        proposals=[Proposal(id="school", share=1.0, hours_allocated=10.0)],
        groups=groups,
    )


def stars(**instrument: object) -> NightProblem:
    made = (group(f"r{ra:.0f}", IcrsTarget(ra=ra, dec=dec)) for ra, dec in TARGETS)
    return night(*made, **instrument)


def leads(problem: NightProblem) -> list[int]:
    rows = np.arange(len(problem.table))
    return overheads_from(problem, None, rows, problem.second(EVENING)).tolist()


def shorter(angle: float) -> float:
    return abs((angle + 180.0) % 360.0 - 180.0)


def angles_of_others() -> list[tuple[float, float]]:
    """Altitude and azimuth of each target, as astropy has it."""
    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):  # noqa: FBT003
        where = EarthLocation(lat=42.05 * units.deg, lon=0.73 * units.deg, height=1570 * units.m)
        frame = AltAz(obstime=Time(EVENING, format="unix"), location=where)
        ra, dec = np.array(TARGETS).T * units.deg
        there = SkyCoord(ra, dec).transform_to(frame)
    return list(zip(there.alt.deg, there.az.deg, strict=True))


def test_where_nobody_knows_the_park_all_targets_are_equally_far():
    assert leads(stars()) == [REST_S] * len(TARGETS)


def test_a_fork_slews_by_the_longer_of_its_angles_and_a_dome_turns_beside_it():
    problem = stars(slew_rate=5.0, mount=MountAxes.ALTAZIMUTH)
    problem.park = ParkPlace(10.0, 10.0)
    slow = stars(slew_rate=5.0, mount=MountAxes.ALTAZIMUTH, dome_rate=2.0)
    slow.park = problem.park
    for lead, under_dome, (altitude, azimuth) in zip(
        leads(problem), leads(slow), angles_of_others(), strict=True
    ):
        turn = shorter(azimuth - 10.0)
        # A mark of the sky is a minute, in which azimuths go on by some tenths of a degree.
        assert lead - REST_S == pytest.approx(max(turn, abs(altitude - 10.0)) / 5.0, abs=1.0)
        wanted = max(turn / 2.0, turn / 5.0, abs(altitude - 10.0) / 5.0)
        assert under_dome - REST_S == pytest.approx(wanted, abs=1.0)


def test_an_equatorial_mount_slews_by_hour_angle_and_declination():
    problem = stars(slew_rate=3.0)
    # On the meridian, on the equator: its right ascension is the sidereal time.
    problem.park = ParkPlace(90.0 - 42.05, 180.0)
    sidereal = math.degrees(problem.sky.sidereal[problem.second(EVENING) // 60])
    for lead, (ra, dec) in zip(leads(problem), TARGETS, strict=True):
        wanted = max(shorter(ra - sidereal), abs(dec)) / 3.0
        # Precession since 2000 is 0.35°.
        assert lead - REST_S == pytest.approx(wanted, abs=1.2)


def test_from_the_pole_only_declination_counts():
    problem = stars(slew_rate=3.0)
    problem.park = ParkPlace(42.05, 0.0)
    for lead, (_, dec) in zip(leads(problem), TARGETS, strict=True):
        assert lead - REST_S == pytest.approx((90.0 - dec) / 3.0, abs=1.2)


def test_what_stands_still_is_where_it_stands():
    problem = night(group("zenith", FixedTarget(altitude=90.0, azimuth=0.0)), mount="altazimuth")
    problem.park = ParkPlace(30.0, 0.0)
    assert leads(problem)[0] - REST_S >= 20


def session(*groups: RequestGroup) -> PlanningSession:
    return PlanningSession(night(*groups, mount=MountAxes.ALTAZIMUTH))


def test_of_two_that_are_worth_the_same_the_one_near_the_park_is_first():
    near, far = (
        group("near", FixedTarget(altitude=40.0, azimuth=300.0)),
        group("far", FixedTarget(altitude=40.0, azimuth=130.0)),
    )
    for altitude, azimuth, first in ((40.0, 300.0, "near"), (40.0, 130.0, "far")):
        made = session(near, far)
        made.park_telescope(ParkPlace(altitude, azimuth))
        decision = made.decide(EVENING)
        assert decision.request == first
        # It stands there already.
        assert decision.not_before == EVENING + REST_S


def test_a_block_behind_a_closing_is_planned_with_its_slew_from_the_park():
    made = session(group("far", FixedTarget(altitude=40.0, azimuth=130.0)))
    made.park_telescope(ParkPlace(40.0, 310.0))
    (block,) = made.plan(EVENING).blocks
    assert block.overhead == REST_S + 60
    # A reading that trembles is the same park, and one that is missing says nothing else.
    made.park_telescope(ParkPlace(40.2, 309.9))
    made.park_telescope()
    assert made.plan(EVENING).blocks[0].overhead == REST_S + 60
    made.park_telescope(ParkPlace(40.0, 130.0))
    assert made.plan(EVENING).blocks[0].overhead == REST_S


def test_a_rapid_request_from_the_park_is_promised_no_sooner_than_it_is_reached():
    urgent = group("now", FixedTarget(altitude=40.0, azimuth=130.0), urgency=Urgency.RAPID_RESPONSE)
    made = session(urgent)
    made.park_telescope(ParkPlace(40.0, 310.0))
    assert made.decide(EVENING).not_before == EVENING + REST_S + 60
