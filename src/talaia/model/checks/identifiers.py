"""What a single word of a description must look like: names, topics, types, fields, numbers."""

from __future__ import annotations

import math
import re
import unicodedata
from typing import TYPE_CHECKING, NamedTuple

from talaia.model.yaml_text.foreign_letters import alike_letters, with_own_letters

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
    "number_text",
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
_MIDDLES = {"msg": "a message", "srv": "a service", "action": "an action"}


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
        remedy = "use a small letter, then small letters, digits and _ (at most 63)"
        if near := _near_word(word):
            remedy += f": {near}{_told_apart(word)}"
        yield Finding(where, f"{word!r} cannot be a name in an address", remedy)


def _near_word(word: str) -> str:
    """Give a name that can stand in an address and is like ``word``; empty for none."""
    # Letters without their accents; what has no Latin letters is left to who wrote it.
    plain = (
        unicodedata.normalize("NFKD", with_own_letters(word))
        .encode("ascii", "ignore")
        .decode()
        .lower()
    )
    near = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")
    if near[:1].isdigit():
        near = f"n{near}"
    return near if _WORD.match(near) else ""


def _told_apart(word: str) -> str:
    """Say which letter only looks right, where one does."""
    said = alike_letters(word)
    return f";{said}" if said else ""


def name_fits(where: str, name: str) -> Iterator[Finding]:
    """What people read: anything that can be seen."""
    expected = f"expected a name of 1 to {_MAX_NAME} characters"
    # What cannot be seen could make two names look like one.
    unseen = next((letter for letter in name if is_unseen(letter)), "")
    if not name.strip():
        yield Finding(where, f"{expected}, found none", "write what people call it")
    elif len(name) > _MAX_NAME:
        yield Finding(where, f"{expected}, found {len(name)}", "shorten it")
    elif unseen:
        found = "a line end" if unseen == "\n" else f"U+{ord(unseen):04X}"
        remedy = "write it in one line" if unseen == "\n" else "type it anew"
        yield Finding(where, f"{expected} that can all be seen, found {found}", remedy)


def is_unseen(letter: str) -> bool:
    """Control and format characters, line ends and lone surrogates: not seen, yet they mislead."""
    # Control, format (as what turns the direction of writing), surrogate, line end, paragraph end.
    return unicodedata.category(letter) in {"Cc", "Cf", "Cs", "Zl", "Zp"}


def topic_fits(where: str, topic: str) -> Iterator[Finding]:
    """An absolute ROS name."""
    if not topic:
        yield Finding(where, "which topic is meant?", "write it with its slash: topic: /like/this")
    elif not _TOPIC.match(topic):
        # The slash in front is what is missing nearly always.
        # `~` is a node's own name, which nobody here knows.
        plain = with_own_letters(topic).replace(":", "").strip().strip("/")
        near = "/" + re.sub(r"[^A-Za-z0-9_/]+", "_", "" if "~" in plain else plain)
        written = near if _TOPIC.match(near) else "/like/this"
        remedy = f"write it as {written}{_told_apart(topic)}"
        yield Finding(where, f"{topic!r} is not an absolute ROS name", remedy)


def type_fits(where: str, name: str, middle: str) -> Iterator[Finding]:
    """``package/msg/Name`` or ``package/srv/Name``."""
    match = _TYPE.match(name)
    example = f"package_name/{middle}/TypeName"
    if not name:
        yield Finding(where, "which ROS type has it?", f"write: type: {example}")
    elif match and match[1] != middle:
        problem = f"expected the type of {_MIDDLES[middle]}, found that of {_MIDDLES[match[1]]}"
        yield Finding(where, f"{problem}, {name!r}", f"write it as {example}")
    elif not match:
        # As ROS 1, Python or C++ writes it: std_msgs/Bool, std_msgs.msg.Bool, std_msgs::msg::Bool.
        parts = re.split(r"[./:]+", with_own_letters(name))
        if len(parts) == len(("package", middle, "Name")) and parts[2][:1].islower():
            parts[2] = parts[2][:1].upper() + parts[2][1:]
        near = f"{parts[0]}/{middle}/{parts[-1]}"
        written = near if len(parts) in (2, 3) and _TYPE.match(near) else example
        remedy = f"write it as {written}{_told_apart(name)}"
        yield Finding(where, f"{name!r} is not a ROS type", remedy)


def field_fits(where: str, field: str) -> Iterator[Finding]:
    """A path into a message."""
    if not FIELD.match(field):
        # As a path of files is written.
        near = with_own_letters(field).strip("/ .").replace("/", ".").replace(" ", "")
        # An element with a point before it, as in JavaScript's paths and ``jq``.
        near = re.sub(r"\.\[?(\d{1,6})\]?(?=[.\[]|\Z)", r"[\1]", near)
        written = near if FIELD.match(near) else "pose.x or a[0]"
        remedy = f"write it as {written}{_told_apart(field)}"
        yield Finding(where, f"{field!r} is not the path of a field", remedy)


def number_text(value: float) -> str:
    """Write a number as people do: 1 for 1.0, and what is none in words."""
    if math.isnan(value):
        return "what is no number (.nan)"
    if math.isinf(value):
        return "infinity (.inf)"
    return f"{value:.15g}"


def range_fits(where: str, low: float | None, high: float | None) -> Iterator[Finding]:
    """Finite, and the right way round."""
    for key, value in (("minimum", low), ("maximum", high)):
        if value is not None and not math.isfinite(value):
            yield Finding(f"{where}.{key}", f"expected a finite number, found {number_text(value)}")
    if low is not None and high is not None and low >= high:
        yield Finding(
            f"{where}.minimum",
            f"the minimum {low:g} is not below the maximum {high:g}",
            "swap them, or mend one",
        )


def check_above(where: str, value: float, low: float) -> Iterator[Finding]:
    """A finite number greater than ``low``."""
    if not (math.isfinite(value) and value > low):
        yield Finding(where, f"expected a number above {low:g}, found {number_text(value)}")


def at_least(where: str, value: float, low: float) -> Iterator[Finding]:
    """A finite number, ``low`` or more."""
    if not (math.isfinite(value) and value >= low):
        yield Finding(where, f"expected {low:g} or more, found {number_text(value)}")
