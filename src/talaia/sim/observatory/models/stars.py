"""A synthetic sky, the same for the same place, and the picture a CCD takes of it. Pure.

The sky (J2000) is cut into cells of about half a degree; each cell's stars come from a generator
seeded by the cell's name, so that two pictures of one field show one field. Their number follows
log N(<m) = 0.45 m - 4.9 per square degree, about that of the real sky at middle galactic latitude
(Allen's Astrophysical Quantities, 4th edition, table 19.10, between 10th and 16th magnitude).
"""

from __future__ import annotations

import math
import random
from array import array
from typing import NamedTuple

__all__ = ["Chip", "Shot", "Star", "draw_picture", "project_star", "stars_near"]

CELL = 0.5
FAINTEST = 15.5
BRIGHTEST = 5.0
SLOPE, ZERO = 0.45, -4.9


class Star(NamedTuple):
    """A star: right ascension (°), declination (°), magnitude."""

    ra: float
    dec: float
    mag: float


class Chip(NamedTuple):
    """The detector behind the telescope: an SBIG ST-7 (KAF-0400) at 2 m.

    Attributes:
        scale: of a pixel (arc seconds).
        gain: electrons for each count.
        read: noise of reading (electrons).
        full: most electrons of a pixel.
        zero: magnitude that gives one electron in a second.

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

    @property
    def scale(self) -> float:
        """Give the size of a pixel on the sky (arc seconds)."""
        return 206.265 * self.pixel_um / self.focal_mm


class Shot(NamedTuple):
    """How a picture is taken.

    Attributes:
        ra: of the centre (°, J2000).
        dec: of the centre (°, J2000).
        seconds: exposed.
        light: false for a dark or bias.
        celsius: of the chip.
        sky: background (electrons/s and pixel).
        dimmed: part of the light that clouds and the shutter let through.
        seeing: width of a star at half its height (arc seconds).

    """

    ra: float
    dec: float
    seconds: float
    light: bool = True
    celsius: float = -10.0
    sky: float = 2.0
    dimmed: float = 1.0
    seeing: float = 3.0
    seed: int = 0


def stars_near(ra: float, dec: float, radius: float) -> list[Star]:
    """List the stars of all cells within a radius (°) of a place (°, J2000)."""
    found: list[Star] = []
    low = math.floor((dec - radius + 90.0) / CELL)
    high = math.floor((dec + radius + 90.0) / CELL)
    for band in range(max(0, low), min(round(180 / CELL) - 1, high) + 1):
        middle = -90.0 + (band + 0.5) * CELL
        # Cells of about equal area: a band nearer the pole has fewer of them.
        count = max(1, round(360.0 * math.cos(math.radians(middle)) / CELL))
        width = 360.0 / count
        # Right ascension spans more degrees near the pole; a whole cell is added for the edges.
        reach = min(180.0, radius / max(0.01, math.cos(math.radians(middle))) + width)
        first, last = math.floor((ra - reach) / width), math.floor((ra + reach) / width)
        # Near the pole both ends may reach the same cell: each counts once.
        for column in {index % count for index in range(first, min(last, first + count) + 1)}:
            found += _stars_of_cell(band, column, width)
    return found


def _stars_of_cell(band: int, column: int, width: float) -> list[Star]:
    # Seeded by the cell, so that the same field shows the same stars every night.
    dice = random.Random(f"talaia sky {band} {column}")  # noqa: S311 - a drawn sky
    dec = -90.0 + band * CELL
    area = width * CELL * math.cos(math.radians(dec + CELL / 2))
    # Star counts grow exponentially with magnitude: log N = SLOPE · m + ZERO.
    mean = area * 10 ** (SLOPE * FAINTEST + ZERO)
    number = max(0, round(dice.gauss(mean, math.sqrt(mean))))
    stars = []
    for _ in range(number):
        # The law of numbers, turned round.
        mag = FAINTEST + math.log10(1.0 - dice.random()) / SLOPE
        place = (column + dice.random()) * width, dec + dice.random() * CELL
        stars.append(Star(*place, max(BRIGHTEST, mag)))
    return stars


def project_star(ra: float, dec: float, ra0: float, dec0: float) -> tuple[float, float] | None:
    """Give standard coordinates (°, to the east and north) about a centre; the TAN projection."""
    # Gnomonic projection: Calabretta and Greisen 2002, A&A 395, 1077, section 5.1.3.
    a, d, d0 = math.radians(ra - ra0), math.radians(dec), math.radians(dec0)
    cosine = math.sin(d0) * math.sin(d) + math.cos(d0) * math.cos(d) * math.cos(a)
    if cosine <= 0.0:
        # Behind the observer: the plane of the picture does not have it.
        return None
    xi = math.cos(d) * math.sin(a) / cosine
    eta = (math.cos(d0) * math.sin(d) - math.sin(d0) * math.cos(d) * math.cos(a)) / cosine
    return math.degrees(xi), math.degrees(eta)


def draw_picture(shot: Shot, chip: Chip) -> list[array[int]]:
    """Draw a picture: counts of 16 bits, bottom row first, east to the left."""
    dice = random.Random(shot.seed)  # noqa: S311 - noise
    # Dark current doubles with every 6.3 °C; an electron each second at 0 °C for this chip.
    flat = shot.seconds * 2.0 ** (shot.celsius / 6.3)
    if shot.light:
        flat += shot.seconds * shot.sky
    noise = math.sqrt(chip.read**2 + max(0.0, flat))
    # One table of noise, read from another place for each row: a tenth of the time.
    table = [dice.gauss(flat, noise) for _ in range(16 * 1024)]
    top, gain, bias = chip.full, chip.gain, chip.bias
    lit: dict[int, dict[int, float]] = {}
    if shot.light and shot.dimmed > 0.0:
        lit = _spread_light(shot, chip)
    rows = []
    for y in range(chip.height):
        begin = dice.randrange(len(table) - chip.width)
        row = table[begin : begin + chip.width]
        for x, electrons in lit.get(y, {}).items():
            row[x] += dice.gauss(electrons, math.sqrt(electrons))
        counts = [int(min(e, top) / gain + bias) for e in row]
        rows.append(array("H", [0 if c < 0 else min(c, 65535) for c in counts]))
    return rows


def _spread_light(shot: Shot, chip: Chip) -> dict[int, dict[int, float]]:
    """Spread the light of each star in the field over its pixels (a Gaussian)."""
    degree = 3600.0 / chip.scale
    # Full width at half maximum is 2 √(2 ln 2) σ.
    sigma = shot.seeing / chip.scale / 2.3548
    radius = math.hypot(chip.width, chip.height) / 2 / degree
    lit: dict[int, dict[int, float]] = {}
    for star in stars_near(shot.ra, shot.dec, radius):
        flat = project_star(star.ra, star.dec, shot.ra, shot.dec)
        if flat is None:
            continue
        x = (chip.width - 1) / 2 - flat[0] * degree
        y = (chip.height - 1) / 2 + flat[1] * degree
        # A star just beyond the edge still sheds light into the picture.
        if not (-10 < x < chip.width + 10 and -10 < y < chip.height + 10):
            continue
        # Pogson: five magnitudes are a factor of 100; `zero` gives one electron a second.
        light = shot.seconds * shot.dimmed * 10 ** (0.4 * (chip.zero - star.mag))
        # Less than a thousandth of a star's light falls farther out.
        reach = math.ceil(sigma * 4)
        for py in range(max(0, round(y) - reach), min(chip.height, round(y) + reach + 1)):
            row = lit.setdefault(py, {})
            for px in range(max(0, round(x) - reach), min(chip.width, round(x) + reach + 1)):
                far = ((px - x) ** 2 + (py - y) ** 2) / (2 * sigma * sigma)
                row[px] = row.get(px, 0.0) + light * math.exp(-far) / (2 * math.pi * sigma**2)
    return lit
