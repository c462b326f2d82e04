"""The sky's own small formulas against astropy's."""

from __future__ import annotations

import warnings

import pytest
from hypothesis import example, given, settings, strategies as st
from many_examples import examples

from talaia.model.units import astronomy
from talaia.sim.observatory.servers.devices import MONTSEC

# Some moments for which leap seconds are known (s since 1970).
MOMENTS = (1_500_000_000.0, 1_700_000_000.0, 1_795_260_000.0)


def astropy_place():
    astropy = pytest.importorskip("astropy")
    del astropy
    from astropy import units
    from astropy.coordinates import EarthLocation
    from astropy.utils import data, iers

    iers.conf.auto_download = False
    iers.conf.auto_max_age = None
    data.conf.allow_internet = False
    return EarthLocation(
        lat=MONTSEC.latitude * units.deg,
        lon=MONTSEC.longitude * units.deg,
        height=MONTSEC.elevation * units.m,
    )


@pytest.mark.parametrize("unix", MOMENTS)
def test_sidereal_time_agrees_with_astropys_within_two_seconds(unix: float) -> None:
    place = astropy_place()
    from astropy.time import Time

    theirs = Time(unix, format="unix", location=place).sidereal_time("mean").hour
    ours = astronomy.sidereal_hours(astronomy.julian_day(unix), MONTSEC.longitude)
    assert abs((ours - theirs + 12) % 24 - 12) * 3600 < 2


@pytest.mark.parametrize("unix", MOMENTS)
@pytest.mark.parametrize(("ra", "dec"), [(0.7373, 41.42), (5.6, -5.39), (18.6, 38.8)])
def test_horizon_coordinates_agree_with_astropys_within_a_minute_of_arc(
    unix: float, ra: float, dec: float
) -> None:
    place = astropy_place()
    from astropy import units
    from astropy.coordinates import TETE, AltAz, SkyCoord
    from astropy.time import Time

    when = Time(unix, format="unix")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        at = SkyCoord(
            ra * 15 * units.deg, dec * units.deg, frame=TETE(obstime=when, location=place)
        )
        theirs = at.transform_to(AltAz(obstime=when, location=place))
    ours = astronomy.equatorial_to_horizontal(ra, dec, MONTSEC, astronomy.julian_day(unix))
    other = astronomy.Horizontal(theirs.alt.deg, theirs.az.deg)
    assert astronomy.angular_separation(ours, other) < 1 / 60


@pytest.mark.parametrize("unix", MOMENTS)
def test_the_sun_stands_where_astropy_sees_it_within_a_minute_of_arc(unix: float) -> None:
    place = astropy_place()
    from astropy.coordinates import TETE, get_sun
    from astropy.time import Time

    when = Time(unix, format="unix")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = get_sun(when).transform_to(TETE(obstime=when, location=place))
    ra, dec = astronomy.sun_position(astronomy.julian_day(unix))
    away = astronomy.angular_separation(
        astronomy.Horizontal(dec, ra * 15), astronomy.Horizontal(theirs.dec.deg, theirs.ra.deg)
    )
    assert away < 1 / 60


def test_precession_carries_meeus_example_of_theta_persei() -> None:
    # Example 21.b, with the proper motion to 2028 November 13.19 already added.
    ra, dec = astronomy.precess_coordinates(41.054063 / 15, 49.227750, astronomy.J2000, 2462088.69)
    assert ra * 15 == pytest.approx(41.547214, abs=1e-5)
    assert dec == pytest.approx(49.348483, abs=1e-5)


@given(st.floats(-89, 89), st.floats(0, 359.9), st.sampled_from(MOMENTS), st.floats(-80, 80))
# Where the pole stands: there an arc sine would lose half of its digits.
@example(alt=59.2973010160313, az=0.0, unix=MOMENTS[0], latitude=59.2973010160313)
@settings(max_examples=examples(50, many=2000))
def test_to_the_sky_and_back_is_the_same_place(
    alt: float, az: float, unix: float, latitude: float
) -> None:
    place, jd = astronomy.Observer(latitude, 12.0), astronomy.julian_day(unix)
    back = astronomy.equatorial_to_horizontal(
        *astronomy.horizontal_to_equatorial(alt, az, place, jd), place, jd
    )
    assert astronomy.angular_separation(back, astronomy.Horizontal(alt, az)) < 1e-6
