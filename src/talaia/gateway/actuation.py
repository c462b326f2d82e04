"""All that acts on devices: driving and STOP, interlocks, commands, and sequences of them.

They are made together, for they need one another: an interlock begins sequences, these give
commands, and a command asks the interlocks first.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.commands.command_sequences import Sequences
from talaia.gateway.commands.command_service import Commanding, Journal
from talaia.gateway.disk_trouble import DiskTrouble
from talaia.gateway.driving.control_timer import Pacer
from talaia.gateway.driving.drive_service import Control
from talaia.gateway.driving.persistent_state import Epochs, KeptStops
from talaia.gateway.safety.interlocks import Interlocks

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection
    from pathlib import Path

    from talaia.clock import Clock
    from talaia.gateway.ports import CommandTarget, Mouth, Readings
    from talaia.model.site import Site

__all__ = ["Acting"]

WRITE_AGAIN_S = 1.0


class Acting:
    """Who decides what is done, and sees to it. Event loop only.

    Attributes:
        interlocks: say what may not be done now.
        control: driving, leases and STOP.
        pacer: keeps the time of both; to be touched after anything that concerns them.
        commanding: commands, each to its end.
        sequences: commands that the gateway gives by itself.

    """

    def __init__(
        self,
        site: Site,
        boot: str,
        clock: Clock,
        mouth: Mouth,
        target: CommandTarget,
        readings: Readings,
        data: Path,
        on_disk: Callable[[Callable[[], None]], Awaitable[None]],
    ) -> None:
        """Take up what an earlier run left in the data folder.

        Args:
            site: the description.
            boot: names this run.
            clock: monotonic for every decision.
            mouth: tells robot, hub and record.
            target: who acts on commands.
            readings: the newest values.
            data: the data folder.
            on_disk: runs a blocking write elsewhere, in order; raises what it raises.

        Raises:
            SpoolError: the data folder cannot be used.

        """
        self.interlocks = interlocks = Interlocks(
            site,
            readings,
            mouth,
            lambda label, steps: self.sequences.begin(label, steps),
            clock.monotonic_ns(),
            clock.wall_ns,
        )
        self.control = Control(
            site,
            clock,
            mouth,
            readings,
            Epochs(data / "epochs.json").next,
            KeptStops(data / "stops.json"),
            on_disk,
            interlocks,
        )
        self.pacer = Pacer(asyncio.get_running_loop(), clock, self.control)
        self.commanding = Commanding(
            site,
            clock,
            target,
            Journal(data / "commands.jsonl"),
            on_disk,
            mouth.send,
            lambda device, command, args: interlocks.refusal(
                device, command, clock.monotonic_ns(), args
            ),
            interlocks.commanded,
            lambda device, command: interlocks.hold(device, command, clock.monotonic_ns()),
            lambda device: interlocks.ended(device, clock.monotonic_ns()),
            DiskTrouble(mouth),
            lambda device, command, args: interlocks.refuse_power_cut(
                device, command, clock.monotonic_ns(), args
            ),
        )
        self.sequences: Sequences = Sequences(
            self.commanding,
            mouth,
            boot,
            lambda command: interlocks.reached(command, clock.monotonic_ns()),
        )

    @property
    def busy(self) -> bool:
        """Whether anything moves, or is about to."""
        return self.control.busy or self.commanding.busy or self.sequences.busy

    async def keep_written(self) -> None:
        """Write what the disk did not take as soon as it takes it again, until cancelled."""
        while True:
            await asyncio.sleep(WRITE_AGAIN_S)
            await self.commanding.write_waiting()
            await self.control.write_waiting()

    def redescribe(self, site: Site, devices: Collection[str], now_ns: int) -> None:
        """Decide by another description, which changes ``devices``."""
        self.interlocks.redescribe(site, now_ns)
        self.control.redescribe(site, devices)
        self.commanding.redescribe(site)
