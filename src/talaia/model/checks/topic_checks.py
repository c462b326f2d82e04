"""Checks of the rules for raw topics."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from talaia.model.checks.identifiers import Finding, at_least, finding_of
from talaia.model.errors import UnknownWord

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.model.site import Site

__all__ = ["topics_findings"]

_MOST_RULES = 200
_MOST_LETTERS = 200
# A part: letters of a name, and the signs of a pattern.
_PART = re.compile(r"[A-Za-z0-9_*?\[\]!~-]+\Z")


def topics_findings(site: Site) -> Iterator[Finding]:
    """Look at each rule: its pattern, its device, its rate."""
    if len(site.topics) > _MOST_RULES:
        yield Finding("$.topics", f"more than {_MOST_RULES} rules", "use patterns")
    seen: set[str] = set()
    for index, rule in enumerate(site.topics):
        where = f"$.topics[{index}]"
        yield from _pattern_fits(f"{where}.pattern", rule.pattern)
        if rule.pattern in seen:
            yield Finding(
                f"{where}.pattern",
                f"{rule.pattern!r} stands in a rule before this one, which counts",
                "leave one of them out",
            )
        seen.add(rule.pattern)
        if rule.device and rule.device not in site.devices:
            error = UnknownWord(f"{where}.device", "device", rule.device, list(site.devices))
            yield finding_of(error)
        yield from at_least(f"{where}.max_rate", rule.max_rate, 0)


def _pattern_fits(where: str, pattern: str) -> Iterator[Finding]:
    parts = pattern.split("/")
    if not pattern.startswith("/") or len(pattern) > _MOST_LETTERS or len(parts) < 2:
        yield Finding(
            where,
            f"{pattern!r} is not the pattern of absolute names",
            "write it as /like/this, /like/* or /like/**",
        )
        return
    for part in parts[1:]:
        if not _PART.match(part):
            yield Finding(
                where, f"{pattern!r} has a part that no name has", "write it as /like/* or /like/**"
            )
            return
        if "**" in part and part != "**":
            yield Finding(
                where, f"in {pattern!r} ** is only a piece of a part", "write it as /like/**"
            )
            return
