"""Two gateways with one identity: the same one stays every time, and people are told.

Of two, the one whose run began later stays, however often and in whatever order they dial: names
of runs rise with time. One that no longer answers is none, and is gone after three beats.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.sites import LiveSite

__all__ = ["KEPT_OUT", "DuplicateGateways"]

KEPT_OUT = "another gateway of this site, started later, is linked"


class DuplicateGateways:
    """Decides, and raises the alarm once for each rival: the loser goes on dialling."""

    def __init__(self, reporting: RobotEvents) -> None:
        """Tell by ``reporting``."""
        self._reporting = reporting

    def keeps_out(self, live: LiveSite | None, boot: str) -> bool:
        """Tell whether the run ``boot`` must leave the site to the one that is linked."""
        # The same run again is no rival: its former link is dead, and is replaced.
        if live is None or live.link is None or boot >= live.gateway.boot:
            return False
        self._publish_rival(live, boot, "the one that was started earlier is kept out")
        return True

    def record_replacement(self, live: LiveSite, by: str) -> None:
        """Note that the linked run gives way; one that dials anew is no other."""
        if live.gateway.boot != by:
            self._publish_rival(live, live.gateway.boot, "the one that was started later was taken")

    def _publish_rival(self, live: LiveSite, boot: str, message: str) -> None:
        self._reporting.rival_seen(live)
        if live.rivals.add_boot(boot):
            self._reporting.report_event(live, "second gateway", message=message, good=False)
