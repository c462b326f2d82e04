"""Closes enclosures without a gateway: ``python -m talaia.gateway.watchdog.closing``.

Long, because what it leaves out of a gateway stands beside what it has of one.

It reads one line, a `ClosingJob`, from its input, joins the connections that the enclosures need
and no others, and keeps them closed by the gateway's own rules (order, deadlines, retries,
sensors). It ends with 0 when the sensors have said *closed* for a while, and when its input ends.
"""

from __future__ import annotations

import asyncio
import logging
import os
import sys
import threading
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from talaia.clock import SECOND, SystemClock
from talaia.errors import TalaiaError
from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.notices.settings import NoticeSettings  # noqa: TC001 - msgspec reads it
from talaia.gateway.ports import AdapterContext
from talaia.gateway.safety.interlocks import Interlocks
from talaia.gateway.silent_sinks import SilentSinks
from talaia.gateway.watchdog.closing_site import GONE_WORDS, closing_site
from talaia.gateway.watchdog.notices import WatchdogNotices
from talaia.model.arguments import fields_of
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import EnclosureState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.ports import Adapter, CommandOutcome
    from talaia.gateway.velocity_demand import VelocityDemand
    from talaia.model.interlocks.interlock import Step
    from talaia.model.site import Site
    from talaia.wire.frames import FromGateway

__all__ = ["ClosingJob", "WatchdogRecord", "main"]

log = logging.getLogger("talaia.watchdog")
# Tenths of a second, as a gateway judges its interlocks.
LOOK_S = 0.1
# To join the robot's protocol and hear every sensor; then it closes by what it has.
JOIN_S = 5.0
# The sensors must say *closed* for so long: one good reading may be a bouncing switch.
STEADY_S = 3.0
WHY = "the gateway is dead or stands still"


