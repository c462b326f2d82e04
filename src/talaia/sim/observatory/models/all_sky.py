"""What a camera with a fisheye sees of all the sky: stars, Moon's light, true clouds. Pure.

Clouds are where a slow noise of waves is above a threshold that leaves as much of the sky free as
the weather says; they drift with the wind. A star behind one is three magnitudes and more fainter.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.imaging.sky_clouds import SkyMoment, lens_pixels, sky_stars
from talaia.model.units.astronomy import (
    Horizontal,
    equatorial_to_horizontal,
    julian_day,
    sun_position,
)
from talaia.sim.observatory.models.sky_brightness import moonlight, sky_magnitude

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.model.units.astronomy import Observer

__all__ = ["LENS", "SIZE", "SkyView", "cloud_map", "draw_sky"]

SIZE = 400
# Exposed so long (s); counts of a star of magnitude 0, and of a square degree as bright as one.
EXPOSURE_S = 20.0
_STAR, _GLOW = 30_000.0, 0.5
_BIAS, _READ, _GAIN = 12.0, 1.5, 4.0
# The width of a star (pixels), and how much of its light a cloud lets through.
_SIGMA, _THROUGH = 0.9, 0.05
# Waves of the clouds: so many, so many across the sky at the most, and how fast they drift.
_WAVES, _FINEST, _DRIFT = 20, 5.0, 1 / 600.0


class SimulatedLens(NamedTuple):
    """As `talaia.model.detection.SkyLens`, which the Python of ROS 1 cannot import."""

    x: float
    y: float
    radius: float
    turned: float
    mirrored: bool = False
    lowest: float = 25.0
    faintest: float = 4.5


# Of the camera in the example's description; north is not quite up.
LENS = SimulatedLens(x=201.5, y=197.0, radius=190.0, turned=12.0)


class SkyView(NamedTuple):
    """How it is taken.

    Attributes:
        place: where.
        unix: when (s, UTC).
        clouds: cover (%).
        seed: of clouds and noise.

    """

    place: Observer
    unix: float
    clouds: float
    seed: int = 0


class _Sky(NamedTuple):
    """The pixels of the sky: mask, directions in the plane of the zenith, and their sizes."""

    inside: NDArray[np.bool_]
    u: NDArray[np.float64]
    v: NDArray[np.float64]
    size: NDArray[np.float64]
    zenith: NDArray[np.float64]


def cloud_map(view: SkyView) -> NDArray[np.bool_]:
    """Tell of each pixel of the sky whether a cloud is before it; shape (rows, columns)."""
    sky = _sky_pixels()
    dice = np.random.default_rng(view.seed)
    noise = np.zeros(int(sky.inside.sum()))
    for _ in range(_WAVES):
        many, angle, phase = dice.uniform(0.8, _FINEST), *dice.uniform(0.0, 2 * math.pi, 2)
        speed = _DRIFT * many * dice.uniform(0.8, 1.2)
        along = many * (math.cos(angle) * sky.u + math.sin(angle) * sky.v)
        noise += np.cos(math.pi * along + phase + view.unix * speed) / many
    # The threshold by the size of each pixel on the sky, above what is looked at.
    looked = sky.zenith < 90.0 - LENS.lowest
    order = np.argsort(-noise[looked])
    share = np.cumsum(sky.size[looked][order]) / sky.size[looked].sum()
    at = int(np.searchsorted(share, min(1.0, max(0.0, view.clouds / 100.0))))
    covered = np.zeros((SIZE, SIZE), bool)
    if view.clouds > 0.0:
        threshold = -math.inf if at >= len(order) else noise[looked][order][at]
        covered[sky.inside] = noise > threshold
    return covered


def draw_sky(view: SkyView) -> NDArray[np.uint8]:
    """Draw a picture of 8 bits, top row first."""
    place, dice = view.place, np.random.default_rng((view.seed, int(view.unix)))
    sky, covered = _sky_pixels(), cloud_map(view)
    jd = julian_day(view.unix)
    sun = equatorial_to_horizontal(*sun_position(jd), place, jd).alt
    moon = moonlight(place, view.unix)
    # The zenith's brightness for all of it: gradients are what the measuring is not told of either.
    glow = _counts_of(sky_magnitude(Horizontal(80.0, 0.0), sun, moon, 0.0))
    bright = _counts_of(sky_magnitude(Horizontal(80.0, 0.0), sun, moon, 100.0))
    light = np.zeros((SIZE, SIZE))
    light[sky.inside] = np.where(covered[sky.inside], bright, glow) * (
        1.0 + 0.4 * (sky.zenith / 90.0) ** 2
    )
    stars = sky_stars(SkyMoment(place.latitude, place.longitude, view.unix), 6.0)
    x, y = lens_pixels(stars.alt, stars.az, LENS)
    air = 1.0 / np.sin(np.radians(np.maximum(stars.alt, 5.0)))
    flux = _STAR * 10 ** (-0.4 * (stars.mag + 0.2 * (air - 1.0)))
    row, column = (np.clip(np.round(at).astype(int), 0, SIZE - 1) for at in (y, x))
    behind = covered[row, column]
    _add_stars(light, x, y, np.where(behind, flux * _THROUGH, flux))
    noise = np.sqrt(light / _GAIN + _READ**2) * dice.standard_normal(light.shape)
    counts = light / _GAIN + noise + _BIAS
    return np.clip(np.round(counts), 0, 255).astype(np.uint8)


def _counts_of(mag: float) -> float:
    # A pixel is about half a degree across: a quarter of a square degree.
    degree = 10 ** (-0.4 * (mag - 2.5 * math.log10(3600.0**2)))
    return float(_STAR * degree * _GLOW * 0.25 * 0.1)


def _add_stars(
    light: NDArray[np.float64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    flux: NDArray[np.float64],
) -> None:
    axis = np.arange(-4, 5)
    column, row = np.round(x).astype(int), np.round(y).astype(int)
    px, py = column[:, None, None] + axis, row[:, None, None] + axis[:, None]
    far = (px - x[:, None, None]) ** 2 + (py - y[:, None, None]) ** 2
    stamp = np.exp(-far / (2.0 * _SIGMA**2)) * (flux / (2.0 * math.pi * _SIGMA**2))[:, None, None]
    inside = (px >= 0) & (px < SIZE) & (py >= 0) & (py < SIZE)
    px, py = np.broadcast_arrays(px, py)
    np.add.at(light, (py[inside], px[inside]), stamp[inside])


@lru_cache(maxsize=1)
def _sky_pixels() -> _Sky:
    row, column = np.mgrid[0:SIZE, 0:SIZE]
    u, v = (column - LENS.x) / LENS.radius, (row - LENS.y) / LENS.radius
    far = np.hypot(u, v)
    inside = far <= 1.0
    zenith = far[inside] * 90.0
    # A ring of a degree is as long as the sine of its distance from the zenith.
    size = np.where(zenith > 0.01, np.sin(np.radians(zenith)) / np.maximum(zenith, 0.01), 0.0175)
    return _Sky(inside, u[inside], v[inside], size, zenith)
