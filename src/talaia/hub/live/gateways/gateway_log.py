"""Writes down what a gateway says, as its word, and counts the rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.audit import Audit, AuditEntry

__all__ = ["GatewayLog"]


class GatewayLog:
    """The audit log, for rows that a site's gateway brings about."""

    def __init__(self, audit: Audit, clock: Clock) -> None:
        """Write into ``audit``; ``clock`` refills the allowance of rows."""
        self._audit = audit
        self._clock = clock

    def append_row(
        self,
        live: LiveSite,
        kind: str,
        who: str,
        *,
        device: str,
        message: str = "",
        good: bool = True,
        source: str = "gateway",
    ) -> AuditEntry:
        """Write a row, and charge it to the site, whose word it may be or not."""
        entry = self._audit.append_record(
            kind, who=who, site=live.name, device=device, message=message, good=good, source=source
        )
        # Whoever reads the link waits by it; the row itself is written.
        verdict = live.frame_limits.charge("rows", self._clock.monotonic_ns())
        if verdict.slowed:
            live.frame_limits.rows = verdict
        return entry
