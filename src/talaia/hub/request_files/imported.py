"""What the readers of other programs' files have in common: what was read, and what was not."""

from __future__ import annotations

import math
import re
from datetime import UTC, tzinfo
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.model.observing.requests import Configuration, Constraints, Request, Window

if TYPE_CHECKING:
    from collections.abc import Iterable

    from talaia.model.observing.requests import RequestGroup
    from talaia.model.observing.targets import Target

__all__ = [
    "FileProblem",
    "ImportDefaults",
    "ImportedGroups",
    "Misread",
    "make_request",
    "read_angle",
    "read_declination",
    "read_number",
    "read_right_ascension",
]

# Of what no row has yet.
NEW = "new"
# Hours, minutes and seconds (or degrees) apart by colons, spaces or their letters.
_SEXAGESIMAL = re.compile(
    r"([+-]?)(\d{1,3})\s*[:hHdD°\s]\s*(\d{1,2})\s*(?:[:mM'′\s]\s*(\d{1,2}(?:\.\d*)?)\s*[sS\"″]?)?"
    r"\s*[mM'′]?"
)


class Misread(Exception):
    """A part of a file that cannot be read; ``where`` it is, and what is wrong there."""

    def __init__(self, where: str, message: str) -> None:
        """Keep place and reason apart."""
        super().__init__(where, message)
        self.where = where
        self.message = message

    def __str__(self) -> str:
        return f"{self.where}: {self.message}"


class FileProblem(NamedTuple):
    """What could not be read of a file: a line or a path, what was expected and found."""

    where: str
    message: str


class ImportedGroups(NamedTuple):
    """What a file holds.

    Attributes:
        groups: as far as they could be read; their ids and requesters are not meant.
        problems: what could not be read; that part is in no group.

    """

    groups: list[RequestGroup]
    problems: list[FileProblem]


class ImportDefaults(NamedTuple):
    """What stands in where a file says nothing.

    Attributes:
        proposal: whose requests they are.
        window: when they may be observed.
        configurations: what is taken.
        constraints: under which conditions.
        zone: the site's time zone, for times that are written without one by a program that goes
            by its observatory's.

    """

    proposal: str
    window: Window
    configurations: tuple[Configuration, ...] = (Configuration(exposure=60.0),)
    constraints: Constraints = Constraints()
    zone: tzinfo = UTC


def make_request(
    where: str,
    target: Target | None,
    *,
    configurations: Iterable[Configuration],
    constraints: Constraints,
    windows: Iterable[Window],
) -> Request:
    """Make a request, held against the bounds of its fields.

    Raises:
        Misread: a value is out of its bounds; says which.

    """
    made = Request(
        id=NEW,
        target=target,
        configurations=tuple(configurations),
        constraints=constraints,
        windows=tuple(windows),
    )
    try:
        # Values that are built here are not checked; those that are read are.
        return msgspec.convert(msgspec.to_builtins(made), Request)
    except msgspec.ValidationError as error:
        raise Misread(where, str(error)) from error


def read_number(where: str, text: object) -> float:
    """Read a number that is one.

    Raises:
        Misread: it is none, or not finite.

    """
    try:
        value = float(text)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    # `float` reads digits of other scripts, too.
    strange = isinstance(text, bool) or (isinstance(text, str) and not text.isascii())
    if strange or not math.isfinite(value):
        raise Misread(where, f"expected a number, found {_shown(text)}")
    return value


def read_angle(where: str, said: object) -> float | None:
    """Read an angle on the sky, from north through east (-360 to 360°); None: nothing is said.

    Raises:
        Misread: it is none, or out of its bounds.

    """
    if said is None or said == "":
        return None
    degrees = read_number(where, said)
    if not -360.0 <= degrees <= 360.0:
        raise Misread(where, f"expected -360 to 360°, found {_shown(said)}")
    return degrees % 360.0


def read_right_ascension(where: str, text: str) -> float:
    """Read ``05:35:17.3`` (h) or ``83.82`` (°); gives degrees.

    Raises:
        Misread: it is neither, or out of 0 to 24 h.

    """
    found = _sexagesimal(text)
    degrees = found * 15.0 if found is not None else read_number(where, text)
    if not 0.0 <= degrees < 360.0:
        raise Misread(where, f"expected 0 to 24 h (or 0 to 360°), found {_shown(text)}")
    return degrees


def read_declination(where: str, text: str) -> float:
    """Read ``-05:23:28`` or ``-5.39`` (°).

    Raises:
        Misread: it is neither, or out of -90 to 90.

    """
    found = _sexagesimal(text)
    degrees = found if found is not None else read_number(where, text)
    if not -90.0 <= degrees <= 90.0:
        raise Misread(where, f"expected -90 to 90°, found {_shown(text)}")
    return degrees


def _sexagesimal(text: str) -> float | None:
    match = _SEXAGESIMAL.fullmatch(text.strip().replace("−", "-"))
    if match is None or (not text.isascii() and not any(mark in text for mark in "°′″−")):
        return None
    sign, whole, minutes, seconds = match.groups()
    if int(minutes) >= 60 or float(seconds or 0.0) >= 60.0:
        return None
    value = int(whole) + int(minutes) / 60.0 + float(seconds or 0.0) / 3600.0
    # The sign counts for -00:30, too.
    return -value if sign == "-" else value


def _shown(text: object) -> str:
    return repr(text)[:60]
