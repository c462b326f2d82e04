"""The one place that each site has for a gateway: who waits for it, and by what it is shown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.live.gateways.doubles.duplicate_gateways import (
    KEPT_OUT,
    DuplicateGateways,
    LinkVerdict,
)
from talaia.hub.live.gateways.doubles.held_links import MOST_HELD, HeldLinks
from talaia.wire.gateway_proof import NO_PLACE

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.auth.resume_tokens import ResumeTokens
    from talaia.hub.live.gateways.link import GatewayLink
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.site_state import LinkedGateway
    from talaia.hub.live.sites import Sites
    from talaia.hub.store.sites.site_registry import GatewayKey
    from talaia.wire.frames import Hello

__all__ = ["REPLACED", "GatewayPlaces"]

# Codes from 4000 on are left to applications (RFC 6455, 7.4.2).
REPLACED = 4409
# When one is to come back that is too old to wait, or for which there is no room to (s).
KEPT_OUT_AFTER_S = 2.0


class GatewayPlaces:
    """Gives each site's place to one gateway at a time."""

    def __init__(
        self,
        *,
        sites: Sites,
        reporting: RobotEvents,
        resumes: ResumeTokens,
        clock: Clock,
        beat_s: float,
    ) -> None:
        """Tell people by ``reporting``; ``resumes`` number places, and know them again."""
        self._sites = sites
        self._resumes = resumes
        self._rivals = DuplicateGateways(reporting)
        self._held = HeldLinks(reporting, clock, beat_s)

    async def wait_place(
        self, link: GatewayLink, key: GatewayKey, hello: Hello, address: str
    ) -> bool:
        """Wait until a gateway may have its site's place; False: its link has ended."""
        while True:
            # Anew each time: the site may have been described while it waited.
            live = self._sites.find_site(key.site)
            verdict = self._rivals.judge_link(live, key, hello.boot, link)
            if live is None or verdict is LinkVerdict.TAKES:
                return True
            if verdict is LinkVerdict.KEPT_OUT or len(live.rivals.held) >= MOST_HELD:
                await link.send_farewell(KEPT_OUT, REPLACED, KEPT_OUT_AFTER_S)
                return False
            if not await self._held.wait_turn(link, live, hello, address):
                return False

    def assign_place(self, gateway: LinkedGateway, key: GatewayKey) -> None:
        """Number the place that a gateway has from now on."""
        # Who is linked until now; without one the place is taken as it is.
        before = self._sites.find_site(key.site)
        gateway.challenged, gateway.proven = key.challenged, key.resumed or NO_PLACE
        lineage = gateway.proven.lineage
        if before is not None and before.link is not None:
            lineage = self._rivals.record_replacement(before, key, gateway.boot)
        gateway.issued = self._resumes.issue_token(lineage)

    def words_of(self, gateway: LinkedGateway) -> str:
        """Write what a gateway is handed down; empty for one of before, which keeps none."""
        if not gateway.challenged:
            return ""
        return self._resumes.write_token(gateway.id, gateway.issued)
