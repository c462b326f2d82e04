"""Waits until telescope and dome are in place for a command that a person asked for."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from talaia.clock import SECOND
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.clock import Clock
    from talaia.gateway.commands.command_guard import CommandGuard
    from talaia.wire.frames import CommandRequest, Scalar

__all__ = ["wait_until_ready"]

WAIT_LOOK_S = 0.1


async def wait_until_ready(
    *,
    guard: CommandGuard,
    clock: Clock,
    ask: CommandRequest,
    named: dict[str, Scalar],
    report: Callable[[str], None],
) -> CommandOutcome | None:
    """Give none when the command may begin, and else how it ended; the interlocks count all along.

    Args:
        guard: says what the command waits for, and whether it may still be done.
        clock: monotonic.
        ask: the command.
        named: its arguments by name.
        report: told what is waited for, each time that this is something else.

    """
    since_ns, said = clock.monotonic_ns(), ""
    try:
        while (held := guard.hold_for(ask.device, ask.command)) is not None:
            waited = (clock.monotonic_ns() - since_ns) / SECOND
            if held.final:
                return CommandOutcome(CommandPhase.REFUSED, held.why)
            # Failed, and not refused: it was accepted, and nothing has been asked of the robot.
            if waited > held.wait_s:
                late = f"{held.why} took longer than {held.wait_s:g} s; nothing was done"
                return CommandOutcome(CommandPhase.FAILED, late)
            if held.why != said:
                said = held.why
                report(said)
            await asyncio.sleep(WAIT_LOOK_S)
            # Interlocks count while it waits: rain ends the waiting.
            if barred := guard.refusal_reason(ask.device, ask.command, named):
                return CommandOutcome(CommandPhase.REFUSED, barred)
    except asyncio.CancelledError:
        # Whoever cancelled it hears so; the robot was never asked.
        return CommandOutcome(CommandPhase.CANCELLED, "it was still waiting; nothing was done")
    return None
