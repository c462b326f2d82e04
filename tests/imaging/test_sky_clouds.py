"""How much of the sky is covered, told by the stars that are missing on the simulated picture."""

from __future__ import annotations

import math

import numpy as np
import pytest

from talaia.imaging.sky_clouds import (
    CloudMeasure,
    SkyMoment,
    lens_pixels,
    measure_clouds,
    sky_stars,
)
from talaia.imaging.star_catalog import real_stars
from talaia.model.detection import SkyLens
from talaia.model.units.astronomy import (
    J2000,
    equatorial_to_horizontal,
    julian_day,
    precess_coordinates,
)
from talaia.sim.observatory.models.all_sky import LENS, SkyView, cloud_map, draw_sky
from talaia.sim.observatory.servers.devices import MONTSEC

pytestmark = pytest.mark.pure
# 2026-11-10 22:00 UTC, one day after new Moon, and the full Moon of the 24th.
DARK, MOONLIT, NOON = 1_794_348_000.0, 1_795_564_800.0, 1_794_312_000.0


def moment(unix: float) -> SkyMoment:
    return SkyMoment(MONTSEC.latitude, MONTSEC.longitude, unix)


def measured(unix: float, clouds: float, seed: int) -> CloudMeasure:
    picture = draw_sky(SkyView(MONTSEC, unix, clouds, seed)).astype(float)
    clear = draw_sky(SkyView(MONTSEC, unix - 600.0, 0.0, seed)).astype(float)
    # The gateway remembers what a clear sky was like.
    zero = measure_clouds(clear, LENS, moment(unix - 600.0)).zero
    return measure_clouds(picture, LENS, moment(unix), zero)


def test_stars_stand_where_the_almanac_has_them() -> None:
    stars = real_stars()
    chosen = np.flatnonzero(stars.mag < 1.5)
    here = sky_stars(moment(DARK), 1.5)
    jd = julian_day(DARK)
    for index in chosen:
        ra, dec = precess_coordinates(stars.ra[index] / 15.0, stars.dec[index], J2000, jd)
        at = equatorial_to_horizontal(ra, dec, MONTSEC, jd)
        if at.alt > 5.0:
            off = np.hypot(here.alt - at.alt, (here.az - at.az) * math.cos(math.radians(at.alt)))
            assert off.min() < 0.05


def test_the_zenith_is_in_the_middle_and_east_at_the_left_unless_it_is_mirrored() -> None:
    lens = SkyLens(x=100, y=90, radius=80)
    alt, az = np.array([90.0, 0.0, 0.0]), np.array([0.0, 0.0, 90.0])
    x, y = lens_pixels(alt, az, lens)
    assert x == pytest.approx([100, 100, 20])
    assert y == pytest.approx([90, 10, 90])
    x, _ = lens_pixels(alt, az, SkyLens(x=100, y=90, radius=80, mirrored=True))
    assert x[2] == pytest.approx(180)


@pytest.mark.parametrize("unix", [DARK, MOONLIT])
@pytest.mark.parametrize("clouds", [0.0, 25.0, 50.0, 75.0, 100.0])
def test_what_is_measured_is_what_is_covered(unix: float, clouds: float) -> None:
    covers = [measured(unix + seed * 3600.0, clouds, seed).cover for seed in range(4)]
    assert np.mean(covers) == pytest.approx(clouds, abs=8.0), covers
    assert np.abs(np.array(covers) - clouds).max() < 20.0, covers


def test_the_simulated_clouds_cover_as_much_as_the_weather_says() -> None:
    row, column = np.mgrid[0:400, 0:400]
    near = np.hypot(column - LENS.x, row - LENS.y) < LENS.radius * (90 - LENS.lowest) / 90
    for cover in (0.0, 30.0, 70.0, 100.0):
        share = cloud_map(SkyView(MONTSEC, DARK, cover, 3))[near].mean() * 100
        # Pixels near the zenith see more of the sky than those below.
        assert share == pytest.approx(cover, abs=12.0)


def test_by_day_nothing_is_told() -> None:
    told = measured(NOON, 0.0, 1)
    assert math.isnan(told.cover)
    assert told.problem


def test_a_black_picture_is_no_clear_sky() -> None:
    told = measure_clouds(np.zeros((400, 400)), LENS, moment(DARK))
    assert told.problem or told.cover > 99.0
