"""The projection, judged by astropy's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from talaia.imaging.tangent_plane import TanWcs, angular_distance, sky_to_plane

REFERENCE = TanWcs(83.8, -5.4, 382.0, 254.5, (-2.1e-4, 1.3e-4, 1.3e-4, 2.1e-4))


def test_pixels_and_places_are_those_of_astropy() -> None:
    wcs = pytest.importorskip("astropy.wcs")
    from astropy.io import fits

    header = fits.Header(REFERENCE.header_cards())
    judge = wcs.WCS(header)
    x, y = np.array([0.0, 764.0, 300.5, -50.0]), np.array([0.0, 509.0, 17.25, 600.0])
    ours, theirs = REFERENCE.pixel_to_sky(x, y), judge.pixel_to_world_values(x, y)
    assert np.allclose(ours, theirs, atol=1e-10)
    assert np.allclose(REFERENCE.sky_to_pixel(*theirs), (x, y), atol=1e-6)
    assert TanWcs.from_header(header) == REFERENCE


@given(st.floats(0, 359.9), st.floats(-89, 89), st.floats(-400, 400), st.floats(-400, 400))
@settings(max_examples=60, deadline=None)
def test_there_and_back_is_the_same_pixel(ra: float, dec: float, x: float, y: float) -> None:
    wcs = REFERENCE._replace(ra=ra, dec=dec)
    assert np.allclose(wcs.sky_to_pixel(*wcs.pixel_to_sky(x, y)), (x, y), atol=1e-6)


def test_what_stands_behind_is_not_on_the_plane() -> None:
    xi, _ = sky_to_plane(np.array([180.0, 0.0]), np.array([0.0, 0.0]), 0.0, 0.0)
    assert np.isnan(xi[0])
    assert xi[1] == 0.0


def test_scale_rotation_and_mirror_are_read_from_the_matrix() -> None:
    assert REFERENCE.scale == pytest.approx(np.hypot(2.1e-4, 1.3e-4) * 3600)
    assert REFERENCE.rotation == pytest.approx(np.degrees(np.arctan2(1.3, 2.1)))
    assert not REFERENCE.mirrored
    assert REFERENCE._replace(cd=(2.1e-4, 0.0, 0.0, 2.1e-4)).mirrored
    assert angular_distance(359.9, 0.0, 0.1, 0.0) == pytest.approx(0.2)


@pytest.mark.parametrize("missing", ["CRVAL1", "CD2_2", "CTYPE1"])
def test_a_header_without_a_whole_solution_has_none(missing: str) -> None:
    header = {key: value for key, value, _ in REFERENCE.header_cards() if key != missing}
    assert TanWcs.from_header(header) is None
