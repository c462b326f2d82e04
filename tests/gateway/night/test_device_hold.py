"""The night holds its devices as a person does, and gives way to people."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from night_observatory import example_site

from talaia.clock import SECOND, HandClock
from talaia.gateway.commands.command_guard import CommandGuard
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.command_service import CommandService
from talaia.gateway.commands.journal_writer import JournalWriter
from talaia.gateway.disk_trouble import DiskTrouble
from talaia.gateway.night.device_hold import NightHolds
from talaia.gateway.ports import CommandOutcome
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, NightPhase

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

pytestmark = pytest.mark.pure


class Devices:
    """Devices that are asked, and answer when the test says so."""

    def __init__(self, folder: Path) -> None:
        """Begin with a night that holds nothing."""
        self.clock = HandClock()
        self.said: list[CommandState] = []
        self.pending: list[Callable[[CommandOutcome], None]] = []
        self.commands = CommandService(
            site=example_site(),
            clock=self.clock,
            target=self,
            guard=CommandGuard(),
            writer=JournalWriter(
                CommandJournal(folder / "c.jsonl"), self.on_disk, DiskTrouble(self)
            ),
            send=self.said.append,
        )
        night = example_site().night
        assert night is not None
        self.holds = NightHolds(example_site(), night, self.commands, self.clock)

    async def on_disk(self, work: Callable[[], None]) -> None:
        work()

    def record_event(self, *_: object, **__: object) -> None:
        """Nothing is wrong with this disk."""

    def act(self, _device: str, _command: str, _fields: dict, done: Callable) -> None:
        self.pending.append(done)

    async def ask(self, name: str, command: str, who: str, over: str = "") -> CommandState:
        device, _, word = command.partition("/")
        args = {"ra": 1.0, "dec": 20.0} if word == "goto" else {}
        await self.commands.handle_request(
            CommandRequest(
                id=name, device=device, command=word, args=args, ttl_ms=5000, who=who, over=over
            )
        )
        return next(one for one in reversed(self.said) if one.id == name)

    def person(self) -> str:
        return self.holds.person_at_work(self.clock.monotonic_ns())


async def test_who_asks_for_a_device_of_the_night_is_told_and_may_interrupt_it(
    tmp_path: Path,
) -> None:
    devices = Devices(tmp_path)
    devices.holds.update_holds(NightPhase.OBSERVING, "ada")
    refused = await devices.ask("c1", "telescope/goto", "Bob")
    assert refused.phase is CommandPhase.REFUSED
    assert refused.message.startswith("night (armed by ada) is acting on Telescope")
    assert devices.person() == ""
    taken = await devices.ask("c2", "telescope/goto", "Bob", over=refused.blocked_by)
    assert taken.phase is CommandPhase.RUNNING
    assert devices.person() == "Bob"
    await devices.commands.close()


async def test_the_nights_own_commands_are_not_refused_by_its_own_hold(tmp_path: Path) -> None:
    devices = Devices(tmp_path)
    devices.holds.update_holds(NightPhase.OBSERVING, "ada")
    state = await devices.ask("n1", "telescope/goto", devices.holds.who)
    assert state.phase is CommandPhase.RUNNING
    assert devices.person() == ""
    await devices.commands.close()


async def test_what_makes_safe_asks_nobody_and_is_heard_of(tmp_path: Path) -> None:
    devices = Devices(tmp_path)
    devices.holds.update_holds(NightPhase.OBSERVING, "ada")
    assert (await devices.ask("c1", "dome/close", "Bob")).phase is CommandPhase.RUNNING
    assert devices.person() == "Bob"
    await devices.commands.close()


async def test_it_goes_on_only_a_while_behind_the_end_of_what_a_person_did(tmp_path: Path) -> None:
    devices = Devices(tmp_path)
    await devices.ask("c1", "telescope/park", "Bob")
    devices.clock.advance(1000 * SECOND)
    # It is under way still.
    assert devices.person() == "Bob"
    devices.pending[0](CommandOutcome(CommandPhase.SUCCEEDED))
    await asyncio.sleep(0)
    devices.clock.advance(299 * SECOND)
    assert devices.person() == "Bob"
    devices.clock.advance(2 * SECOND)
    assert devices.person() == ""
    await devices.commands.close()


async def test_nobody_is_held_up_by_a_night_that_rests(tmp_path: Path) -> None:
    devices = Devices(tmp_path)
    devices.holds.update_holds(NightPhase.OBSERVING, "ada")
    devices.holds.update_holds(NightPhase.WAITING, "ada")
    assert (await devices.ask("c1", "telescope/goto", "Bob")).phase is CommandPhase.RUNNING
    await devices.commands.close()
