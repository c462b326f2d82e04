"""What the gateway asks by itself, where a newer want takes an older one's place."""

from __future__ import annotations

import asyncio

import pytest

from talaia.gateway.commands.command_sequences import SequenceRunner
from talaia.model.interlocks.interlock import Step
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState

pytestmark = pytest.mark.pure


class Dome:
    """Takes one turn at a time, as real controllers do: a newer one ends the one before it."""

    def __init__(self) -> None:  # noqa: D107
        self.turns: list[asyncio.Future[CommandPhase]] = []
        self.asked: list[object] = []
        self.events: list[str] = []

    async def perform_command(self, ask: CommandRequest, within: float | None) -> CommandState:
        self.end(CommandPhase.FAILED)
        self.turns.append(turn := asyncio.get_running_loop().create_future())
        self.asked.append(ask.args.get("azimuth", ask.command))
        return CommandState(id=ask.id, device="dome", command=ask.command, phase=await turn)

    def end(self, phase: CommandPhase) -> None:
        for turn in self.turns:
            if not turn.done():
                turn.set_result(phase)

    def is_running(self, _command: str) -> bool:
        return False

    def record_event(self, kind: str, *_about: object, good: bool) -> None:
        self.events.append(kind)


async def begin(runner: SequenceRunner, label: str, *azimuths: float) -> None:
    for azimuth in azimuths:
        step = Step(command="dome/goto", args={"azimuth": azimuth}, required=False)
        runner.begin_sequence(label, (step,))
        for _ in range(5):
            await asyncio.sleep(0)


async def test_a_dome_that_follows_is_sent_to_where_the_telescope_goes_now() -> None:
    dome = Dome()
    runner = SequenceRunner(commands=dome, output=dome, boot="boot")  # type: ignore[arg-type]
    await begin(runner, "follow dome", 10.0, 10.0, 200.0)
    # The same once; and that the turn before it did not end well is told nobody.
    assert (dome.asked, dome.events) == ([10.0, 200.0], [])
    dome.end(CommandPhase.SUCCEEDED)
    await begin(runner, "follow dome", 200.0)
    assert dome.events == ["sequence_done"]
    dome.end(CommandPhase.FAILED)
    await runner.close()


async def test_what_makes_safe_is_not_begun_anew_while_it_is_under_way() -> None:
    dome = Dome()
    runner = SequenceRunner(commands=dome, output=dome, boot="boot")  # type: ignore[arg-type]
    await begin(runner, "interlock rain", 10.0, 200.0)
    assert dome.asked == [10.0]
    await runner.close()
