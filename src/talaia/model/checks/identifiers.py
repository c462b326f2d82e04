"""What a single word of a description must look like: names, topics, types, fields, numbers."""

from __future__ import annotations

import math
import re
import unicodedata
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.errors import DescriptionError

__all__ = [
    "FIELD",
    "Finding",
    "at_least",
    "check_above",
    "field_fits",
    "finding_of",
    "id_fits",
    "is_unseen",
    "name_fits",
    "range_fits",
    "topic_fits",
    "type_fits",
]

# Here and below ``\Z``, not ``$``: before that a line end could stand.
_WORD = re.compile(r"[a-z][a-z0-9_]{0,62}\Z")
_TOPIC = re.compile(r"/[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*\Z")
_TYPE = re.compile(r"[a-z][a-z0-9_]*/(msg|srv|action)/[A-Z][A-Za-z0-9]*\Z")
FIELD = re.compile(
    r"([A-Za-z][A-Za-z0-9_]*(\[\d{1,6}\])*)(\.[A-Za-z][A-Za-z0-9_]*(\[\d{1,6}\])*)*\Z"
)
_MAX_NAME = 100


class Finding(NamedTuple):
    """One thing that does not fit: where, what, and what to do."""

    where: str
    problem: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.where}: {self.problem}" + (f"; {self.remedy}" if self.remedy else "")


def finding_of(error: DescriptionError) -> Finding:
    """Give the finding that says what an error says."""
    return Finding(error.where, error.problem, error.remedy)


def id_fits(where: str, word: str) -> Iterator[Finding]:
    """An address is made of such words, so they are narrow."""
    if not _WORD.match(word):
        yield Finding(
            where,
            f"{word!r} cannot be a name in an address",
            "use a small letter, then small letters, digits and _ (at most 63)",
        )


def name_fits(where: str, name: str) -> Iterator[Finding]:
    """What people read: anything that can be seen."""
    # What cannot be seen could make two names look like one.
    if not name.strip() or len(name) > _MAX_NAME or any(map(is_unseen, name)):
        yield Finding(
            where, f"expected a name of 1 to {_MAX_NAME} characters", "that can all be seen"
        )


def is_unseen(letter: str) -> bool:
    """Control and format characters, line ends and lone surrogates: not seen, yet they mislead."""
    # Control, format (as what turns the direction of writing), surrogate, line end, paragraph end.
    return unicodedata.category(letter) in {"Cc", "Cf", "Cs", "Zl", "Zp"}


def topic_fits(where: str, topic: str) -> Iterator[Finding]:
    """An absolute ROS name."""
    if not _TOPIC.match(topic):
        yield Finding(where, f"{topic!r} is not an absolute ROS name", "write it as /like/this")


def type_fits(where: str, name: str, middle: str) -> Iterator[Finding]:
    """``package/msg/Name`` or ``package/srv/Name``."""
    match = _TYPE.match(name)
    if not match or match[1] != middle:
        yield Finding(
            where, f"{name!r} is not a ROS type", f"write it as package_name/{middle}/TypeName"
        )


def field_fits(where: str, field: str) -> Iterator[Finding]:
    """A path into a message."""
    if not FIELD.match(field):
        yield Finding(where, f"{field!r} is not the path of a field", "write it as pose.x or a[0]")


def range_fits(where: str, low: float | None, high: float | None) -> Iterator[Finding]:
    """Finite, and the right way round."""
    for key, value in (("minimum", low), ("maximum", high)):
        if value is not None and not math.isfinite(value):
            yield Finding(f"{where}.{key}", f"expected a finite number, found {value}")
    if low is not None and high is not None and low >= high:
        yield Finding(f"{where}.minimum", f"the minimum {low} is not below the maximum {high}")


def check_above(where: str, value: float, low: float) -> Iterator[Finding]:
    """A finite number greater than ``low``."""
    if not (math.isfinite(value) and value > low):
        yield Finding(where, f"expected a number above {low}, found {value}")


def at_least(where: str, value: float, low: float) -> Iterator[Finding]:
    """A finite number, ``low`` or more."""
    if not (math.isfinite(value) and value >= low):
        yield Finding(where, f"expected {low} or more, found {value}")
