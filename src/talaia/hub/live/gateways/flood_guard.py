"""Slows a gateway that says too much, cuts it off where it goes on, and tells people."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.hub.live.gateways.frame_limits import HELD_S, frame_kind
from talaia.wire.errors import PeerError

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.gateways.frame_limits import Verdict
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.frames import FromGateway

__all__ = ["HELD_OFF", "FloodGuard"]

HELD_OFF = "this gateway has said more than the hub takes; come back later"
# "Try again later" (the registry of RFC 6455).
_TRY_LATER = 1013
# When to come back if only the log has no room for it (s).
_ROWS_OVER_S = 10.0
# Waited at once, at the most (s): a beat that stands behind a flood is heard all the same.
_LONGEST_WAIT_S = 0.5


class FloodGuard:
    """Stands before whoever reads a link."""

    def __init__(self, reporting: RobotEvents, clock: Clock) -> None:
        """Tell people by ``reporting``; ``clock`` refills allowances."""
        self._reporting = reporting
        self._clock = clock

    def held_s(self, live: LiveSite | None) -> float:
        """Give for how long nobody is let in by the key of a site."""
        if live is None:
            return 0.0
        now_ns = self._clock.monotonic_ns()
        # Comings and goings are written down as well: one that dials without end fills the log.
        over = live.frame_limits.is_over("rows", now_ns)
        return max(live.frame_limits.held_s(now_ns), _ROWS_OVER_S if over else 0.0)

    async def admit_frame(self, live: LiveSite, message: FromGateway) -> None:
        """Wait until a frame may be read.

        Raises:
            PeerError: its gateway has gone on too long.

        """
        limits = live.frame_limits
        kind = frame_kind(message)
        now_ns = self._clock.monotonic_ns()
        verdict = limits.charge(kind, now_ns, described=live.described)
        if verdict.slowed:
            await self._slow_down(live, kind, verdict)
        # Of the message before: what it wrote into the log.
        rows, limits.rows = limits.rows, None
        if rows is not None:
            await self._slow_down(live, "event", rows)

    async def _slow_down(self, live: LiveSite, kind: str, verdict: Verdict) -> None:
        limits, now_ns = live.frame_limits, self._clock.monotonic_ns()
        if verdict.cut_off:
            limits.hold(now_ns)
            said = f"it goes on sending too many of {kind}; nobody is let in for {HELD_S:g} s"
            self._reporting.report_event(live, "gateway cut off", message=said, good=False)
            raise PeerError(HELD_OFF, _TRY_LATER)
        if limits.first_told(now_ns):
            said = f"it sends too many of {kind}; what it says is read more slowly"
            self._reporting.report_event(live, "gateway slowed", message=said, good=False)
        await asyncio.sleep(min(verdict.wait_s, _LONGEST_WAIT_S))
