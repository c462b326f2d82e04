"""The parts of the hub to which what gateways say is led."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.alarms import Alarms
    from talaia.hub.live.browsers import Browsers
    from talaia.hub.live.changes import Changes
    from talaia.hub.live.detecting import Detecting
    from talaia.hub.live.fanout import Fanout
    from talaia.hub.live.links import Links
    from talaia.hub.live.media import Media
    from talaia.hub.live.recordings import Recordings
    from talaia.hub.live.reporting import Reporting
    from talaia.hub.live.sightings import Sightings
    from talaia.hub.live.sites import Sites
    from talaia.hub.live.uploads import Uploads
    from talaia.hub.live.watching import Watching
    from talaia.hub.ports import History
    from talaia.hub.settings import Settings
    from talaia.hub.store.descriptions import Descriptions
    from talaia.hub.store.sites import SiteRegistry

__all__ = ["Parts"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Parts:
    """What `Gateways` and `Describing` speak to; each takes what it needs.

    Attributes:
        versions: of every site's description.

    """

    sites: Sites
    browsers: Browsers
    fanout: Fanout
    reporting: Reporting
    alarms: Alarms
    sightings: Sightings
    detecting: Detecting
    media: Media
    history: History
    registry: SiteRegistry
    versions: Descriptions
    changes: Changes
    links: Links
    uploads: Uploads
    recordings: Recordings
    watching: Watching
    settings: Settings
    clock: Clock
