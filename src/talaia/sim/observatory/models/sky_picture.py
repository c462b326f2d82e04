"""The picture that a CCD takes of the sky: stars, background, trails, noise. Pure, by numpy."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.imaging.star_catalog import FAINTEST, stars_near
from talaia.imaging.tangent_plane import TanWcs
from talaia.sim.observatory.models.optics import RATIO, STEP_UM, blur_profile, flat_field

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Chip", "Shot", "draw_picture", "wcs_of"]


# Pixels across; a star that is farther out of focus is drawn no larger.
WIDEST_RING = 60.0


class Chip(NamedTuple):
    """The detector behind the telescope: an SBIG ST-7 (KAF-0400) at 2 m.

    Attributes:
        gain: electrons for each count, at the lowest setting.
        read: noise of reading (electrons).
        full: most electrons of a pixel.
        zero: magnitude that gives one electron in a second, through nothing.
        turned: north of the picture from up, to the east (°).

    """

    width: int = 765
    height: int = 510
    pixel_um: float = 9.0
    focal_mm: float = 2000.0
    gain: float = 2.3
    read: float = 15.0
    bias: float = 100.0
    full: float = 100_000.0
    zero: float = 22.0
    turned: float = 0.0

    @property
    def scale(self) -> float:
        """Give the size of a pixel on the sky (arc seconds)."""
        return 206.265 * self.pixel_um / self.focal_mm


class Shot(NamedTuple):
    """How a picture is taken.

    Attributes:
        ra: of the centre when it begins (°, J2000).
        dec: of the centre when it begins (°, J2000).
        seconds: exposed.
        light: stars and sky reach the chip.
        celsius: of the chip.
        sky: brightness of the sky (mag of a square arc second).
        lamp: light of the flat field's lamp (electrons/s and pixel).
        clear: part of the stars' light that clouds and the filter let through.
        sky_clear: part of the sky's light that the filter lets through.
        filter_name: whose dust is on the picture.
        seeing: width of a star at half its height (arc seconds).
        defocus: the focuser stands so many steps off.
        drift: how far the telescope moved meanwhile (arc seconds to the east and north).
        binning: pixels read as one, along each side.
        gain: counts for each electron, as a multiple of the lowest setting.
        seed: of the noise and the satellites.

    """

    ra: float
    dec: float
    seconds: float
    light: bool = True
    celsius: float = -10.0
    sky: float = 21.5
    lamp: float = 0.0
    clear: float = 1.0
    sky_clear: float = 1.0
    filter_name: str = ""
    seeing: float = 3.0
    defocus: float = 0.0
    drift: tuple[float, float] = (0.0, 0.0)
    binning: int = 1
    gain: float = 1.0
    seed: int = 0


def wcs_of(ra: float, dec: float, chip: Chip) -> TanWcs:
    """Give where the pixels of an unbinned picture stand; bottom row first, east to the left."""
    scale, turn = chip.scale / 3600.0, math.radians(chip.turned)
    cd = (-scale * math.cos(turn), scale * math.sin(turn))
    return TanWcs(ra, dec, (chip.width - 1) / 2, (chip.height - 1) / 2, (*cd, cd[1], -cd[0]))


def draw_picture(shot: Shot, chip: Chip) -> NDArray[np.uint16]:
    """Draw a picture: counts of 16 bits, bottom row first, shape (rows, columns) as binned."""
    dice = np.random.default_rng(shot.seed)
    bright = np.full((chip.height, chip.width), shot.lamp)
    if shot.light:
        # Pogson: five magnitudes are a factor of 100; `zero` gives one electron a second.
        bright += 10 ** (0.4 * (chip.zero - shot.sky)) * chip.scale**2 * shot.sky_clear
    electrons = bright * shot.seconds
    if shot.light and shot.seconds > 0.0:
        _add_stars(electrons, shot, chip)
        _add_trails(electrons, shot, chip, dice)
    if shot.light or shot.lamp:
        electrons *= flat_field(chip.width, chip.height, shot.filter_name)
    # Dark current doubles with every 6.3 °C; an electron each second at 0 °C for this chip.
    electrons += shot.seconds * 2.0 ** (shot.celsius / 6.3) * _hot_pixels(chip)
    # A full pixel spills no farther here.
    binned = _binned(np.minimum(electrons, chip.full), shot.binning)
    # Poisson's noise is normal where there are more than some tens; read noise hides the rest.
    noise = np.sqrt(binned + chip.read**2)
    counts = (binned + noise * dice.standard_normal(binned.shape)) * shot.gain / chip.gain
    return np.clip(counts + chip.bias, 0, 65535).astype(np.uint16)


def _binned(electrons: NDArray[np.float64], binning: int) -> NDArray[np.float64]:
    if binning == 1:
        return electrons
    height, width = (size // binning for size in electrons.shape)
    whole = electrons[: height * binning, : width * binning]
    return np.asarray(whole.reshape(height, binning, width, binning).sum(axis=(1, 3)))


@lru_cache(maxsize=4)
def _hot_pixels(chip: Chip) -> NDArray[np.float64]:
    """Give each pixel's dark current as a multiple: one in two thousand is hot."""
    dice = np.random.default_rng((chip.width, chip.height))
    hot = dice.random((chip.height, chip.width)) < 1 / 2000
    return np.where(hot, dice.uniform(20.0, 400.0, hot.shape), 1.0)


