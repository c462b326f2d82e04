"""Stars found on pictures whose stars are known."""

from __future__ import annotations

import numpy as np
import pytest

from talaia.imaging.errors import UnreadableFrame
from talaia.imaging.fits_pixels import read_frame
from talaia.imaging.frame_quality import measure_quality
from talaia.imaging.star_catalog import stars_near
from talaia.imaging.star_detection import detect_stars
from talaia.sim.observatory.models.fits import fits_file
from talaia.sim.observatory.models.sky_picture import Chip, Shot, draw_picture, wcs_of

CHIP = Chip()
SHOT = Shot(150.0, 30.0, 10.0, seeing=2.6)


def test_the_stars_of_the_catalogue_are_found_where_they_stand() -> None:
    found = detect_stars(draw_picture(SHOT, CHIP))
    there = stars_near(150.0, 30.0, 0.13, 14.5)
    x, y = wcs_of(150.0, 30.0, CHIP).sky_to_pixel(there.ra, there.dec)
    inside = (x > 15) & (x < 750) & (y > 15) & (y < 495)
    off = [
        np.hypot(found.x - column, found.y - row).min()
        for column, row in zip(x[inside], y[inside], strict=True)
    ]
    assert len(off) > 10
    assert sorted(off)[-2] < 0.3


@pytest.mark.parametrize("seeing", [2.0, 3.0, 5.0])
def test_the_width_is_that_of_the_seeing(seeing: float) -> None:
    found = detect_stars(draw_picture(SHOT._replace(seeing=seeing), CHIP))
    assert measure_quality(found, scale=CHIP.scale).fwhm == pytest.approx(seeing, rel=0.12)


def test_the_radius_of_half_the_light_is_that_of_the_profile() -> None:
    # A Gaussian of 3 pixels: half of its light is within 1.1774 σ.
    y, x = np.mgrid[0:200, 0:200]
    star = 30_000.0 * np.exp(-((x - 100.3) ** 2 + (y - 99.6) ** 2) / 18.0)
    noise = np.random.default_rng(1).normal(100.0, 2.0, star.shape)
    found = detect_stars(star + noise)
    assert found.total == 1
    assert found.median_hfr == pytest.approx(1.1774 * 3.0, rel=0.03)
    assert found.fwhm == pytest.approx(2.3548 * 3.0, rel=0.05)
    assert float(found.flux[0]) == pytest.approx(30_000.0 * 2 * np.pi * 9.0, rel=0.06)
    assert (found.background, found.noise) == (
        pytest.approx(100, abs=0.5),
        pytest.approx(2, abs=0.3),
    )


def test_dark_frames_hot_pixels_and_dead_ones_are_no_stars() -> None:
    dark = draw_picture(SHOT._replace(light=False, seconds=60.0, celsius=5.0), CHIP).astype(float)
    dark[100, 100], dark[200:210, 200] = np.nan, np.inf
    found = detect_stars(dark)
    # Of two hundred hot pixels; some stand side by side.
    assert found.total <= 8
    assert np.isnan(detect_stars(np.full((64, 64), 7.0)).median_hfr)


def test_drifting_stars_are_long() -> None:
    still = measure_quality(detect_stars(draw_picture(SHOT, CHIP)))
    moved = measure_quality(detect_stars(draw_picture(SHOT._replace(drift=(9.0, 3.0)), CHIP)))
    assert still.elongation < 1.25
    assert moved.elongation > 1.8


def test_a_fits_file_is_read_as_astropy_reads_it() -> None:
    fits = pytest.importorskip("astropy.io.fits")
    import io

    counts = draw_picture(SHOT, CHIP)
    data = fits_file(
        counts, [("OBJECT", "it's", "target"), ("EXPTIME", 10.0, "[s]"), ("DOME", True, "")]
    )
    frame, judge = read_frame(data), fits.open(io.BytesIO(data))[0]
    assert (frame.pixels == judge.data).all()
    assert (frame.header["OBJECT"], frame.number("NONE", "EXPTIME")) == ("it's", 10.0)
    floats = io.BytesIO()
    fits.PrimaryHDU(np.arange(12, dtype=np.float32).reshape(3, 4)).writeto(floats)
    assert (read_frame(floats.getvalue()).pixels == np.arange(12).reshape(3, 4)).all()


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda data: b"P5 12 12", "not FITS"),
        (lambda data: data[:2880], "too soon"),
        (lambda data: data[:560], "no end"),
        (
            lambda data: data.replace(
                b"NAXIS   =                    2", b"NAXIS   =                    0"
            ),
            "no picture",
        ),
        (lambda data: data.replace(b"765", b"-65"), "no sense"),
    ],
)
def test_what_is_no_picture_is_refused_in_words(spoil, said: str) -> None:
    data = fits_file(draw_picture(SHOT._replace(light=False), CHIP), [])
    with pytest.raises(UnreadableFrame, match=said):
        read_frame(spoil(data))
