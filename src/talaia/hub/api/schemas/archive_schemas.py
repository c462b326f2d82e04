"""JSON bodies of the archive; the browser's types are made from these.

Times ending in ``_us`` are microseconds since the epoch (UTC), angles are degrees (J2000). What a
header does not say is null, or empty where it is a text.
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

__all__ = [
    "CardShape",
    "FrameDetail",
    "FrameList",
    "FrameShape",
    "HistogramShape",
    "NightList",
    "NightShape",
]


class _Shape(BaseModel):
    """A key that is not described is an error, not a silence."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class NightShape(_Shape):
    """A night, by the local date at which it began; it lasts from noon to noon."""

    night: str
    frames: int
    bytes: int


class NightList(_Shape):
    """Newest first."""

    nights: list[NightShape]


class FrameShape(_Shape):
    """One picture; ``problems`` is what the check against the FITS standard found."""

    id: str
    device: str
    night: str
    name: str
    time_us: int  # when the exposure began (UTC)
    target: str
    filter: str
    kind: str
    exposure_s: float | None
    ra_deg: float | None  # J2000; null where the header does not say
    dec_deg: float | None
    width: int
    height: int
    bytes: int
    digest: str  # of the file as its gateway sent it
    problems: list[str]
    measured: bool  # its quality was looked at; what is null then cannot be told
    solved: bool  # its header says where each pixel stands
    stars: int | None
    fwhm: float | None  # of its stars (arc seconds)
    background: float | None  # of the sky (counts)
    zero_point: float | None  # magnitude of a star that gives one count in a second
    note: str  # why it was not solved, or not measured


class FrameList(_Shape):
    """Newest first; ``more`` says that there are older ones that fit."""

    frames: list[FrameShape]
    more: bool


class HistogramShape(_Shape):
    """How the values lie: counts in bins of equal width from ``low`` to ``high``."""

    minimum: float | None
    maximum: float | None
    median: float | None
    deviation: float | None
    low: float | None
    high: float | None
    counts: list[int]


class CardShape(_Shape):
    """One card of a header."""

    key: str
    value: str
    comment: str


class FrameDetail(_Shape):
    """A picture, how its values lie, and its header."""

    frame: FrameShape
    histogram: HistogramShape
    header: list[CardShape]
