"""The pages' projection is held against numbers of astropy: these are still what astropy says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

VECTORS = Path(__file__).parents[2] / "web" / "tests" / "sky" / "tangent-vectors.json"
# Right ascension and declination (°) of centres: the equator, the seam, both poles and near them.
CENTRES = [(83.8, -5.4), (0.01, 41.3), (359.99, -30.0), (210.0, 89.7), (40.0, 90.0), (12.0, -89.9)]


def reckon() -> list[dict[str, float]]:
    """Give places on tangent planes, as `astropy.wcs` has them."""
    wcs = pytest.importorskip("astropy.wcs")
    found = []
    for ra0, dec0 in CENTRES:
        plane = wcs.WCS(naxis=2)
        plane.wcs.ctype = ["RA---TAN", "DEC--TAN"]
        plane.wcs.crval = [ra0, dec0]
        plane.wcs.crpix = [1.0, 1.0]
        # FITS turns the plane at the very pole by half a turn, where nobody says this.
        plane.wcs.lonpole = 180.0
        # A pixel is a degree, the first axis to the east.
        plane.wcs.cdelt = [1.0, 1.0]
        for east, north in [(0.1, 0.0), (-0.3, 0.2), (2.0, -1.5), (-12.0, 7.0), (0.0, 0.5)]:
            ra, dec = plane.pixel_to_world_values(east, north)
            found.append(
                {
                    "ra0": ra0,
                    "dec0": dec0,
                    "east": east,
                    "north": north,
                    "ra": float(np.round(ra, 10)),
                    "dec": float(np.round(dec, 10)),
                }
            )
    return found


def test_the_numbers_of_the_pages_tests_are_those_of_astropy() -> None:
    reckoned, kept = reckon(), json.loads(VECTORS.read_text())
    assert len(kept) == len(reckoned)
    for ours, theirs in zip(kept, reckoned, strict=True):
        assert ours == pytest.approx(theirs, abs=1e-9)
