"""Paths into JSON: ``a.b[0]``, ``$.a['odd key']``; a few steps of RFC 9535, and no search. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding
from talaia.model.errors import DescriptionError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["json_path_fits", "parse_json_path"]

_MAX_LENGTH = 500
_MAX_STEPS = 50
_REMEDY = "write it as a.b, a.b[0] or a['odd key']"
# Names as devices have them, SHT3X-44 among them; others stand in quotes.
_STEP = re.compile(
    r"""\.?(?P<name>[A-Za-z_][A-Za-z0-9_-]{0,199})
    |\[(?P<index>\d{1,6})\]
    |\[(?P<quote>['"])(?P<key>[^'"\[\]\n]{1,200})(?P=quote)\]""",
    re.VERBOSE,
)


def parse_json_path(path: str) -> tuple[str | int, ...]:
    """Cut a path into keys and indexes; none of the empty one, which is the whole.

    Raises:
        DescriptionError: it is no path.

    """
    if len(path) > _MAX_LENGTH:
        raise DescriptionError(path[:80], f"is longer than {_MAX_LENGTH} letters", _REMEDY)
    # RFC 9535 begins with the root; most people leave it out.
    rest = path[1:] if path.startswith("$") else path
    steps: list[str | int] = []
    at = 0
    while at < len(rest):
        found = _STEP.match(rest, at)
        # A name without a point is the first, and only where no root was written.
        first = at == 0 and rest is path
        if found is None or (found["name"] and (rest[at] == ".") is first):
            raise DescriptionError(path, "is not a path into JSON", _REMEDY)
        steps.append(int(found["index"]) if found["index"] else found["name"] or found["key"])
        at = found.end()
    if len(steps) > _MAX_STEPS:
        raise DescriptionError(path[:80], f"has more than {_MAX_STEPS} steps", _REMEDY)
    return tuple(steps)


def json_path_fits(where: str, path: str) -> Iterator[Finding]:
    """Judge a path into JSON."""
    try:
        parse_json_path(path)
    except DescriptionError as error:
        yield Finding(where, f"{error.where!r} {error.problem}", error.remedy)
