"""What a robot says and nobody reads: told in the log, and as an event of the site."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from talaia.gateway.ports import EventSink

__all__ = ["UnreadableReports"]

log = logging.getLogger(__name__)


class UnreadableReports:
    """Reports what cannot be read, and what nobody asks for; any thread."""

    def __init__(self, events: EventSink) -> None:
        """Report to ``events``."""
        self._events = events
        # What was reported already: a topic that is wrong is so with each of its messages.
        self._reported: set[str] = set()

    def report_unreadable(self, address: str, problem: str) -> None:
        """Report a signal or camera by its address; callers do so once."""
        log.warning("%s: %s", address, problem)
        device = address.split("/", 1)[0]
        self._events.report_event("unreadable", f"{address}: {problem}", device=device)

    def report_new_sensor(self, device: str, topic: str, name: str) -> None:
        """Report a sensor that no signal is of; the page offers to add it by this very sentence."""
        sentence = f"{topic}: {name[:100]} is not in the description"
        log.info(sentence)
        self._events.report_event("new_sensor", sentence, device=device, good=True)

    def report_once(self, about: str, problem: str) -> None:
        """Report a topic, or what else is no device's, the first time."""
        if about not in self._reported:
            self._reported.add(about)
            log.warning("%s: %s", about, problem)
            self._events.report_event("unreadable", f"{about}: {problem}")
