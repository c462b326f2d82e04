"""Find the stars of a picture and measure how large they are. Pure; by `sep`.

`sep` is Source Extractor's detection as a library (Barbary 2016, JOSS 1, 58; Bertin and Arnouts
1996, A&AS 117, 393).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import sep

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["DetectedStars", "detect_stars"]

# Times the noise, and pixels, from which light is a star.
THRESHOLD, LEAST_AREA = 5.0, 5
# A half-flux radius (pixels) below which it is a hot pixel or a cosmic ray.
SHARPEST = 0.75
# A star lights the pixels beside its brightest one by this part of it and more; a weak hot pixel,
# whose radius is that of the noise around it, does not.
BESIDE = 0.25
# Most that are measured: a picture of the Milky Way has enough with these.
MOST = 500


class DetectedStars(NamedTuple):
    """The stars of a picture, the brightest first.

    Attributes:
        x: column of the centre (pixels, from 0).
        y: row of the centre.
        flux: above the background (counts).
        hfr: radius of the circle with half of the light (pixels).
        width: across what is brighter than half of the peak (pixels).
        elongation: longer axis by the shorter one; 1 for a round star.
        background: median of the sky (counts).
        noise: standard deviation of the sky (counts).

    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    flux: NDArray[np.float64]
    hfr: NDArray[np.float64]
    width: NDArray[np.float64]
    elongation: NDArray[np.float64]
    background: float
    noise: float

    @property
    def total(self) -> int:
        """Give how many there are."""
        return len(self.x)

    @property
    def median_hfr(self) -> float:
        """Give the middle half-flux radius (pixels); NaN without stars."""
        return float(np.median(self.hfr)) if self.total else float("nan")

    @property
    def fwhm(self) -> float:
        """Give the middle width at half the height (pixels); NaN without stars."""
        return float(np.median(self.width)) if self.total else float("nan")


def detect_stars(
    pixels: NDArray[Any], *, threshold: float = THRESHOLD, saturation: float = 60_000.0
) -> DetectedStars:
    """Find the stars of a picture.

    Stars at the edge and saturated ones are left out: their light and size are not whole.

    Args:
        pixels: counts, shape (rows, columns).
        threshold: times the noise.
        saturation: counts at which a pixel is full.

    """
    data = np.ascontiguousarray(pixels, dtype=np.float32)
    # What is no number is a dead pixel.
    data = np.where(np.isfinite(data), data, np.float32(np.nanmedian(data)))
    sky = sep.Background(data, bw=64, bh=64)
    bare = data - sky.back()
    noise = max(float(sky.globalrms), 1e-6)
    # Rings of stars out of focus are one star, not many: nothing is taken apart.
    found, parts = sep.extract(
        bare, threshold, err=noise, minarea=LEAST_AREA, deblend_cont=1.0, segmentation_map=True
    )
    across = _widths_of(bare, found["peak"], parts)
    order = np.argsort(-found["flux"], kind="stable")[: MOST * 2]
    found, across = found[order], across[order]
    size = np.maximum(found["a"], 1.0)
    reach = np.clip(6.0 * size, 6.0, 60.0)
    radius, _ = sep.flux_radius(bare, found["x"], found["y"], reach, 0.5, subpix=5)
    height, width = data.shape
    whole = (
        (found["x"] > 2 * size)
        & (found["x"] < width - 1 - 2 * size)
        & (found["y"] > 2 * size)
        & (found["y"] < height - 1 - 2 * size)
    )
    clean = (found["peak"] + sky.globalback < saturation) & (radius >= SHARPEST)
    clean &= _light_beside(bare, found) >= BESIDE
    kept = np.flatnonzero(whole & clean)[:MOST]
    stars, hfr = found[kept], np.asarray(radius)[kept]
    # One circle for all, so that fluxes compare; the outline of a faint star loses its wings.
    circle = max(4.0, 2.5 * float(np.median(hfr))) if len(kept) else 4.0
    flux, _, _ = sep.sum_circle(bare, stars["x"], stars["y"], circle)
    return DetectedStars(
        x=stars["x"],
        y=stars["y"],
        flux=np.asarray(flux, float),
        hfr=hfr,
        width=across[kept],
        elongation=stars["a"] / np.maximum(stars["b"], 1e-6),
        background=float(sky.globalback),
        noise=noise,
    )


def _light_beside(bare: NDArray[np.float32], found: NDArray[Any]) -> NDArray[np.float64]:
    """Give the mean of the four pixels beside each one's brightest, as a part of that."""
    edged = np.pad(bare, 1, mode="edge")
    x, y = found["xpeak"] + 1, found["ypeak"] + 1
    beside = (edged[y, x - 1] + edged[y, x + 1] + edged[y - 1, x] + edged[y + 1, x]) / 4.0
    return np.asarray(beside / np.maximum(edged[y, x], 1e-6), float)


def _widths_of(
    bare: NDArray[np.float32], peaks: NDArray[Any], parts: NDArray[Any]
) -> NDArray[np.float64]:
    """Give the diameter of the circle as large as what is brighter than half of each peak."""
    rows, columns = np.nonzero(parts)
    label = parts[rows, columns]
    bright = bare[rows, columns] >= peaks[label - 1] / 2.0
    pixels = np.bincount(label[bright] - 1, minlength=len(peaks))
    return np.asarray(2.0 * np.sqrt(pixels / np.pi))
