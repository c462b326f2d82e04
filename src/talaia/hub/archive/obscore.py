"""The archive as a table of IVOA ObsCore 1.1, as VOTable 1.4 and as CSV. Pure.

The columns are those of `obscore_columns`.
"""

from __future__ import annotations

import csv
import io
import math
import re
from typing import TYPE_CHECKING, NamedTuple
from xml.sax.saxutils import escape, quoteattr

from talaia.hub.archive.obscore_columns import COLUMNS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from talaia.hub.archive.frame_rows import ArchivedFrame

__all__ = [
    "ObscoreContext",
    "ObscoreValue",
    "frame_corners",
    "number_or_none",
    "obscore_row",
    "write_csv",
    "write_votable",
]

ObscoreValue = str | int | float | None
_DAY_US = 86_400e6
# MJD of the epoch of Unix.
_MJD_EPOCH = 40_587.0
# Of photometric bands by their usual letters: shortest and longest wavelength (nm), from the
# half-power points of Bessell (1990, PASP 102, 1181).
_BANDS_NM = {
    "U": (333.0, 399.0),
    "B": (398.0, 492.0),
    "V": (507.0, 595.0),
    "R": (589.0, 727.0),
    "I": (731.0, 880.0),
}
# The words of one-letter wheels that amateurs' filters have; wide and not standardised.
_BAND_WORDS = {"BLUE": "B", "VISUAL": "V", "RED": "R"}


class ObscoreContext(NamedTuple):
    """What a row needs besides its picture.

    Attributes:
        origin: of the hub, for addresses: ``https://hub.example``.
        proposal: for which it was taken; empty where that is not known, or not for this reader.

    """

    origin: str
    proposal: str = ""


def obscore_row(frame: ArchivedFrame, context: ObscoreContext) -> tuple[ObscoreValue, ...]:
    """Give the values of a picture, in the order of `COLUMNS`."""
    measures = frame.measures
    exposure = number_or_none(frame.exposure_s)
    begin = _MJD_EPOCH + frame.time_us / _DAY_US if frame.time_us else None
    end = begin + exposure / 86_400.0 if begin is not None and exposure is not None else None
    corners = frame_corners(frame)
    shortest, longest = _band_of(frame.filter)
    place = f"/api/sites/{frame.site}/frames/{frame.id}/file"
    region = " ".join(f"{value:.6f}" for corner in corners for value in corner)
    return (
        "image",
        # Raw pixels in a standard format, with a WCS where there is one.
        1,
        frame.site,
        frame.name.removesuffix(".fits"),
        # No registered authority: the digest makes it one of its own.
        f"ivo://talaia.invalid/{frame.site}?{frame.digest}",
        context.origin + place,
        "application/fits",
        max(1, round(frame.bytes / 1000)),
        frame.target,
        number_or_none(frame.ra_deg),
        number_or_none(frame.dec_deg),
        _widest(corners),
        f"POLYGON ICRS {region}" if corners else None,
        frame.width,
        frame.height,
        number_or_none(measures.fwhm),
        begin,
        end,
        exposure,
        # One exposure is one bin of time, as wide as itself.
        exposure,
        1,
        shortest,
        longest,
        None,
        1,
        "phot.count",
        None,
        0,
        frame.site,
        frame.device,
        context.proposal or None,
        frame.filter or None,
        measures.stars,
        number_or_none(measures.background),
        number_or_none(measures.zero_point),
    )


def frame_corners(frame: ArchivedFrame) -> tuple[tuple[float, float], ...]:
    """Give right ascension and declination (°) of the four corners; none where it is unsolved."""
    if len(frame.measures.wcs) != 8:
        return ()
    # Here: numpy is not for a hub that has no telescope.
    from talaia.imaging.tangent_plane import TanWcs

    ra0, dec0, x, y, a, b, c, d = frame.measures.wcs
    right, top = frame.width - 0.5, frame.height - 0.5
    wcs = TanWcs(ra0, dec0, x, y, (a, b, c, d))
    ra, dec = wcs.pixel_to_sky([-0.5, right, right, -0.5], [-0.5, -0.5, top, top])
    return tuple(zip(map(float, ra), map(float, dec), strict=True))


