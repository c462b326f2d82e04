"""Commands that the gateway gives by itself, one after the other: of interlocks and link loss."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.gateway.safety.dome_following import FOLLOW_LABEL
from talaia.wire.frames import CommandPhase, CommandRequest

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.gateway.commands.command_service import CommandService
    from talaia.gateway.ports import ControlOutput
    from talaia.gateway.safety.interlock_monitor import SequenceStarter
    from talaia.model.interlocks.interlock import Step

__all__ = ["SequenceRunner", "SequenceSignal"]

# Between two looks at sensors while a step is waited for.
LOOK_S = 0.1
# A sensor may say so a moment later than the answer to the command.
SETTLE_S = 1.0
# Without a time in the description; longer than any roof or mount takes.
LONGEST_S = 120.0


class SequenceSignal:
    """Carries what interlocks want begun to the runner, which is made after them."""

    def __init__(self) -> None:
        """Have no receiver yet."""
        # Filled once while the gateway is put together; never emptied.
        self._receivers: list[SequenceStarter] = []

    def connect(self, receiver: SequenceStarter) -> None:
        """Call this in each `emit_sequence` from here on."""
        self._receivers.append(receiver)

    def emit_sequence(self, label: str, steps: tuple[Step, ...]) -> None:
        """Begin a sequence now."""
        for receiver in self._receivers:
            receiver(label, steps)


class SequenceRunner:
    """Runs sequences; each step once, and never again by itself."""

    def __init__(
        self,
        *,
        commands: CommandService,
        output: ControlOutput,
        boot: str,
        is_reached: Callable[[str], bool | None] = lambda _command: None,
    ) -> None:
        """Run nothing yet.

        Args:
            commands: carries out each step.
            output: writes down how a sequence ended.
            boot: keeps the ids of this run apart from others'.
            is_reached: says of a ``<device>/<command>`` whether sensors show that what it is for
                is so, none where there are none: a telescope that was parked by another command
                is parked.

        """
        self._commands = commands  # Carries out and remembers each step.
        self._output = output  # Writes down how a sequence ended.
        # Part of each id, so that a restart's first command is not taken for a known one.
        self._boot = boot
        self._is_reached = is_reached  # Sensors' word on whether a step is done.
        # Of this run; part of each command's id, so that none comes twice.
        self._count = 0
        # By label: one that still runs is not begun a second time.
        self._running: dict[str, asyncio.Task[None]] = {}
        self._steps: dict[str, tuple[Step, ...]] = {}
        # Those whose place another has taken; they still wait for the robot's answer.
        self._overtaken: set[asyncio.Task[None]] = set()

    @property
    def busy(self) -> bool:
        """Whether a sequence is under way."""
        return bool(self._running)

    @property
    def running(self) -> tuple[str, ...]:
        """Name the sequences that are under way."""
        return tuple(self._running)

    def begin_sequence(self, label: str, steps: tuple[Step, ...]) -> None:
        """See `SequenceStarter`."""
        # The same want is told at each look; only the first begins it.
        if not steps:
            return
        if (running := self._running.get(label)) is not None:
            if not label.startswith(FOLLOW_LABEL) or steps == self._steps[label]:
                return
            # The telescope goes elsewhere now, and the dome with it. That the turn before it comes
            # to no good end is no news.
            self._overtaken.add(running)
            running.add_done_callback(self._overtaken.discard)
        task = asyncio.ensure_future(self._run_steps(label, steps))
        self._running[label], self._steps[label] = task, steps
        task.add_done_callback(lambda ended: self._forget_sequence(label, ended))

    def _forget_sequence(self, label: str, ended: asyncio.Task[None]) -> None:
        if self._running.get(label) is ended:
            del self._running[label], self._steps[label]

    async def _run_steps(self, label: str, steps: tuple[Step, ...]) -> None:
        for step in steps:
            device, _, command = step.command.partition("/")
            self._count += 1
            ask = CommandRequest(
                id=f"{label.replace(' ', '-')}-{self._boot}-{self._count}",
                device=device,
                command=command,
                args=step.args,
                # Nobody waits on a network for it: what makes it late is our own disk, and late
                # is better than never for what makes things safe.
                ttl_ms=3_600_000,
                who=label,
            )
            state = await self._commands.perform_command(ask, step.within)
            if state.phase is CommandPhase.SUCCEEDED or await self._is_so(step, state.phase):
                continue
            if asyncio.current_task() in self._overtaken:
                return
            said = f"{step.command} {state.phase}: {state.message}".rstrip(": ")
            then = "the rest is not done" if step.required else "going on"
            message = f"{label}: {said}; {then}"
            self._output.record_event("sequence_failed", device, message, label, good=False)
            # A required step is what the next ones rely on: a roof must not close on a telescope
            # that did not park.
            if step.required:
                return
        self._output.record_event("sequence_done", "", label, label, good=True)

    async def _is_so(self, step: Step, phase: CommandPhase) -> bool:
        """Tell whether what a command is for is so all the same, by what the sensors say.

        A command may have been refused because it is so already, or have been overtaken by
        another of its kind, which is waited for then.
        """
        # None: no sensor could tell, so the answer to the command stands.
        if (so := self._is_reached(step.command)) is not False:
            return so is True
        if phase is CommandPhase.RUNNING:
            # Its time is over, and it is not so.
            return False
        began_s = asyncio.get_running_loop().time()
        while (waited_s := asyncio.get_running_loop().time() - began_s) < (
            step.within or LONGEST_S
        ):
            if self._is_reached(step.command):
                return True
            # It is not so, and nobody is doing it any more.
            if waited_s > SETTLE_S and not self._commands.is_running(step.command):
                return False
            await asyncio.sleep(LOOK_S)
        return False

    async def close(self) -> None:
        """Wait for nothing more; what is under way reads as unknown."""
        tasks = [*self._running.values(), *self._overtaken]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
