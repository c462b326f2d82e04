"""Who sees that this gateway really supervises: service manager, watchdog, roof controllers."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.safety.supervision import Heartbeats, Supervision
from talaia.gateway.watchdog.feeding import WatchdogClient
from talaia.model.yaml_text.load import dump_site
from talaia.wire.frames import Event

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.assembly.actuation import ActuationPart
    from talaia.gateway.assembly.adapters import AdaptersPart
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.watchdog.closing import WatchdogRecord
    from talaia.model.site import Site
    from talaia.service_manager import ServiceManager

__all__ = ["SupervisionPart"]

log = logging.getLogger(__name__)
KEEP_S = 1.0


class SupervisionPart(GatewayPart):
    """Told in time while interlocks are judged; a watchdog closes the roof when they are not.

    Attributes:
        watchdog: a process beside this one.
        heartbeats: to controllers of roofs that close by themselves without them.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        adapters: AdaptersPart,
        actuation: ActuationPart,
        manager: ServiceManager,
    ) -> None:
        """Start no process yet."""
        self._base = base
        settings, begun = base.settings, description.current.now
        interlocks, output = actuation.actuation.interlocks, adapters.output
        # Its own process: it must outlive this one to close the roof for it.
        self.watchdog = WatchdogClient(
            data=settings.data,
            folder=settings.folder,
            domain=settings.domain,
            # Told as an event: without a watchdog nobody closes the roof when this process dies.
            trouble=lambda why: output.record_event("watchdog_missing", "", why, "", good=False),
            notices=settings.notices,
        )
        self.watchdog.watch_site(begun.site, begun.said)
        self.heartbeats = Heartbeats(
            site=description.site,
            interlocks=interlocks,
            target=adapters.adapter,
            output=output,
        )
        self._supervision = Supervision(
            clock=base.clock,
            # The moment of the last judgement: beats stop when interlocks are judged no more.
            judged_ns=lambda: interlocks.judged_ns,
            # Both by the same proof: a process that runs and does not judge feeds neither.
            watched=(manager.feed_watchdog, self.watchdog.send_beat),
            heartbeats=self.heartbeats,
        )

    def redescribe(self, site: Site) -> None:
        """Send heartbeats, and have the watchdog close roofs, by another description."""
        self.heartbeats.redescribe(site)
        self.watchdog.watch_site(site, dump_site(site))

    async def take_over(self) -> None:
        """End the watchdog of an earlier run: two must never move a roof."""
        # Its records are of a time when nobody else could tell the hub.
        self._report_records(await self.watchdog.take_over())

    async def say_goodbye(self) -> None:
        """End the watchdog: this gateway ends as it was asked to."""
        await self.watchdog.end_process()

    def leave_watchdog(self) -> None:
        """Leave the watchdog to the gateway that follows, which takes over from it in time."""
        self.watchdog.let_go()

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Tell while it supervises, and keep the watchdog alive."""
        return {"supervise": self._supervision.run, "watchdog": self._keep_watchdog}

    async def _keep_watchdog(self) -> None:
        """Have a watchdog, and report what it did while this gateway stood still."""
        while True:
            await self.watchdog.keep_running(self._base.clock.monotonic_ns() / SECOND)
            # A watchdog that acted while we stood still has written down what it did.
            self._report_records(self.watchdog.take_records())
            await asyncio.sleep(KEEP_S)

    def _report_records(self, records: list[WatchdogRecord]) -> None:
        for record in records:
            log.warning("%s %s", record.kind, record.message)
            self._base.lanes.send(
                Event(
                    kind=record.kind,
                    message=record.message[:2000],
                    time_us=record.time_us,
                    good=record.good,
                )
            )
