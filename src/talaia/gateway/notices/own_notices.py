"""Tells people of what is critical while the hub is away; and ``talaia gateway test-notice``."""

from __future__ import annotations

import argparse
import asyncio
import logging
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from talaia.errors import TalaiaError
from talaia.gateway.notices.sending import send_notice
from talaia.gateway.notices.settings import read_notice_settings
from talaia.gateway.notices.standing_notices import HUB_AWAY, GatewayNotice, StandingNotices

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from talaia.clock import Clock
    from talaia.gateway.notices.settings import NoticeSettings
    from talaia.gateway.ports import EventSink
    from talaia.wire.frames import EnclosureState

__all__ = ["OwnNotices", "main"]

log = logging.getLogger(__name__)
LOOK_S = 0.5  # Between two looks at what is due.


class OwnNotices:
    """The gateway's own notices. Event loop only."""

    def __init__(
        self,
        *,
        settings: NoticeSettings,
        site: str,
        clock: Clock,
        linked: Callable[[], bool],
        events: EventSink,
        teller: str = HUB_AWAY,
    ) -> None:
        """Tell nothing while ``linked``; what was told, and what failed, goes to ``events``.

        ``teller`` is the sentence that says who tells.
        """
        self._settings = settings
        self._site = site
        self._clock = clock
        self._linked = linked  # Whether the hub has a link now; asked at each look.
        self._events = events
        # What stands, and when it is told next.
        self._standing = StandingNotices(settings, teller)
        # Held here, for asyncio alone would let them go; `send_due` waits for them.
        self._sending: set[asyncio.Task[None]] = set()

    def hear_enclosure(self, state: EnclosureState) -> None:
        """Take how an enclosure stands."""
        if state.why:
            self.raise_notice(state.enclosure, state.why)
        else:
            self.clear_notice(state.enclosure)

    def raise_notice(self, what: str, message: str) -> None:
        """Take that something critical stands, or stands in other words."""
        # Monotonic for what is due; wall time for people.
        now = self._clock.monotonic_ns()
        self._standing.raise_notice(what, message, self._clock.wall_ns() // 1000, now)

    def clear_notice(self, what: str, message: str = "") -> None:
        """Take that it stands no longer; ``message`` says what has become of it."""
        self._standing.clear_notice(what, self._clock.wall_ns() // 1000, message)

    async def run(self) -> None:
        """Go on until cancelled."""
        while True:
            self._send_due()
            await asyncio.sleep(LOOK_S)

    async def send_due(self) -> None:
        """Send what is due, and wait until each way has taken it or failed."""
        self._send_due()
        await asyncio.gather(*self._sending)

    def _send_due(self) -> None:
        for notice in self._standing.due_notices(self._clock.monotonic_ns(), linked=self._linked()):
            task = asyncio.ensure_future(self._send_everywhere(notice))
            self._sending.add(task)
            task.add_done_callback(self._sending.discard)

    async def _send_everywhere(self, notice: GatewayNotice) -> None:
        outcomes = await send_notice(self._settings, self._site, notice)
        for way, problem in outcomes.items():
            good = not problem
            kind = "notice_sent" if good else "notice_failed"
            said = f"{way}: {problem or notice.message}"
            # What failed is a warning: people were not told.
            log.log(logging.INFO if good else logging.WARNING, "%s %s", kind, said)
            self._events.report_event(kind, said, good=good)


def main(argv: Sequence[str]) -> int:
    """Send a test notice by every way; 0 when all arrived, 1 when one did not, 2 for bad words."""
    parser = argparse.ArgumentParser(
        prog="talaia gateway test-notice",
        description="Send a test by every way of a notices file, and say what became of it.",
    )
    parser.add_argument("file", type=Path, help="the notices (TOML)")
    parser.add_argument("--site", default="test", help="the name that the message says (test)")
    options = parser.parse_args(argv)
    now_us = time.time_ns() // 1000
    notice = GatewayNotice(f"test-{now_us}", "test", "a test notice; nothing is wrong", now_us)
    try:
        settings = read_notice_settings(options.file)
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway: {error}\n")
        return 2
    outcomes = asyncio.run(send_notice(settings, options.site, notice))
    for way, problem in outcomes.items():
        sys.stdout.write(f"{way}: {problem or 'sent'}\n")
    return 1 if any(outcomes.values()) else 0
