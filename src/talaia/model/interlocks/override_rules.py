"""Which conditions of an interlock may be overridden, and for how long. Pure.

Never: rain, a switch with which somebody on site has taken over, and a link that is lost. A
description says so with ``override: never``; besides, a condition is taken for one of these by

- ``link_lost``;
- a signal whose unit is a rate of rain (``mm/h``, ``mm/min``, ``in/h``);
- a state that makes it unsafe: *rain*, *raining*, *wet*, *snow*, *hail*, *drizzle* and words that
  begin so; *local*, *manual*, *on site*, *maintenance*;
- a signal whose id or name has a word that begins with *rain*, *precip*, *drizzl*, *snow* or
  *hail*, or is *wet* or *wetness*; or is *local* or *on_site*.

There is no way to say that one of these may be overridden: mistaken for rain is mistaken safely.
"""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING

from talaia.model.interlocks.interlock import Overriding

if TYPE_CHECKING:
    from talaia.model.interlocks.interlock import Condition, Interlock
    from talaia.model.site import Site

__all__ = [
    "LONGEST_OVERRIDE_S",
    "condition_id",
    "condition_label",
    "longest_override",
    "never_overridden",
]

# Whatever a description says.
LONGEST_OVERRIDE_S = 1800.0
# A litre a square metre is a millimetre of rain.
_RAIN_UNIT = re.compile(r"(mm|in|inch|l/m²|l/m2)\s*/\s*(h|hr|hour|min)")
_RAIN_BEGINS = ("rain", "precip", "drizzl", "snow", "hail")
_WET = frozenset({"wet", "wetness"})
_ON_SITE = frozenset({"local", "manual", "onsite", "maintenance"})
_WORDS = re.compile(r"[^\W_]+")
# In an id or a name *manual* and *maintenance* say too little.
_ON_SITE_NAMES = frozenset({"local", "onsite"})


def longest_override(rule: Interlock) -> float:
    """Give for how long an interlock may be overridden (s); 0 for never."""
    return min(rule.longest_override, LONGEST_OVERRIDE_S)


def condition_id(condition: Condition) -> str:
    """Name a condition within its interlock: what it looks at. Limits of one signal are one."""
    if condition.all_of:
        # As long as a `Word` of the wire.
        return "+".join(condition_id(part) for part in condition.all_of)[:200]
    if condition.sun is not None:
        return "sun"
    if condition.signal:
        # Two zones of one position are two conditions: who overrides one is kept by the other.
        zone = f"zone:{condition.zone}" if condition.zone else ""
        looked_at = condition.signal, condition.minus, condition.humidity, zone
        return "+".join(filter(None, looked_at))[:200]
    return "link" if condition.link_lost is not None else "other"


def condition_label(site: Site, name: str) -> str:
    """Say what a condition looks at, as people call it."""
    said = []
    for part in name.split("+"):
        device, _, signal = part.partition("/")
        described = site.devices[device].signals.get(signal) if device in site.devices else None
        zone = part.removeprefix("zone:")
        if zone != part and site.map is not None and zone in site.map.zones:
            said.append(site.map.zones[zone].name)
            continue
        said.append(part if described is None else described.name)
    return " and ".join(said)


def never_overridden(site: Site, condition: Condition) -> str:
    """Say why a condition is never overridden; empty when it may be."""
    if condition.override is Overriding.NEVER:
        return "it is described as never to be overridden"
    if condition.link_lost is not None:
        return "a lost link is never overridden"
    for part in condition.all_of:
        if never := never_overridden(site, part):
            return never
    device, _, name = condition.signal.partition("/")
    described = site.devices[device].signals.get(name) if device in site.devices else None
    if described is None:
        return ""
    # Those that are named, and with ``is_not`` all the others.
    unsafe = set(condition.is_one_of)
    if condition.is_not:
        unsafe |= set(described.states) - set(condition.is_not)
    states = [_state_words(reason) for reason in unsafe]
    names = _state_words(name) | _state_words(described.name)
    if _RAIN_UNIT.fullmatch(described.unit.strip().casefold()) or _is_rain(names.union(*states)):
        return "rain is never overridden"
    if names & _ON_SITE_NAMES or any(words & _ON_SITE for words in states):
        return "somebody on site is never overridden"
    return ""


def _state_words(text: str) -> set[str]:
    words = [word.casefold() for word in _WORDS.findall(text)]
    # *on site* and *on_site* are one word.
    return {*words, *(a + b for a, b in pairwise(words) if a == "on")}


def _is_rain(words: set[str]) -> bool:
    return bool(words & _WET) or any(word.startswith(_RAIN_BEGINS) for word in words)
