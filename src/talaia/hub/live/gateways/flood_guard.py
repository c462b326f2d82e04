"""Slows a gateway that says too much, cuts it off where it goes on, and tells people.

What a site's gateway may say is counted over all its connections: its link, and those for pictures
and for files.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.hub.live.gateways.frame_limits import DIALS, DIALS_BACK, HELD_S, FrameLimits, frame_kind
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.gateways.frame_limits import Verdict
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.sites import LiveSite, Sites
    from talaia.hub.store.sites.site_registry import GatewayKey
    from talaia.wire.message import Message

__all__ = ["HELD_OFF", "TRY_LATER", "FloodGuard"]

_LOG = logging.getLogger(__name__)
HELD_OFF = "this gateway has said more than the hub takes; come back later"
# "Try again later" (the registry of RFC 6455).
TRY_LATER = 1013
# Waited at once, at the most (s): a beat that stands behind a flood is heard all the same.
_LONGEST_WAIT_S = 0.5


class FloodGuard:
    """Stands before whoever reads a connection of a gateway."""

    def __init__(self, sites: Sites, reporting: RobotEvents, clock: Clock) -> None:
        """Tell people of ``sites`` by ``reporting``; ``clock`` refills allowances."""
        self._sites = sites
        self._reporting = reporting
        self._clock = clock
        # Of sites that have a key and have not said yet what they are.
        self._undescribed: dict[str, FrameLimits] = {}

    def held_s(self, key: GatewayKey) -> float:
        """Give for how long a gateway is not let in."""
        return self._limits_of(key.site).held_s(self._clock.monotonic_ns(), key.lineage)

    def begin_link(self, key: GatewayKey, issued: int) -> None:
        """Note that a gateway has the site's place; ``issued`` is the lineage of its place now."""
        self._limits_of(key.site).begin_link(key.lineage, issued)

    def admit_dial(self, key: GatewayKey) -> float:
        """Count a connection that is opened by a site's key; give when to come back (s), or 0.

        Those of who was here before all others are counted apart, so that a thief of the key who
        dials without end does not keep it out.
        """
        limits = self._limits_of(key.site)
        kind = DIALS_BACK if limits.recognise_oldest(key.lineage) else DIALS
        # A connection that is sent away is counted as well: to refuse it costs something, too.
        verdict = limits.charge(kind, self._clock.monotonic_ns())
        if not verdict.slowed:
            return 0.0
        try:
            self._report_flood(key, kind, verdict)
        except PeerError:
            return HELD_S
        return max(1.0, verdict.wait_s)

    async def admit_frame(self, key: GatewayKey, message: Message) -> None:
        """Wait until a frame may be read.

        Raises:
            PeerError: its gateway has gone on too long.

        """
        if wait_s := self.charge_kind(key, frame_kind(message)):
            await asyncio.sleep(wait_s)

    def charge_kind(self, key: GatewayKey, kind: str) -> float:
        """Count a frame of a kind, and give how long it has to wait before it may be read (s).

        Raises:
            PeerError: its gateway has gone on too long.

        """
        live = self._sites.find_site(key.site)
        limits = self._limits_of(key.site)
        # Who has more to say of has a larger allowance.
        described = 0 if live is None else live.described
        verdict = limits.charge(kind, self._clock.monotonic_ns(), described=described)
        wait_s = self._slow_down(key, kind, verdict) if verdict.slowed else 0.0
        # Of the message before: what it wrote into the log.
        # Taken once: it is one wait, whichever connection waits it.
        rows, limits.rows = limits.rows, None
        return wait_s if rows is None else wait_s + self._slow_down(key, "event", rows)

    def _slow_down(self, key: GatewayKey, kind: str, verdict: Verdict) -> float:
        self._report_flood(key, kind, verdict)
        return min(verdict.wait_s, _LONGEST_WAIT_S)

    def _report_flood(self, key: GatewayKey, kind: str, verdict: Verdict) -> None:
        site = key.site
        limits, now_ns = self._limits_of(site), self._clock.monotonic_ns()
        if verdict.cut_off:
            limits.hold(now_ns, key.lineage)
            said = f"it goes on sending too many of {kind}; it is not let in for {HELD_S:g} s"
            self._report(site, "gateway cut off", said)
            raise PeerError(HELD_OFF, TRY_LATER)
        # Once in a while: a flood must not become one of warnings.
        if limits.first_told(now_ns):
            said = f"it sends too many of {kind}; what it says is read more slowly"
            self._report(site, "gateway slowed", said)

    def _report(self, site: str, event: str, said: str) -> None:
        live = self._sites.find_site(site)
        if live is None:
            # It has no pages yet on which people could be told.
            _LOG.warning("%s: %s: %s", site, event, said)
        else:
            self._reporting.report_event(live, event, message=said, good=False)

    def _limits_of(self, site: str) -> FrameLimits:
        live: LiveSite | None = self._sites.find_site(site)
        if live is not None:
            # What it owed before it was described, it owes still.
            live.frame_limits = self._undescribed.pop(site, live.frame_limits)
            return live.frame_limits
        return self._undescribed.setdefault(site, FrameLimits())