class ClosingJob(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be closed.

    Attributes:
        description: the site's, as YAML.
        folder: where it stands: relative paths in it begin there.
        domain: a ROS domain that overrides the description's.
        record: file to which what was done is added, one JSON object a line; empty: nowhere.
        notices: ways to people; none where there are none.
        failures: so often was it tried before, and ended with an error.
        failed: how the last one ended, in words.

    """

    description: str
    folder: str
    domain: int | None = None
    record: str = ""
    notices: NoticeSettings | None = None
    failures: int = 0
    failed: str = ""


class WatchdogRecord(msgspec.Struct, frozen=True, kw_only=True):
    """What was done, for the gateway that comes back. Time: µs since the epoch (UTC)."""

    time_us: int
    kind: str
    message: str
    good: bool


class _Recorder:
    """A `ControlOutput` and an `EventSink`: to the log and to the record."""

    def __init__(self, path: str, clock: Clock) -> None:
        self._path = path  # "" writes nowhere but to the log.
        self._clock = clock  # UTC for the record.
        # Set by whoever tells people; until then it goes nowhere.
        self.on_enclosure: Callable[[EnclosureState], None] = lambda _state: None

    def record_event(self, kind: str, device: str, message: str, who: str, *, good: bool) -> None:
        message = _plain_message(message)
        log.info("%s %s %s %s", kind, device, message, who)
        if not self._path:
            return
        time_us = self._clock.wall_ns() // 1000
        said = WatchdogRecord(time_us=time_us, kind=kind, message=f"watchdog: {message}", good=good)
        try:
            with Path(self._path).open("ab") as file:
                file.write(msgspec.json.encode(said) + b"\n")
        except OSError as error:
            # It closes first; a disk that is full or broken keeps nothing open.
            log.warning("what was done cannot be written down: %s", error)

    def report_event(
        self, kind: str, message: str, *, device: str = "", who: str = "", good: bool = False
    ) -> None:
        # The rest is for the hub's record; a gateway that comes back writes its own.
        if kind in ("notice_sent", "notice_failed"):
            self.record_event(kind, device, message, who, good=good)
        else:
            log.info("%s %s %s %s", kind, device, message, who)

    def send(self, message: FromGateway) -> None:
        """Tell no hub, but people what an enclosure says."""
        if isinstance(message, EnclosureState):
            said = EnclosureState(enclosure=message.enclosure, why=_plain_message(message.why))
            self.on_enclosure(said)

    def drive(self, device: str, demand: VelocityDemand, key: str = "") -> None:
        """Drive nothing."""

    def stop(self, device: str, *, stopped: bool) -> None:
        """Stop nothing."""


def _plain_message(message: str) -> str:
    # The interlock's words speak of the hub, which matters to nobody here.
    return message.replace(GONE_WORDS, WHY)


class Closing:
    """Keeps enclosures closed. Event loop only."""

    def __init__(
        self,
        job: ClosingJob,
        site: Site,
        *,
        clock: Clock,
        recorder: _Recorder,
        notices: WatchdogNotices,
    ) -> None:
        """Join what is needed of a `closing_site`.

        Raises:
            TalaiaError: a connection cannot be used here.

        """
        self._clock = clock  # Monotonic for deciding.
        self._site = site  # Reduced: only what closing needs, see `closing_site`.
        # Where it is written down, and how people hear of it.
        self._recorder, self._notices = recorder, notices
        loop = asyncio.get_running_loop()
        of = connection_names(site)
        reach = DeviceReachability(of, clock, lambda _state: None)
        # Samples and pictures go nowhere: there is no hub and no spool.
        nothing = SilentSinks()
        context = AdapterContext(
            clock, nothing, nothing, self._recorder, Path(job.folder), job.domain, site=site.name
        )
        adapters: dict[str, tuple[Adapter, ConnectionStatus]] = {}
        # A connection that no enclosure needs is not joined; it could only fail.
        for scope in scopes_of(site):
            if scope.devices:
                adapters[scope.name] = self._make_adapter(
                    scope, context, ConnectionStatus(scope.name, loop, reach)
                )
        self._adapter = MultiAdapter(of=of, adapters=adapters, reach=reach, events=self._recorder)
        self._interlocks = Interlocks(
            site=site,
            readings=self._adapter,
            output=self._recorder,
            run=self._run_steps,
            now_ns=clock.monotonic_ns(),
            wall_ns=clock.wall_ns,
        )
        # Since when all is closed without a break; end switches may bounce.
        self._closed_ns: int | None = None

    @staticmethod
    def _make_adapter(
        scope: ConnectionScope, context: AdapterContext, post: ConnectionStatus
    ) -> tuple[Adapter, ConnectionStatus]:
        return adapter_of(scope, context, post), post

    async def run(self) -> None:
        """Close, and keep closed until the sensors have said so for a while."""
        self._recorder.record_event("watchdog_closes", "", WHY, "", good=False)
        joining = asyncio.ensure_future(self._adapter.run())
        # What is asked before anything is reached is refused, and time goes by until it is again.
        until_ns = self._clock.monotonic_ns() + round(JOIN_S * SECOND)
        try:
            while not joining.done():
                now = self._clock.monotonic_ns()
                if now >= until_ns or self._all_reached():
                    until_ns = now
                    self._interlocks.evaluate_all(now)
                    if self._is_settled(now):
                        self._recorder.record_event(
                            "watchdog_closed", "", "all is closed", "", good=True
                        )
                        self._notices.report_closed()
                        return
                await asyncio.sleep(LOOK_S)
            joining.result()
        finally:
            joining.cancel()
            await asyncio.gather(joining, return_exceptions=True)

    def _all_reached(self) -> bool:
        return all(
            self._adapter.latest(command) is not None for command in self._site.safety_signals()
        )

    def _is_settled(self, now_ns: int) -> bool:
        """Tell whether all is closed, and the telescopes are parked or had their time."""
        rules = self._site.enclosures
        states = [self._interlocks.enclosures.read_enclosure(name, now_ns) for name in rules]
        if not all(seen.closed is True and not seen.moving for seen in states):
            self._closed_ns = None
            return False
        if self._closed_ns is None:
            self._closed_ns = now_ns
        waited = (now_ns - self._closed_ns) / SECOND
        patience = max(rule.mount_within for rule in rules.values())
        parked = all(
            rule.park is None or seen.parked
            for rule, seen in zip(rules.values(), states, strict=True)
        )
        return waited >= STEADY_S and (parked or waited >= patience)

    def _run_steps(self, label: str, steps: tuple[Step, ...]) -> None:
        """See `SequenceStarter`. Each is sent at once: the enclosure guard says what waits."""
        for step in steps:
            device, _, name = step.command.partition("/")
            command = self._site.devices[device].commands[name]
            fields = fields_of(command, step.args)
            if isinstance(fields, str):
                self._recorder.record_event("watchdog_failed", device, fields, "", good=False)
                continue
            self._recorder.record_event(
                "watchdog_command", device, f"{label}: {step.command}", "", good=True
            )
            for roof in self._site.enclosures.values():
                if step.command == roof.close.command:
                    self._notices.report_closing(roof.name)
            self._adapter.act(device, name, fields, partial(self._ended, step.command))

    def _ended(self, command: str, outcome: CommandOutcome) -> None:
        log.info("%s %s %s", command, outcome.phase, outcome.message)


def _end_with_input() -> None:
    """End when the watchdog has ended, however it did."""
    # Not by `sys.stdin`: a thread that waits in there keeps the interpreter from ending cleanly.
    while os.read(0, 1):
        pass
    os._exit(0)


async def _run_closing(job: ClosingJob) -> None:
    clock = SystemClock()
    site = closing_site(load_site(job.description))
    recorder = _Recorder(job.record, clock)
    notices = WatchdogNotices(job.notices, site.name, clock, recorder)
    recorder.on_enclosure = notices.hear_enclosure
    notices.begin_sending(job.failures, job.failed)
    try:
        closing = Closing(job, site, clock=clock, recorder=recorder, notices=notices)
        await closing.run()
    finally:
        await notices.send_due()


def main() -> int:
    """Close; 0 when all is closed, 1 when that failed and is to be tried again."""
    logging.basicConfig(
        level=logging.INFO, format="%(asctime)s %(levelname)s %(name)s: %(message)s"
    )
    job = msgspec.json.decode(sys.stdin.buffer.readline(), type=ClosingJob)
    threading.Thread(target=_end_with_input, daemon=True).start()
    try:
        asyncio.run(_run_closing(job))
    except TalaiaError as error:
        log.critical("%s", error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