def _add_stars(electrons: NDArray[np.float64], shot: Shot, chip: Chip) -> None:
    """Add the light of each star in the field to its pixels."""
    radius = math.hypot(chip.width, chip.height) / 2 * chip.scale / 3600.0
    # What gives less than three electrons in all is not to be told from nothing.
    faintest = chip.zero + 2.5 * math.log10(max(1e-9, shot.seconds * shot.clear) / 3.0)
    stars = stars_near(shot.ra, shot.dec, radius * 1.05, min(FAINTEST, faintest))
    if not len(stars.ra):
        return
    fwhm = round(shot.seeing / chip.scale, 2)
    # To half a pixel: a profile is reckoned once and kept.
    ring = min(WIDEST_RING, abs(shot.defocus) * STEP_UM / RATIO / chip.pixel_um)
    blur = round(ring * 2) / 2
    profile, reach = blur_profile(fwhm, blur)
    x, y = wcs_of(shot.ra, shot.dec, chip).sky_to_pixel(stars.ra, stars.dec)
    light = shot.seconds * shot.clear * 10 ** (0.4 * (chip.zero - stars.mag))
    # The telescope moves one way, so the stars move the other; east is to the left.
    turn, (east, north) = math.radians(chip.turned), shot.drift
    path = (
        np.array(
            [
                east * math.cos(turn) - north * math.sin(turn),
                -east * math.sin(turn) - north * math.cos(turn),
            ]
        )
        / chip.scale
    )
    steps = min(24, 1 + math.ceil(float(np.hypot(*path))))
    peak = float(profile[0])
    for part in (np.arange(steps) + 0.5) / steps if steps > 1 else (0.0,):
        for lit in _by_brightness(light * peak):
            far = reach if lit.bright else min(reach, max(6.0, 2.2 * fwhm + blur))
            _add_stamps(
                electrons,
                places=np.stack([x[lit.chosen] + path[0] * part, y[lit.chosen] + path[1] * part]),
                light=light[lit.chosen] / steps,
                profile=profile,
                reach=math.ceil(far),
            )


class _Group(NamedTuple):
    bright: bool
    chosen: NDArray[np.int_]


def _by_brightness(peaks: NDArray[np.float64]) -> list[_Group]:
    # The wings of faint stars are lost in the noise: a small stamp is enough.
    bright = peaks > 2000.0
    groups = [_Group(True, np.flatnonzero(bright)), _Group(False, np.flatnonzero(~bright))]  # noqa: FBT003
    return [group for group in groups if len(group.chosen)]


def _add_stamps(
    electrons: NDArray[np.float64],
    *,
    places: NDArray[np.float64],
    light: NDArray[np.float64],
    profile: NDArray[np.float64],
    reach: int,
) -> None:
    """Add one square stamp for each star; what falls beside the chip is lost."""
    height, width = electrons.shape
    axis = np.arange(-reach, reach + 1)
    # Some hundred stars at once, so that memory stays small.
    for first in range(0, len(light), 400):
        x, y = places[:, first : first + 400]
        left, low = np.round(x).astype(int), np.round(y).astype(int)
        px = (left[:, None] + axis)[:, None, :]
        py = (low[:, None] + axis)[:, :, None]
        far = np.hypot(px - x[:, None, None], py - y[:, None, None])
        stamp = np.interp(far, np.arange(len(profile)) / 4.0, profile, right=0.0)
        stamp *= light[first : first + 400, None, None]
        inside = (px >= 0) & (px < width) & (py >= 0) & (py < height)
        flat = np.where(inside, py * width + px, 0)
        weights = np.where(inside, stamp, 0.0)
        electrons += np.bincount(flat.ravel(), weights.ravel(), minlength=height * width).reshape(
            height, width
        )


def _add_trails(
    electrons: NDArray[np.float64], shot: Shot, chip: Chip, dice: np.random.Generator
) -> None:
    """Draw the satellites that crossed the field: one in about half an hour of exposure."""
    y, x = np.ogrid[0 : chip.height, 0 : chip.width]
    for _ in range(int(dice.poisson(shot.seconds / 1800.0))):
        angle = dice.uniform(0.0, math.pi)
        middle = dice.uniform(0, chip.width), dice.uniform(0, chip.height)
        off = (x - middle[0]) * math.sin(angle) - (y - middle[1]) * math.cos(angle)
        sigma = shot.seeing / chip.scale / 2.355
        # It passes within a second: so bright that it stands out, not by how long one exposes.
        electrons += 900.0 * shot.clear * np.exp(-(off**2) / (2.0 * sigma**2))
