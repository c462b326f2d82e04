"""All that acts on devices: driving and STOP, interlocks, commands, and sequences of them.

They are made together, for they need one another: an interlock begins sequences, these give
commands, and a command asks the interlocks first.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.commands.command_guard import InterlockGuard
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.command_sequences import SequenceRunner, SequenceSignal
from talaia.gateway.commands.command_service import HELD_KINDS, CommandService
from talaia.gateway.commands.journal_writer import JournalWriter
from talaia.gateway.commands.request_tasks import RequestTasks
from talaia.gateway.disk_trouble import DiskTrouble
from talaia.gateway.driving.control_timer import ControlTimer
from talaia.gateway.driving.drive_service import DriveService
from talaia.gateway.driving.persistent_state import LeaseEpochs, PersistentStops
from talaia.gateway.driving.stop_writer import StopWriter
from talaia.gateway.driving.twin_service import TwinService
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.renames import changed_devices

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandTarget, ControlOutput, ReadingSource
    from talaia.model.site import Site

__all__ = ["Actuation"]

# s between two tries to write what a full disk refused.
WRITE_AGAIN_S = 1.0


class Actuation:
    """Who decides what is done, and sees to it. Event loop only.

    Attributes:
        interlocks: say what may not be done now.
        driving: driving, leases and STOP.
        twins: where what is driven in digital twins goes.
        timer: keeps the time of both; to be touched after anything that concerns them.
        commands: commands, each to its end.
        sequences: commands that the gateway gives by itself.

    """

    def __init__(
        self,
        *,
        site: Site,
        boot: str,
        clock: Clock,
        output: ControlOutput,
        target: CommandTarget,
        readings: ReadingSource,
        data: Path,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
    ) -> None:
        """Take up what an earlier run left in the data folder.

        Args:
            site: the description.
            boot: names this run.
            clock: monotonic for every decision.
            output: tells robot, hub and record.
            target: who acts on commands.
            readings: the newest values.
            data: the data folder.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        # The description that counts; compared with the next for what is touched.
        self._site, self._clock = site, clock
        # Interlocks are made first and the runner of sequences last.
        sequence_due = SequenceSignal()
        self.interlocks = interlocks = Interlocks(
            site=site,
            readings=readings,
            output=output,
            run=sequence_due.emit_sequence,
            now_ns=clock.monotonic_ns(),
            wall_ns=clock.wall_ns,
        )
        self.driving = DriveService(
            site=site,
            clock=clock,
            output=output,
            readings=readings,
            # Its file is read here: a damaged one ends the start, before anything can be driven.
            next_epoch=LeaseEpochs(data / "epochs.json").next_epoch,
            stops=StopWriter(
                stops=PersistentStops(data / "stops.json"), on_disk=on_disk, output=output
            ),
            interlocks=interlocks,
        )
        # One timer for driving and STOP; it sleeps until the next moment at which something is due.
        self.twins = TwinService(
            site=site, driving=self.driving, readings=readings, output=output, clock=clock
        )
        self.timer = ControlTimer(asyncio.get_running_loop(), clock, self.twins)
        guard = InterlockGuard(interlocks, clock)
        self.commands = CommandService(
            site=site,
            clock=clock,
            target=target,
            guard=guard,
            # Who must not act before its line is on disk waits for it; see `JournalWriter`.
            writer=JournalWriter(
                CommandJournal(data / "commands.jsonl"), on_disk, DiskTrouble(output)
            ),
            send=output.send,
        )
        # A device has one holder, whether it is driven or commanded.
        self.commands.holders.lease_holder = self._lease_holder
        self.driving.acting_against = self.commands.holders.words_against
        # Finished before the timers of commands are stopped.
        self.requests = RequestTasks(self.timer.reset_timer)
        self.sequences = SequenceRunner(
            commands=self.commands,
            output=output,
            boot=boot,
            is_reached=guard.is_reached,
        )
        # From here on an interlock that fires begins its sequence.
        sequence_due.connect(self.sequences.begin_sequence)

    def _lease_holder(self, device: str) -> str:
        """Name who holds the lease of a device that one person at a time commands, too."""
        controller = self.driving.controllers.get(device)
        if controller is None or self._site.devices[device].kind not in HELD_KINDS:
            return ""
        held = controller.lease.holder_at(self._clock.monotonic_ns())
        return "" if held is None else held.who

    @property
    def busy(self) -> bool:
        """Whether anything moves, or is about to."""
        return self.driving.busy or self.commands.busy or self.sequences.busy

    async def keep_written(self) -> None:
        """Write what the disk did not take as soon as it takes it again, until cancelled."""
        while True:
            await asyncio.sleep(WRITE_AGAIN_S)
            # Commands first: an accepted command may hang on its line, a STOP is latched already.
            await self.commands.write_waiting()
            await self.driving.write_waiting()

    def redescribe(self, site: Site) -> None:
        """Decide by another description."""
        devices, self._site = changed_devices(self._site, site), site
        # Interlocks first: driving and commands ask them in the same turn.
        self.interlocks.redescribe(site, self._clock.monotonic_ns())
        # While the controllers are those that twins have driven.
        self.twins.redescribe(site)
        self.driving.redescribe(site, devices)
        self.commands.redescribe(site)
