"""Names of the sky: NGC, IC, Messier and what people call them, if the catalogue is installed.

The catalogue (OpenNGC, by the package ``pyongc`` of the extra ``observatory``) comes with its own
licence, so that it is asked, and never copied into this project.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

__all__ = ["CatalogObject", "is_there", "look_up", "objects_between"]

# In one answer.
MOST = 8
# OpenNGC's own word for what is another name of something, or is not there at all.
_NOTHING = frozenset({"Duplicated record", "Nonexistent object"})


class CatalogObject(NamedTuple):
    """Something of the catalogue; degrees of J2000, magnitude NaN where nobody has measured it.

    ``major`` and ``minor`` are its diameters (°); ``angle`` is where the longer one points, from
    north through east (°).
    """

    name: str
    also: tuple[str, ...]
    kind: str
    constellation: str
    ra_deg: float
    dec_deg: float
    magnitude: float
    major: float | None = None
    minor: float | None = None
    angle: float = 0.0


@functools.cache
def _load_catalogue() -> Any:  # noqa: ANN401 - the package has no types
    try:
        from pyongc import ongc
    except ImportError:
        return None
    return ongc


def is_there() -> bool:
    """Say whether the catalogue is installed."""
    return _load_catalogue() is not None


def look_up(name: str) -> list[CatalogObject]:
    """Find what goes by a designation (``M31``, ``NGC 7000``) or a part of a common name.

    Reads a file: not for the event loop. At most `MOST`, brightest first.
    """
    catalogue = _load_catalogue()
    # The database reads % and _ as "anything".
    words = " ".join(name.replace("%", " ").replace("_", " ").split())
    if catalogue is None or not words:
        return []
    # A designation means one thing; only a name may mean several.
    exact = catalogue.get(words)
    rows = [exact] if exact is not None else catalogue.listObjects(cname=words)
    found = [_catalog_object(row) for row in rows if row.type not in _NOTHING]
    there = [sky_object for sky_object in found if sky_object is not None]
    return sorted(there, key=lambda found: (math.isnan(found.magnitude), found.magnitude))[:MOST]


def objects_between(
    ra: tuple[float, float], dec: tuple[float, float], smallest: float
) -> list[CatalogObject]:
    """List what lies in a range of right ascension and of declination (°, J2000).

    Reads a file: not for the event loop.

    Args:
        ra: from, to.
        dec: from, to.
        smallest: of its longer diameter (arc minutes); what nobody has measured is left out.

    """
    catalogue = _load_catalogue()
    if catalogue is None:
        return []
    rows = catalogue.listObjects(
        minra=ra[0], maxra=ra[1], mindec=dec[0], maxdec=dec[1], minsize=smallest
    )
    found = [_catalog_object(row) for row in rows if row.type not in _NOTHING]
    return [sky_object for sky_object in found if sky_object is not None]


def _catalog_object(row: Any) -> CatalogObject | None:  # noqa: ANN401 - the package has no types
    if row.coords is None:
        return None
    (hour, minute, second), (degree, arcminute, arcsecond) = row.coords.tolist()
    # By its text: of −0° 30′ the number of degrees has no sign.
    sign = -1.0 if str(row.dec).startswith("-") else 1.0
    messier, _, _, common, _ = row.identifiers
    blue, visual = row.magnitudes[:2]
    # For some of them only a blue magnitude is known.
    measured = visual if visual is not None else blue
    major, minor, angle = row.dimensions
    return CatalogObject(
        name=row.name,
        also=tuple(name for name in (messier, *(common or ())) if name),
        kind=row.type,
        constellation=row.constellation or "",
        ra_deg=(hour + minute / 60 + second / 3600) * 15,
        dec_deg=sign * (abs(degree) + abs(arcminute) / 60 + abs(arcsecond) / 3600),
        magnitude=math.nan if measured is None else float(measured),
        major=None if major is None else float(major) / 60,
        # Where only one is known it is round.
        minor=None if major is None else float(minor if minor is not None else major) / 60,
        angle=float(angle or 0.0),
    )
