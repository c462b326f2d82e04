"""Where a telescope is sent, against astropy."""

from __future__ import annotations

import sys

import pytest
from astropy import units
from astropy.coordinates import TETE, AltAz, EarthLocation, SkyCoord, get_body
from astropy.time import Time
from astropy.utils import iers

from talaia.gateway.night.target_place import arcseconds_between, knows_bodies, place_of_date
from talaia.model.interlocks.enclosure import Place
from talaia.model.observing.targets import (
    FixedTarget,
    IcrsTarget,
    SolarSystemBody,
    SolarSystemTarget,
)

# 2027-01-18, 22:00:20 UTC: between the marks at which bodies are worked out.
EVENING = 1_800_309_620.0
PLACE = Place(latitude=42.05, longitude=0.73, elevation=1570.0)


@pytest.fixture(autouse=True)
def _no_network():
    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):  # noqa: FBT003
        yield


def judged(target: SkyCoord, time: float) -> tuple[float, float]:
    where = EarthLocation(
        lat=PLACE.latitude * units.deg,
        lon=PLACE.longitude * units.deg,
        height=PLACE.elevation * units.m,
    )
    seen = target.transform_to(TETE(obstime=Time(time, format="unix"), location=where))
    return seen.ra.hour, seen.dec.deg


def body_of_astropy(body: SolarSystemBody, time: float) -> tuple[float, float]:
    where = EarthLocation(
        lat=PLACE.latitude * units.deg,
        lon=PLACE.longitude * units.deg,
        height=PLACE.elevation * units.m,
    )
    return judged(get_body(body.value, Time(time, format="unix"), where), time)


@pytest.mark.parametrize("body", SolarSystemBody)
@pytest.mark.parametrize("later", [0.0, 3 * 3600.0])
def test_a_telescope_is_sent_to_within_a_minute_of_arc_of_a_body(body, later):
    ours = place_of_date(SolarSystemTarget(body=body), EVENING + later, PLACE)
    assert ours is not None
    assert arcseconds_between(ours, body_of_astropy(body, EVENING + later)) < 60.0


def test_the_moon_is_followed_from_minute_to_minute():
    moon = SolarSystemTarget(body=SolarSystemBody.MOON)
    first = place_of_date(moon, EVENING, PLACE)
    later = place_of_date(moon, EVENING + 600.0, PLACE)
    theirs = [body_of_astropy(SolarSystemBody.MOON, EVENING + at) for at in (0.0, 600.0)]
    gone = arcseconds_between(first, later)
    assert gone > 100.0
    assert gone == pytest.approx(arcseconds_between(*theirs), abs=1.0)


def test_a_star_that_moves_is_met_where_it_has_gone_to():
    barnard = IcrsTarget(
        ra=269.452, dec=4.693, proper_motion_ra=-802.8, proper_motion_dec=10_362.5, epoch=2016.0
    )
    moved = SkyCoord(
        ra=269.452 * units.deg,
        dec=4.693 * units.deg,
        pm_ra_cosdec=-802.8 * units.mas / units.yr,
        pm_dec=10_362.5 * units.mas / units.yr,
        distance=1.83 * units.pc,
        obstime=Time(2016.0, format="jyear"),
    ).apply_space_motion(Time(EVENING, format="unix"))
    ours = place_of_date(barnard, EVENING, PLACE)
    # Without nutation and aberration: half a minute at the most, where its motion is 115″.
    there = judged(SkyCoord(moved.ra, moved.dec), EVENING)
    assert arcseconds_between(ours, there) < 35.0


def test_a_fixed_direction_stays_above_the_horizon_where_it_was_asked_for():
    fixed = FixedTarget(altitude=60.0, azimuth=130.0)
    for at in (EVENING, EVENING + 1800.0):
        ra, dec = place_of_date(fixed, at, PLACE)
        where = EarthLocation(
            lat=PLACE.latitude * units.deg,
            lon=PLACE.longitude * units.deg,
            height=PLACE.elevation * units.m,
        )
        time = Time(at, format="unix")
        seen = SkyCoord(
            ra * units.hourangle, dec * units.deg, frame=TETE(obstime=time, location=where)
        ).transform_to(AltAz(obstime=time, location=where))
        off = arcseconds_between((130.0 / 15.0, 60.0), (seen.az.hour, seen.alt.deg))
        assert off < 30.0


def test_where_bodies_cannot_be_worked_out_the_telescope_is_sent_to_none(monkeypatch):
    # As Python marks a package that cannot be imported.
    monkeypatch.setitem(sys.modules, "erfa", None)
    knows_bodies.cache_clear()
    assert place_of_date(SolarSystemTarget(body=SolarSystemBody.MARS), EVENING, PLACE) is None
    assert place_of_date(None, EVENING, PLACE) is None
    knows_bodies.cache_clear()
