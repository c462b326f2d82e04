"""Two gateways with one key: who has the place, who waits, and what people are told.

Whoever is linked stays. Only who shows what the hub itself handed down takes the place: the same
gateway that comes back, or the one that was here before the one that is linked. A true double is
held until the place is free or an admin decides. How a run is called decides nothing.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from talaia.wire.gateway_proof import NO_PLACE

if TYPE_CHECKING:
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.site_state import LinkedGateway, SiteLink
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.sites.site_registry import GatewayKey

__all__ = ["HELD", "KEPT_OUT", "DuplicateGateways", "LinkVerdict", "is_beside_link"]

KEPT_OUT = "another gateway of this site is linked"
HELD = "another gateway of this site is linked; this one waits, and an admin of the hub decides"


class LinkVerdict(Enum):
    """What becomes of a gateway that says hello."""

    TAKES = "it has the place"
    HELD = "another one has the place: it waits"
    KEPT_OUT = "another one has the place, and it is too old to be told that it waits"


class DuplicateGateways:
    """Decides, and tells people once of each rival."""

    def __init__(self, reporting: RobotEvents) -> None:
        """Tell by ``reporting``."""
        self._reporting = reporting

    def judge_link(
        self, live: LiveSite | None, key: GatewayKey, boot: str, link: SiteLink
    ) -> LinkVerdict:
        """Tell whether the gateway of ``key`` may have the site's place now."""
        # A place that is free is had by the key alone: nobody is displaced.
        if live is None or live.link is None or live.rivals.chosen is link:
            return LinkVerdict.TAKES
        if _comes_back(live.gateway, key, boot) or self._was_before(live, key):
            return LinkVerdict.TAKES
        self._publish_rival(live, boot, "another one is linked; the one that came now waits")
        # One of before knows of no waiting: it is told to come again.
        return LinkVerdict.HELD if key.challenged else LinkVerdict.KEPT_OUT

    def record_replacement(self, live: LiveSite, key: GatewayKey, boot: str) -> int:
        """Note that the linked one gives way; give the lineage of who takes its place (0: own)."""
        linked, chosen = live.gateway, live.rivals.chosen is not None
        # None: it begins a line of its own, which is younger than every other.
        own = 0 if key.resumed is None else key.resumed.lineage
        if not chosen and _comes_back(linked, key, boot):
            return own
        # What it was handed down shows nothing any more, however it comes back.
        live.rivals.void_tokens(linked.issued, linked.proven)
        if chosen:
            # It stands in the line of the one that an admin sends away: no less than that one.
            return min(filter(None, (own, linked.issued.lineage)), default=0)
        said = "the one that was here before has come back, and has its place"
        self._publish_rival(live, linked.boot, said)
        return own

    def _was_before(self, live: LiveSite, key: GatewayKey) -> bool:
        """Tell whether a gateway was linked before the one that is linked ever was."""
        # By numbers of the hub alone: nothing that a gateway names itself is looked at.
        linked, shown = live.gateway, key.resumed
        if shown is None or live.rivals.is_void(shown):
            return False
        # One of before has no place of its own; its key alone shows nothing that a thief has not.
        if not linked.challenged or shown.lineage != linked.issued.lineage:
            return not linked.challenged or shown.lineage < linked.issued.lineage
        # A copied disk: the copy knows only of earlier links.
        return shown.serial > linked.proven.serial

    def _publish_rival(self, live: LiveSite, boot: str, message: str) -> None:
        # An admin has decided about this one.
        if boot in live.rivals.settled:
            return
        self._reporting.rival_seen(live)
        if live.rivals.add_boot(boot):
            self._reporting.report_event(live, "second gateway", message=message, good=False)


def _comes_back(linked: LinkedGateway, key: GatewayKey, boot: str) -> bool:
    """Tell whether the gateway of the link that stands dials anew: that link is dead."""
    if not linked.challenged:
        # Two of before: all that there is to know them by.
        return not key.challenged and linked.boot == boot
    if key.resumed is None:
        return False
    # It may have ended before it had the new one on its disk.
    unsaved = not linked.saved and key.resumed == linked.proven
    return key.resumed == linked.issued or unsaved


def is_beside_link(live: LiveSite | None, key: GatewayKey) -> bool:
    """Tell whether a connection for pictures or files is of the gateway that is linked."""
    if live is None or live.link is None:
        return True
    linked = live.gateway
    if not linked.challenged:
        return not key.challenged
    return key.resumed == linked.issued != NO_PLACE
