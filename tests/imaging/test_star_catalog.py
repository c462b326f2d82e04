"""The real stars and the drawn ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.imaging.star_catalog import REAL_UNTIL, drawn_stars, real_stars, stars_near
from talaia.imaging.tangent_plane import angular_distance


def test_the_brightest_stars_stand_where_every_almanac_has_them() -> None:
    # Sirius and Vega of SIMBAD (J2000), with their motions of 27 years.
    for ra, dec, east, north in (
        (101.28716, -16.71612, -546.0, -1223.1),
        (279.23473, 38.78369, 200.9, 286.2),
    ):
        star = stars_near(ra, dec, 0.05, 1.0, drawn=False)
        moved = dec + 27 * north / 3.6e6, ra + 27 * east / 3.6e6 / np.cos(np.radians(dec))
        assert len(star.ra) == 1
        assert (
            angular_distance(float(star.ra[0]), float(star.dec[0]), moved[1], moved[0]) < 0.3 / 3600
        )


def test_the_catalogue_is_whole_and_in_order() -> None:
    stars = real_stars()
    assert len(stars.ra) == 117_955
    assert (np.diff(stars.dec) >= 0).all()
    # As many naked-eye stars as are said to be in the sky.
    assert 4500 < int((stars.mag < 6.0).sum()) < 5500


@given(st.floats(0, 359.99), st.floats(-90, 90), st.floats(0.02, 0.4))
@settings(max_examples=25, deadline=None)
def test_a_star_is_found_from_wherever_it_is_looked_for(
    ra: float, dec: float, radius: float
) -> None:
    wide = stars_near(ra, dec, 0.5)
    far = [angular_distance(ra, dec, *place) for place in zip(wide.ra, wide.dec, strict=True)]
    near = stars_near(ra, dec, radius)
    assert len(near.ra) == sum(distance <= radius for distance in far)


def test_the_sky_has_as_many_stars_as_the_tables_say() -> None:
    stars = stars_near(60.0, 40.0, 3.0, 15.0)
    density = len(stars.ra) / (np.pi * 3.0**2)
    assert density == pytest.approx(1000, rel=0.1)


def test_drawn_stars_are_fainter_than_the_real_ones_and_left_out_on_request() -> None:
    assert drawn_stars(10.0, 20.0, 0.3).mag.min() >= REAL_UNTIL
    alone = stars_near(10.0, 20.0, 2.0, drawn=False)
    everything = stars_near(10.0, 20.0, 2.0)
    assert set(alone.ra) < set(everything.ra)
    # Real ones down to the catalogue's end, and ten times as many drawn ones.
    assert len(everything.ra) > 10 * len(alone.ra)
