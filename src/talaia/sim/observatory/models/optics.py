"""What stands between the sky and the chip: focus, filters, flat field. Pure.

A Schmidt-Cassegrain of 200 mm at f/10. Its mirror is moved for focusing, which shifts the focus by
the square of the secondary's magnification: 5 µm for each step of the motor.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["FILTERS", "Filter", "best_focus", "blur_profile", "flat_field"]

# Micrometres that the focus moves with a step, and the focal ratio.
STEP_UM, RATIO = 5.0, 10.0
# Part of the mirror's diameter that the secondary hides.
OBSTRUCTION = 0.35
# Where the best focus is at 10 °C without a filter, and how it moves when the tube shrinks.
FOCUS_AT_10, STEPS_PER_DEGREE = 25000.0, -18.0


class Filter(NamedTuple):
    """A filter of the wheel.

    Attributes:
        name: as observers write it.
        stars: part of a star's light that it lets through.
        sky: part of the sky's light.
        thickness: by how many steps it moves the focus.

    """

    name: str
    stars: float
    sky: float
    thickness: float


FILTERS = (
    Filter("L", 0.95, 0.95, 0.0),
    Filter("R", 0.30, 0.28, 22.0),
    Filter("G", 0.32, 0.30, 15.0),
    Filter("B", 0.26, 0.24, -12.0),
    # A narrow band: a star gives less through it than a nebula would.
    Filter("Ha", 0.020, 0.012, 45.0),
)


def best_focus(celsius: float, filter_name: str = "") -> float:
    """Give the focuser's position (steps) at which stars are smallest."""
    thickness = next((glass.thickness for glass in FILTERS if glass.name == filter_name), 0.0)
    return FOCUS_AT_10 + STEPS_PER_DEGREE * (celsius - 10.0) + thickness


@lru_cache(maxsize=32)
def blur_profile(fwhm: float, defocus: float) -> tuple[NDArray[np.float64], float]:
    """Give the light of a star by its distance from the centre.

    The seeing is a Moffat profile with β = 3 (Trujillo et al. 2001, MNRAS 328, 977); a star out of
    focus is the mirror's ring, spread by the seeing.

    Args:
        fwhm: of the seeing (pixels).
        defocus: diameter of the ring (pixels).

    Returns:
        Light for each square pixel at 0, 0.25, 0.5 … pixels from the centre, of a star whose light
        is 1 in all; and the radius (pixels) that holds nearly all of it.

    """
    reach = max(12.0, 4.0 * fwhm + defocus)
    # Four points for each pixel.
    axis = np.arange(-math.ceil(reach) * 4, math.ceil(reach) * 4 + 1) / 4.0
    far = np.hypot(axis[:, None], axis)
    alpha = fwhm / (2.0 * math.sqrt(2 ** (1 / 3.0) - 1.0))
    seen = (1.0 + (far / alpha) ** 2) ** -3.0
    if defocus > 0.5:
        ring = (far <= defocus / 2) & (far >= OBSTRUCTION * defocus / 2)
        spectrum = np.fft.rfft2(np.fft.ifftshift(seen)) * np.fft.rfft2(np.fft.ifftshift(ring * 1.0))
        seen = np.clip(np.fft.fftshift(np.fft.irfft2(spectrum, s=seen.shape)), 0.0, None)
    seen /= seen.sum() / 16.0
    middle = len(axis) // 2
    return seen[middle, middle:], reach


@lru_cache(maxsize=8)
def flat_field(width: int, height: int, filter_name: str) -> NDArray[np.float64]:
    """Give how the chip answers even light: vignetting, dust on the filter, unequal pixels.

    Returns:
        Part of the light, 1 in the middle of a clean chip, shape (height, width).

    """
    y, x = np.mgrid[0:height, 0:width]
    far = np.hypot(x - width / 2, y - height / 2) / math.hypot(width / 2, height / 2)
    field = 1.0 - 0.12 * far**2
    dust = np.random.default_rng([*filter_name.encode(), width])
    for _ in range(6):
        ring = np.hypot(x - dust.uniform(0, width), y - dust.uniform(0, height))
        field *= 1.0 - dust.uniform(0.02, 0.06) * np.exp(-(((ring - 14.0) / 5.0) ** 2))
    pixels = np.random.default_rng(width * height).normal(1.0, 0.006, (height, width))
    return np.asarray(field * pixels)
