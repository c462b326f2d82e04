"""Where things stand, against astropy."""

from __future__ import annotations

import erfa
import numpy as np
import pytest
from astropy import units
from astropy.coordinates import AltAz, EarthLocation, SkyCoord, get_body
from astropy.time import Time
from astropy.utils import iers

from talaia.model.observing.targets import SolarSystemBody
from talaia.planner.sky import TelescopePlace, compute_sky, find_night

# 2027-01-18, 22:00 UTC.
EVENING = 1_800_309_600.0
PLACE = TelescopePlace(42.05, 0.73, 1570.0)
ARC_MINUTE = 1.0 / 60.0


@pytest.fixture(scope="module")
def frame():
    # Without the network; what is known of the Earth's rotation may be old.
    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):  # noqa: FBT003
        where = EarthLocation(lat=42.05 * units.deg, lon=0.73 * units.deg, height=1570 * units.m)
        yield AltAz(obstime=Time(EVENING, format="unix") + [0, 3, 6] * units.h, location=where)


def test_stars_stand_within_a_twentieth_of_a_minute_of_arc(frame):
    ra, dec = np.array([5.0, 83.8, 170.0, 250.0]), np.array([-20.0, 5.4, 60.0, 88.0])
    sky = compute_sky(PLACE, EVENING, 6 * 3600)
    marks = [0, 180, 360]
    directions = sky.star_directions(ra, dec)
    sine = (directions @ sky.zenith)[:, marks]
    theirs = SkyCoord(ra[:, None] * units.deg, dec[:, None] * units.deg).transform_to(frame)
    ours = np.degrees(np.arcsin(sine))
    assert np.abs(ours - theirs.alt.deg).max() < 0.05 * ARC_MINUTE
    turn = (sky.azimuths(directions)[:, marks] - theirs.az.deg + 180.0) % 360.0 - 180.0
    assert np.abs(turn * np.cos(np.radians(ours))).max() < 0.05 * ARC_MINUTE


@pytest.mark.parametrize(
    ("body", "most"), [(SolarSystemBody.MOON, 0.5), (SolarSystemBody.MARS, 1.0)]
)
def test_moon_and_planets_stand_within_a_minute_of_arc(frame, body, most):
    sky = compute_sky(PLACE, EVENING, 6 * 3600)
    track = sky.body_track(body)[:, [0, 180, 360]]
    ours = np.degrees(np.arcsin((track * sky.zenith[:, [0, 180, 360]]).sum(0)))
    theirs = get_body(body.value, frame.obstime, frame.location).transform_to(frame).alt.deg
    assert np.abs(ours - theirs).max() < most * ARC_MINUTE


def test_the_sun_stands_within_a_second_of_arc_wherever_the_sky_begins(frame):
    sky = compute_sky(PLACE, EVENING, 6 * 3600)
    theirs = get_body("sun", frame.obstime, frame.location).transform_to(frame).alt.deg
    assert np.abs(sky.sun_altitude[[0, 180, 360]] - theirs).max() < 0.05 * ARC_MINUTE
    later = compute_sky(PLACE, EVENING + 47 * 60, 4 * 3600)
    apart = np.linalg.norm(sky.sun[:, 47:288] - later.sun, axis=0)
    assert np.degrees(apart).max() * 3600.0 < 0.02


def test_the_earth_turns_at_every_mark_as_sofa_has_it():
    sky = compute_sky(PLACE, EVENING, 36 * 3600)
    times = Time(sky.unix, format="unix")
    theirs = erfa.gst06a(times.jd1, times.jd2, times.tt.jd1, times.tt.jd2)
    turned = sky.sidereal - np.radians(PLACE.longitude) - theirs
    assert np.degrees(np.abs(np.sin(turned))).max() * 3600.0 < 0.02


def test_a_night_lasts_from_sun_to_sun():
    start, length = find_night(PLACE, EVENING)
    sky = compute_sky(PLACE, start, length)
    assert sky.sun_altitude[[0, -1]] == pytest.approx([-6.0, -6.0], abs=0.2)
    assert (sky.sun_altitude <= -6.0).all()
    # By day it is the one that comes.
    assert find_night(PLACE, EVENING + 14 * 3600)[0] == pytest.approx(start + 86_400, abs=300)


def test_where_the_sun_does_not_set_there_is_no_night():
    # Midsummer at the North Cape.
    assert find_night(TelescopePlace(71.2, 25.8), 1_813_500_000.0)[1] == 0
