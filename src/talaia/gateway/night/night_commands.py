"""Asks for a night's commands as a person's are asked for, and waits for each one's end."""

from __future__ import annotations

import asyncio
import itertools
from typing import TYPE_CHECKING

from talaia.gateway.night.night_values import NightCommand, StepAnswer
from talaia.wire.frames import CommandPhase, CommandRequest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from talaia.gateway.commands.command_service import CommandService
    from talaia.gateway.night.device_hold import NightHolds
    from talaia.gateway.night.frames.frame_files import FrameFiles
    from talaia.gateway.night.imaging.night_star_devices import AskDevice
    from talaia.wire.frames import Scalar

__all__ = ["NightCommands"]

# Accepted within so long, or not at all (ms).
TTL_MS = 5000.0


class NightCommands:
    """Commands under way. Event loop only."""

    def __init__(
        self,
        commands: CommandService,
        answered: Callable[[StepAnswer], None],
        files: FrameFiles,
    ) -> None:
        """Tell ``answered`` how each one ended; frames are followed by ``files``."""
        self._commands, self._answered, self._files = commands, answered, files
        self._tasks: set[asyncio.Task[None]] = set()

    def begin_command(self, command: NightCommand, who: str) -> None:
        """Ask for a command in the name of ``who``; interlocks and holders may refuse it."""
        task = asyncio.create_task(self._perform(command, who), name=f"night {command.command}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _perform(self, command: NightCommand, who: str) -> None:
        file = self._files.expect_file(command)
        answer = await self.perform_command(command, who)
        self._answered(answer if file is None else await self._files.follow_frame(answer, file))

    async def perform_command(self, command: NightCommand, who: str) -> StepAnswer:
        """Ask for a command as `begin_command` does; give how it ended."""
        device, _, name = command.command.partition("/")
        args = dict(command.args)
        asked = CommandRequest(
            id=command.id, device=device, command=name, args=args, ttl_ms=TTL_MS, who=who
        )
        state = await self._commands.perform_command(asked, command.within, guarded=True)
        phase, message = state.phase, state.message
        if phase in {CommandPhase.ACCEPTED, CommandPhase.RUNNING}:
            phase, message = CommandPhase.UNKNOWN, f"no end after {command.within:g} s"
        return StepAnswer(command.id, phase, message)

    def make_asker(self, prefix: str, holds: NightHolds) -> AskDevice:
        """Give what asks devices as the night does; ids begin with ``prefix``."""
        numbers = itertools.count(1)

        async def ask(command: str, args: Mapping[str, Scalar], within: float) -> StepAnswer:
            asked = NightCommand(f"{prefix}-{next(numbers)}", command, args, within)
            return await self.perform_command(asked, holds.who)

        return ask

    async def close(self) -> None:
        """Wait no longer; what still runs will read as unknown."""
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
