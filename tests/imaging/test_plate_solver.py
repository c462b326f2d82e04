"""Pictures of the simulated sky solved, and those that cannot be."""

from __future__ import annotations

import shutil
import subprocess
import warnings
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import pytest

from talaia.imaging.frame_quality import measure_quality
from talaia.imaging.plate_solver import PlateHint, PlateSolution, solve_plate
from talaia.imaging.star_catalog import stars_near
from talaia.imaging.star_detection import DetectedStars, detect_stars
from talaia.imaging.tangent_plane import angular_distance
from talaia.sim.observatory.models.fits import fits_file
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture, wcs_of

CHIP = Chip()
# A lens of 135 mm: six degrees by four.
LENS = Chip(width=1530, height=1020, focal_mm=135.0, zero=15.5, turned=30.0)


@lru_cache(maxsize=1)
def wide_picture() -> np.ndarray:
    return draw_picture(Shot(83.8, -5.4, 10.0, seeing=35.0), LENS)


def solve(shot: Shot, chip: Chip, *, east: float = 0.07, north: float = -0.05) -> PlateSolution:
    counts = draw_picture(shot, chip)
    ra = shot.ra + east / np.cos(np.radians(shot.dec))
    hint = PlateHint(float(ra), shot.dec + north, chip.scale * 1.01)
    return solve_plate(detect_stars(counts), counts.shape, hint, stars_near)


@pytest.mark.parametrize(
    ("ra", "dec", "turned"), [(83.8, -5.4, 0.0), (0.05, 41.0, 137.0), (250.0, 88.9, -60.0)]
)
def test_a_field_is_solved_from_a_place_minutes_of_arc_away(
    ra: float, dec: float, turned: float
) -> None:
    chip = CHIP._replace(turned=turned)
    solved = solve(Shot(ra, dec, 10.0, seeing=2.6), chip)
    assert solved.problem == ""
    assert solved.wcs is not None
    assert angular_distance(solved.wcs.ra, solved.wcs.dec, ra, dec) * 3600 < 1.0
    assert solved.wcs.scale == pytest.approx(chip.scale, rel=1e-3)
    assert (solved.wcs.rotation - turned + 180) % 360 - 180 == pytest.approx(0.0, abs=0.1)
    assert solved.rms < 0.6


def test_a_field_of_the_real_sky_is_solved_by_real_stars_alone() -> None:
    found, shape = detect_stars(wide_picture()), wide_picture().shape
    real = partial(stars_near, faintest=9.5, drawn=False)
    solved = solve_plate(found, shape, PlateHint(84.1, -5.6, LENS.scale, 1.0), real)
    assert solved.wcs is not None
    assert angular_distance(solved.wcs.ra, solved.wcs.dec, 83.8, -5.4) * 3600 < 3.0


def test_the_zero_point_is_that_of_the_chip() -> None:
    counts = draw_picture(Shot(150.0, 30.0, 10.0, seeing=2.6), CHIP)
    found = detect_stars(counts)
    solved = solve_plate(found, counts.shape, PlateHint(150.05, 30.0, CHIP.scale), stars_near)
    quality = measure_quality(found, solution=solved, seconds=10.0)
    # A count is 2.3 electrons; the flat field and the wings take some.
    assert quality.zero_point == pytest.approx(22.0 - 2.5 * np.log10(2.3), abs=0.15)
    assert quality.fwhm == pytest.approx(2.6, rel=0.12)
    assert {key for key, _, _ in quality.header_cards()} >= {"FWHM", "HFR", "MAGZP", "SKYLEVEL"}


def test_clouds_a_closed_dome_and_a_wrong_place_are_problems_in_words() -> None:
    closed = solve(Shot(150.0, 30.0, 10.0, light=False), CHIP)
    assert "at least 5 are needed" in closed.problem
    elsewhere = solve(Shot(150.0, 30.0, 10.0, seeing=2.6), CHIP, east=3.0)
    assert elsewhere.wcs is None
    assert elsewhere.problem


def test_stars_that_stand_anywhere_are_never_solved() -> None:
    for seed in range(2):
        dice = np.random.default_rng(seed)
        count = 90
        found = DetectedStars(
            x=dice.uniform(0, 765, count),
            y=dice.uniform(0, 510, count),
            flux=np.sort(dice.exponential(1e4, count))[::-1],
            hfr=np.full(count, 1.5),
            width=np.full(count, 3.0),
            elongation=np.ones(count),
            background=100.0,
            noise=7.0,
        )
        assert (
            solve_plate(found, (510, 765), PlateHint(150.0, 30.0, CHIP.scale), stars_near).wcs
            is None
        )


@pytest.mark.skipif(not shutil.which("solve-field"), reason="astrometry.net is not installed")
def test_astrometry_net_finds_our_sky_where_we_say_that_it_is(tmp_path: Path) -> None:
    # It knows nothing of us: blind, by its own stars of Tycho-2, from our picture alone.
    (tmp_path / "wide.fits").write_bytes(fits_file(wide_picture(), []))
    size = ["--scale-units", "arcsecperpix", "--scale-low", "13", "--scale-high", "14.5"]
    plain = ["--no-plots", "--no-remove-lines", "--uniformize", "0", "--fits-image"]
    subprocess.run(
        ["solve-field", *plain, *size, "--cpulimit", "60", "wide.fits"],
        cwd=tmp_path,
        check=True,
        timeout=120,
        capture_output=True,
    )
    fits, wcs = pytest.importorskip("astropy.io.fits"), pytest.importorskip("astropy.wcs")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        judge = wcs.WCS(fits.getheader(tmp_path / "wide.wcs"))
    ours = wcs_of(83.8, -5.4, LENS)
    for x, y in ((764.5, 509.5), (100.0, 100.0), (1400.0, 900.0)):
        theirs = [float(value) for value in judge.pixel_to_world_values(x, y)]
        place = [float(value) for value in ours.pixel_to_sky(x, y)]
        # Half a pixel of 13.75 seconds of arc.
        assert angular_distance(*theirs, *place) * 3600 < 7.0
