"""Whether this gateway really supervises, and who is told so again and again.

systemd, the watchdog process and domes that want a heartbeat are fed only while interlocks are
being judged; a dome only while its sensors can be read, too. Rule 15 of the enclosure's safety: a
gateway that lives and does not look must not keep a roof open.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from typing import TYPE_CHECKING, Protocol

from talaia.clock import SECOND
from talaia.model.arguments import fields_of
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandOutcome, CommandTarget, ControlOutput
    from talaia.gateway.safety.interlocks import Interlocks
    from talaia.model.interlocks.enclosure import Heartbeat
    from talaia.model.site import Site

__all__ = ["Heartbeats", "Supervision", "SupervisionListener"]

log = logging.getLogger(__name__)
# A few looks within the shortest watchdog time that a description may ask for.
LOOK_S = 0.25
# Interlocks are judged ten times a second; a machine that is busy may take this long.
LATEST_NS = 2 * SECOND


class SupervisionListener(Protocol):
    """Whoever wants to know that the gateway supervises."""

    def __call__(self) -> None:
        """Take that it does now."""
        ...


class Heartbeats:
    """Sends the heartbeats of a site's enclosures while they are supervised. Event loop only."""

    def __init__(
        self, site: Site, interlocks: Interlocks, target: CommandTarget, output: ControlOutput
    ) -> None:
        """Take who knows the sensors, who sends, and who writes down."""
        self._site = site  # Replaced by `redescribe`.
        self._interlocks = interlocks  # Says whether an enclosure is blind now.
        self._target = target  # Sends the command to the robot.
        self._output = output  # Told of each change, once.
        # By enclosure. When the last heartbeat was sent (monotonic):
        self._sent_ns: dict[str, int] = {}
        # One at a time: a controller that hangs must not find a heap of old ones later.
        self._open: dict[str, int] = {}
        # What was last told of withholding and of failing, for each is told once.
        self._withheld: dict[str, str] = {}
        self._failed: dict[str, str] = {}

    def redescribe(self, site: Site) -> None:
        """Send by another description from here on."""
        self._site = site

    def send_due(self, now_ns: int) -> None:
        """Send what is due; called only while interlocks are being judged."""
        for name, rule in self._site.enclosures.items():
            if rule.heartbeat is None:
                continue
            why = self._interlocks.enclosures.blind_reason(name, now_ns)
            self._tell_withheld(name, rule.name, why)
            # Withheld, so that a dome with a timer of its own closes: it cannot be supervised now.
            if not why:
                self._send_heartbeat(name, rule.heartbeat, now_ns)

    def _tell_withheld(self, name: str, called: str, why: str) -> None:
        if self._withheld.get(name, "") == why:
            return
        self._withheld[name] = why
        kind = "heartbeat_withheld" if why else "heartbeat_sent_again"
        said = why or "its sensors are read"
        self._output.record_event(kind, "", f"{called}: {said}", "", good=not why)

    def _send_heartbeat(self, name: str, beat: Heartbeat, now_ns: int) -> None:
        sent = self._sent_ns.get(name)
        if sent is not None and now_ns - sent < round(beat.every * SECOND):
            return
        device, _, command_id = beat.command.partition("/")
        command = self._site.devices[device].commands[command_id]
        began = self._open.get(name)
        # Still open and within its time: a second one would wait behind it.
        if began is not None and now_ns - began < round(command.timeout * SECOND):
            return
        # The answer never came; `_open` is overwritten below, so a late one is not counted for the
        # new.
        if began is not None:
            self._tell_failed(name, device, f"{beat.command}: no answer for {command.timeout:g} s")
        fields = fields_of(command, beat.args)
        if isinstance(fields, str):
            self._tell_failed(name, device, fields)
            return
        # One time for both: the answer below is known by the moment of sending.
        self._sent_ns[name] = self._open[name] = now_ns
        loop = asyncio.get_running_loop()

        def done(outcome: CommandOutcome) -> None:
            # The loop may have closed while a robot's thread answered.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._handle_outcome, name, device, now_ns, outcome)

        self._target.act(device, command_id, fields, done)

    def _handle_outcome(
        self, name: str, device: str, sent_ns: int, outcome: CommandOutcome
    ) -> None:
        # Running is no end, and an answer to an older heartbeat is none to this one.
        if outcome.phase is CommandPhase.RUNNING or self._open.get(name) != sent_ns:
            return
        del self._open[name]
        good = outcome.phase is CommandPhase.SUCCEEDED
        self._tell_failed(name, device, "" if good else f"{outcome.phase}: {outcome.message}")

    def _tell_failed(self, name: str, device: str, why: str) -> None:
        if self._failed.get(name, "") == why:
            return
        self._failed[name] = why
        kind = "heartbeat_failed" if why else "heartbeat_taken_again"
        self._output.record_event(kind, device, why, "", good=not why)


class Supervision:
    """Looks four times a second whether the gateway supervises, and tells who watches it."""

    def __init__(
        self,
        clock: Clock,
        judged_ns: Callable[[], int | None],
        watched: tuple[SupervisionListener, ...],
        heartbeats: Heartbeats,
    ) -> None:
        """Take whom to tell.

        Args:
            clock: monotonic.
            judged_ns: when the interlocks were last judged to the end; none where there are none.
            watched: told while it supervises.
            heartbeats: sent while it supervises.

        """
        self._clock = clock  # Monotonic for both questions.
        # None where there is nothing to judge; then only the process itself is watched.
        self._judged_ns = judged_ns
        self._watched = watched  # systemd and the watchdog process, where there are any.
        self._heartbeats = heartbeats  # Sent only from here, so that they stop with the judging.
        # When this looked last: a look that comes late means that the whole process stood still.
        self._looked_ns = clock.monotonic_ns()
        # What was found then, so that the log has each change once.
        self._well = True

    def check_supervision(self) -> bool:
        """Tell everybody if it supervises; give whether it does."""
        now = self._clock.monotonic_ns()
        # This look itself was late: nobody may be told of a moment in which we did not run.
        late = now - self._looked_ns > LATEST_NS
        self._looked_ns = now
        judged = self._judged_ns()
        stands = judged is not None and now - judged > LATEST_NS
        well = not late and not stands
        if well != self._well:
            self._well = well
            if stands:
                log.error("interlocks are not being judged: nobody is told that all is well")
        if well:
            for watched in self._watched:
                watched()
            self._heartbeats.send_due(now)
        return well

    async def run(self) -> None:
        """Go on until cancelled."""
        while True:
            self.check_supervision()
            await asyncio.sleep(LOOK_S)
