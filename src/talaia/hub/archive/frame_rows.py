"""What is known of a picture of the archive, as its row has it."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import msgspec

if TYPE_CHECKING:
    from sqlalchemy import RowMapping

__all__ = [
    "ArchivedFrame",
    "Cone",
    "FrameMeasures",
    "HookState",
    "MeasureState",
    "Night",
    "Wanted",
    "row_to_frame",
]


class MeasureState(IntEnum):
    """Whether a picture was measured."""

    WAITS = 0
    MEASURED = 1
    # It was kept before pictures were measured.
    OLD = 2


class HookState(IntEnum):
    """Whether the owner's hook has had a picture."""

    NONE = 0
    WAITS = 1
    HANDED_OVER = 2


class FrameMeasures(NamedTuple):
    """How good a picture is; as in `measure_child.MeasuredFile`, NaN for what is not known."""

    state: MeasureState = MeasureState.OLD
    stars: int | None = None
    fwhm: float = math.nan
    background: float = math.nan
    zero_point: float = math.nan
    wcs: tuple[float, ...] = ()
    note: str = ""


class ArchivedFrame(NamedTuple):
    """One picture. Names are those of `fits_reader.Facts`.

    Attributes:
        night: local date at which its night began.
        name: of the file, for people.
        ra_deg: of its middle where it was solved; else what its header says.
        digest: of the file as its gateway sent it, before it was measured.

    """

    id: int
    site: str
    device: str
    night: str
    name: str
    time_us: int
    target: str
    filter: str
    kind: str
    exposure_s: float
    ra_deg: float
    dec_deg: float
    width: int
    height: int
    bytes: int
    digest: str
    problems: tuple[str, ...]
    measures: FrameMeasures = FrameMeasures()


class Night(NamedTuple):
    """A night and what it brought."""

    night: str
    frames: int
    bytes: int


class Cone(NamedTuple):
    """A place on the sky (J2000) and how far round it (all in degrees)."""

    ra_deg: float
    dec_deg: float
    radius_deg: float


class Wanted(NamedTuple):
    """What is looked for; empty words and none mean anything."""

    night: str = ""
    target: str = ""
    filter: str = ""
    kind: str = ""
    from_us: int = 0
    to_us: int = 2**62
    cone: Cone | None = None


def row_to_frame(row: RowMapping) -> ArchivedFrame:
    """Read a row of the table."""

    def number(key: str) -> float:
        return math.nan if row[key] is None else float(row[key])

    return ArchivedFrame(
        row["id"],
        row["site"],
        row["device"],
        row["night"],
        row["name"],
        row["time_us"],
        row["target"],
        row["filter"],
        row["kind"],
        number("exposure_s"),
        number("ra_deg"),
        number("dec_deg"),
        row["width"],
        row["height"],
        row["bytes"],
        row["digest"],
        tuple(filter(None, row["problems"].split("\n"))),
        FrameMeasures(
            MeasureState(row["measured"]),
            row["stars"],
            number("fwhm"),
            number("background"),
            number("zero_point"),
            msgspec.json.decode(row["wcs"], type=tuple[float, ...]) if row["wcs"] else (),
            row["measure_note"],
        ),
    )
