"""How a watchdog tells people what it does: at once, for no hub can know of it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from talaia.gateway.notices.own_notices import OwnNotices

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.gateway.notices.settings import NoticeSettings
    from talaia.gateway.ports import EventSink
    from talaia.wire.frames import EnclosureState

__all__ = ["WatchdogNotices"]

TELLER = "Told by the watchdog process beside the site's gateway, which does not answer it."
CLOSES, FAILED = "watchdog", "watchdog_failed"


class WatchdogNotices:
    """A watchdog's own way to people; tells nobody where there are no settings.

    Event loop only. Whatever fails here keeps no roof open: each message is sent beside the
    closing, and is waited for only when there is nothing more to do.
    """

    def __init__(
        self, settings: NoticeSettings | None, site: str, clock: Clock, events: EventSink
    ) -> None:
        """Take the ways, and whose site it is; what was sent, and what failed, goes to events."""
        self._own: OwnNotices | None = None
        self._roofs: list[str] = []
        if settings is not None:
            now = msgspec.structs.replace(settings, after=0.0)
            self._own = OwnNotices(
                settings=now,
                site=site,
                clock=clock,
                linked=lambda: False,
                events=events,
                teller=TELLER,
            )
        self._running: asyncio.Task[None] | None = None

    def begin_sending(self, failures: int, failed: str) -> None:
        """Begin to send; former tries to close failed so often, the last one in this way.

        People are told of the first such failure, the second, the fourth and so on.
        """
        if self._own is None:
            return
        if failures and not failures & (failures - 1):
            times = "once" if failures == 1 else f"{failures} times"
            self._own.raise_notice(
                FAILED,
                "The gateway is dead or stands still, and the watchdog could not close the roof: "
                f"closing ended {times} with an error ({failed}); it is tried again. "
                "Go and look at the roof",
            )
        self._running = asyncio.ensure_future(self._own.run())

    def report_closing(self, roof: str) -> None:
        """Tell that a roof, by its name, is being closed."""
        if self._own is not None and roof not in self._roofs:
            self._roofs.append(roof)
            said = f"The gateway is dead or stands still; the watchdog closes the roof ({roof})"
            self._own.raise_notice(f"{CLOSES} {len(self._roofs)}", said)

    def hear_enclosure(self, state: EnclosureState) -> None:
        """Take how an enclosure stands: NOT CLOSED, or what its sensors disagree about."""
        if self._own is not None:
            self._own.hear_enclosure(state)

    def report_closed(self) -> None:
        """Tell whoever knows of the closing that the sensors say *closed*."""
        if self._own is None:
            return
        for index, roof in enumerate(self._roofs):
            said = f"The watchdog has closed the roof ({roof}), as its sensors say"
            self._own.clear_notice(f"{CLOSES} {index + 1}", f"{said}; the gateway is still away")

    async def send_due(self) -> None:
        """Send what is still to be sent, and wait for it."""
        if self._own is None:
            return
        if self._running is not None:
            self._running.cancel()
            await asyncio.gather(self._running, return_exceptions=True)
        await self._own.send_due()