def write_csv(rows: Iterable[Sequence[ObscoreValue]]) -> Iterator[str]:
    """Write a table as CSV (RFC 4180), line by line; what is not known is empty."""
    yield _csv_line([column.name for column in COLUMNS])
    for row in rows:
        yield _csv_line(["" if value is None else _csv_safe(value) for value in row])


def write_votable(rows: Iterable[Sequence[ObscoreValue]], name: str) -> Iterator[str]:
    """Write a table as VOTable 1.4 (TABLEDATA), piece by piece."""
    yield (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<VOTABLE version="1.4" xmlns="http://www.ivoa.net/xml/VOTable/v1.3">\n'
        '<RESOURCE type="results">\n'
        '<INFO name="QUERY_STATUS" value="OK"/>\n'
        f'<TABLE name={quoteattr(_xml_safe(name))} utype="ivo://ivoa.net/std/obscore#core-1.1">\n'
    )
    for column in COLUMNS:
        size = ' arraysize="*"' if column.kind == "char" else ""
        about = "".join(
            f" {key}={quoteattr(value)}"
            for key, value in (
                ("unit", column.unit),
                ("ucd", column.ucd),
                ("utype", f"obscore:{column.utype}" if column.utype else ""),
                ("xtype", "adql:REGION" if column.name == "s_region" else ""),
            )
            if value
        )
        yield f'<FIELD name="{column.name}" datatype="{column.kind}"{size}{about}/>\n'
    yield "<DATA><TABLEDATA>\n"
    for row in rows:
        cells = "".join(
            # An empty cell is NULL, also of numbers (VOTable 1.3, 2.1.5).
            "<TD/>" if value is None else f"<TD>{escape(_xml_safe(str(value)))}</TD>"
            for value in row
        )
        yield f"<TR>{cells}</TR>\n"
    yield "</TABLEDATA></DATA>\n</TABLE>\n</RESOURCE>\n</VOTABLE>\n"


def number_or_none(value: float) -> float | None:
    """Give a number; none for what is not known, for which JSON and CSV have no number."""
    return value if math.isfinite(value) else None


def _band_of(name: str) -> tuple[float | None, float | None]:
    word = name.strip().upper()
    low, high = _BANDS_NM.get(_BAND_WORDS.get(word, word), (None, None))
    # Any other filter: better nothing than a guess.
    return (None, None) if low is None or high is None else (low * 1e-9, high * 1e-9)


def _widest(corners: Sequence[tuple[float, float]]) -> float | None:
    """Give the diameter (°) of the circle about a field: its longer diagonal."""
    if len(corners) != 4:
        return None
    return max(_apart(corners[0], corners[2]), _apart(corners[1], corners[3]))


def _apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    # The haversine, which keeps its digits for small angles.
    (a1, d1), (a2, d2) = (tuple(map(math.radians, place)) for place in (one, other))
    half = math.sin((d2 - d1) / 2) ** 2 + math.cos(d1) * math.cos(d2) * math.sin((a2 - a1) / 2) ** 2
    return math.degrees(2 * math.asin(min(1.0, math.sqrt(half))))


def _csv_line(values: Sequence[object]) -> str:
    out = io.StringIO()
    csv.writer(out).writerow(values)
    return out.getvalue()


def _csv_safe(value: str | float) -> str | float:
    # A spreadsheet would run a text that begins like this.
    return f"'{value}" if isinstance(value, str) and re.match(r"[=+\-@\t\r]", value) else value


def _xml_safe(text: str) -> str:
    # Characters that XML 1.0 cannot hold, in no spelling.
    return re.sub(r"[^\t\n\r\x20-\uD7FF\uE000-\uFFFD\U00010000-\U0010FFFF]", "?", text)
