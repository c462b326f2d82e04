"""How many sightings of a site are taken, and what is said of them. Pure."""

from __future__ import annotations

import datetime as dt
from typing import TYPE_CHECKING, NamedTuple
from zoneinfo import ZoneInfo

import msgspec

from talaia.hub.store.safe_text import safe_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.hub.store.sites.sightings import Sighted
    from talaia.model.detection import Detect
    from talaia.model.site import Site, Stream
    from talaia.wire.frames import SightingReport

__all__ = [
    "Key",
    "KnownSighting",
    "SiteSightings",
    "detect_of",
    "merge_sightings",
    "said_of",
    "story_text",
]

# Of one site: so many may begin, or show another picture, at once, and then so many a second.
# A gateway that was away tells a few hundred at once.
_BURST, _A_SECOND = 1000, 5.0
# Of one site, in sight and waiting; more is nothing that a person could follow.
_MOST_OPEN = 500
# Zones, and lines, that are told of one sighting: the table holds 8 000 letters.
_MOST_TOLD = 8
# After so long without one left out it is said that it is over (s).
_CALM_S = 60.0

# Site, camera, label, and when it began (µs, UTC).
Key = tuple[str, str, str, int]


class KnownSighting(NamedTuple):
    """A sighting that is kept, and its number."""

    sighted: Sighted
    id: int


class SiteSightings:
    """What is known of one site.

    Attributes:
        open: what is in sight.
        asked_s: when its gateway came; 0 once what it has not spoken of is ended.

    """

    def __init__(self, now_s: float) -> None:
        """Begin with nothing in sight."""
        self.open: dict[Key, KnownSighting] = {}
        self.asked_s = 0.0
        # What may still begin, and when that was last reckoned (monotonic, s).
        self._credit, self._since_s = float(_BURST), now_s
        # How many were left out since it was last calm, and when the last was (monotonic, s).
        self._left_out, self._left_out_s = 0, 0.0

    def takes_more(self, waiting: int, now_s: float) -> bool:
        """Tell whether another one may begin beside those that wait to be written."""
        return len(self.open) + waiting < _MOST_OPEN and self.spend_token(now_s)

    def spend_token(self, now_s: float) -> bool:
        """Take one from what may come, if there is one."""
        # A token bucket: it fills again with time.
        self._credit = min(_BURST, self._credit + (now_s - self._since_s) * _A_SECOND)
        self._since_s = now_s
        if self._credit < 1:
            return False
        self._credit -= 1
        return True

    def leaves_out(self, now_s: float) -> bool:
        """Count what is not kept; tell whether it is the first since all was well."""
        self._left_out += 1
        self._left_out_s = now_s
        # Only the first is logged.
        return self._left_out == 1

    def calm_again(self, now_s: float) -> int:
        """Tell, once all is well again, how many were not kept."""
        were = self._left_out
        if not were or now_s - self._left_out_s <= _CALM_S:
            return 0
        self._left_out = 0
        return were


def detect_of(site: Site, camera: str) -> Detect | None:
    """Give what is looked for on a camera."""
    found = _find_stream(site, camera)
    return found.detect if found else None


def merge_sightings(
    older: Mapping[Key, Sighted], newer: Mapping[Key, Sighted]
) -> dict[Key, Sighted]:
    """Take the newer word on each; a picture stays until there is another."""
    found = dict(older)
    for key, sighting in newer.items():
        before = found.get(key)
        # A picture is sent once: later words on the same sighting come without.
        keeps = before is not None and not sighting.picture
        found[key] = sighting._replace(picture=before.picture) if before and keeps else sighting
    return found


def story_text(seen: SightingReport) -> str:
    """Write what a thing did as JSON, within what the table holds; empty where nothing is told."""
    if not (seen.path or seen.stays or seen.crossings or seen.speed is not None):
        return ""
    story = {
        "path": [{"time_us": us, "x": round(x, 3), "y": round(y, 3)} for us, x, y in seen.path],
        "stays": [
            {"zone": safe_text(one.zone, 100), "entries": one.entries, "dwell_s": one.dwell_s}
            for one in seen.stays[:_MOST_TOLD]
        ],
        "crossings": [
            {"line": safe_text(one.line, 100), "left": one.left, "right": one.right}
            for one in seen.crossings[:_MOST_TOLD]
        ],
        "speed": seen.speed,
    }
    return msgspec.json.encode(story).decode()


def said_of(sighted: Sighted, site: Site | None) -> str:
    """Say what is over: ``person seen at Front camera 14:02–14:05 (at most 2)``."""
    found = _find_stream(site, sighted.camera) if site else None
    name = found.name if found else sighted.camera
    when = _format_span(sighted.began_us, sighted.ended_us, site.zone if site else "UTC")
    most = f" (at most {sighted.many})" if sighted.many > 1 else ""
    return safe_text(f"{sighted.label} seen at {name} {when}{most}", 500)


def _find_stream(site: Site, camera: str) -> Stream | None:
    device, _, stream = camera.partition("/")
    described = site.devices.get(device)
    return described.streams.get(stream) if described else None


def _format_span(began_us: int, ended_us: int, zone: str) -> str:
    """Say from when to when, in the site's time: ``14:02–14:05``."""
    began, ended = (
        dt.datetime.fromtimestamp(time_us / 1e6, ZoneInfo(zone)) for time_us in (began_us, ended_us)
    )
    if began.date() != ended.date():
        return f"{began:%Y-%m-%d %H:%M}–{ended:%Y-%m-%d %H:%M}"
    if (began.hour, began.minute) == (ended.hour, ended.minute):
        return f"{began:%H:%M}"
    return f"{began:%H:%M}–{ended:%H:%M}"
