"""Nobody acts against somebody else on a device unasked."""

from __future__ import annotations

import asyncio
import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from patience import PATIENCE_S

from talaia.clock import SECOND, HandClock
from talaia.gateway.commands.command_guard import CommandGuard
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.command_service import CommandService
from talaia.gateway.commands.device_holders import DeviceHolder, DeviceHolders
from talaia.gateway.commands.journal_writer import JournalWriter
from talaia.gateway.ports import CommandOutcome
from talaia.gateway.safety.dome_following import Hold
from talaia.model.yaml_text.load import read_site
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLE = read_site(Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml")


class Robot(CommandGuard):
    """Commands that go on until the test ends them."""

    def __init__(self, folder: Path) -> None:  # noqa: D107
        self.clock = HandClock()
        self.did: list[str] = []
        self.said: list[CommandState] = []
        self.numbers = itertools.count()
        self.waits: Hold | None = None
        self.commanding = CommandService(
            site=EXAMPLE,
            clock=self.clock,
            target=self,
            guard=self,
            writer=JournalWriter(CommandJournal(folder / "c.jsonl"), self.on_disk),
            send=self.said.append,
        )

    def hold_for(self, device: str, command: str) -> Hold | None:
        return self.waits if command == "open" else None

    def act(
        self, device: str, command: str, fields: dict, done: Callable[[CommandOutcome], None]
    ) -> None:
        self.did.append(f"{device}/{command}")
        self.ends = lambda phase: done(CommandOutcome(phase))

    async def on_disk(self, work: Callable[[], None]) -> None:
        work()

    async def asks(
        self, who: str, what: str, *, over: str = "", guarded: bool = True, **args: object
    ) -> CommandState:
        device, _, command = what.partition("/")
        ask = CommandRequest(
            id=f"id-{next(self.numbers)}", device=device, command=command, args=args, ttl_ms=5e3,
            who=who, over=over,
        )  # fmt: skip
        await self.commanding.handle_request(ask, guarded=guarded)
        state = self.commanding.command_state(ask.id)
        assert state is not None
        return state


async def until(holds: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not holds():  # noqa: ASYNC110
            await asyncio.sleep(0.01)


@pytest.fixture
async def robot(tmp_path: Path):
    robot = Robot(tmp_path)
    yield robot
    await robot.commanding.close()


async def test_an_open_against_somebody_elses_close_is_refused_and_says_who_acts(
    robot: Robot,
) -> None:
    closing = await robot.asks("Ada", "dome/close")
    robot.clock.advance(4 * SECOND)
    refused = await robot.asks("Bob", "dome/open")
    assert refused.phase is CommandPhase.REFUSED
    assert refused.message == "Ada is acting on Dome: Close (since 4 s)"
    assert refused.blocked_by == closing.id
    assert robot.did == ["dome/close"]


async def test_who_was_shown_the_command_may_interrupt_it_and_only_that_one(robot: Robot) -> None:
    closing = await robot.asks("Ada", "dome/close")
    other = await robot.asks("Bob", "dome/open", over="another")
    assert (other.phase, other.blocked_by) == (CommandPhase.REFUSED, closing.id)
    done = await robot.asks("Bob", "dome/open", over=closing.id)
    assert done.phase is CommandPhase.RUNNING
    assert robot.did == ["dome/close", "dome/open"]
    # Now both act: whoever comes third is told of the newest.
    third = await robot.asks("Eve", "dome/goto", azimuth=10.0)
    assert third.blocked_by == done.id


async def test_the_hub_is_told_who_acts_and_that_they_do_no_longer(robot: Robot) -> None:
    closing = await robot.asks("Ada", "dome/close")
    assert robot.said[0].acting == "Ada is acting on Dome: Close"
    robot.clock.advance(4 * SECOND)
    robot.said.clear()
    # A hub that comes later hears of it as well.
    robot.commanding.report_states()
    assert [(one.id, one.acting_s) for one in robot.said] == [(closing.id, 4.0)]
    robot.said.clear()
    done = await robot.asks("Bob", "dome/open", over=closing.id)
    hers = [one for one in robot.said if one.id == closing.id]
    assert [(one.acting, one.message) for one in hers] == [("", "interrupted by Bob (Dome: Open)")]
    his = [one for one in robot.said if one.id == done.id]
    assert his[0].over == f"Dome: Close of Ada ({closing.id})"
    assert [one.over for one in his[1:]] == [""]
    assert {one.acting for one in his} == {"Bob is acting on Dome: Open"}
    robot.ends(CommandPhase.SUCCEEDED)
    await until(lambda: robot.said[-1].phase is CommandPhase.SUCCEEDED)
    assert robot.said[-1].acting == ""


async def test_what_waited_is_asked_about_again_when_it_finally_begins(robot: Robot) -> None:
    robot.waits = Hold("waiting for the dome", 60.0)
    waiting = await robot.asks("Ada", "dome/open")
    assert waiting.phase is CommandPhase.ACCEPTED
    over = await robot.asks("Bob", "dome/goto", over=waiting.id, azimuth=10.0)
    assert over.phase is CommandPhase.RUNNING
    robot.waits = None
    ended = robot.commanding.command_state
    await until(
        lambda: ended(waiting.id).phase not in {CommandPhase.ACCEPTED, CommandPhase.RUNNING}
    )
    refused = ended(waiting.id)
    assert (refused.phase, refused.blocked_by) == (CommandPhase.REFUSED, over.id)
    assert refused.message.startswith("Bob is acting on Dome: ")
    assert robot.did == ["dome/goto"]


@pytest.mark.parametrize("what", ["dome/close", "dome/stop", "dome/park"])
async def test_what_makes_safe_asks_nobody(robot: Robot, what: str) -> None:
    await robot.asks("Ada", "dome/open")
    assert (await robot.asks("Bob", what)).phase is CommandPhase.RUNNING


async def test_the_same_person_replaces_and_other_devices_are_free(robot: Robot) -> None:
    await robot.asks("Ada", "dome/open")
    assert (await robot.asks("Ada", "dome/goto", azimuth=10.0)).phase is CommandPhase.RUNNING
    assert (await robot.asks("Bob", "telescope/unpark")).phase is CommandPhase.RUNNING
    # Outlets do one thing each.
    await robot.asks("Ada", "power/outlet8", active=True)
    assert (await robot.asks("Bob", "power/outlet6", active=True)).phase is CommandPhase.RUNNING


async def test_the_gateways_own_safety_steps_are_interrupted_by_nobody(robot: Robot) -> None:
    closing = await robot.asks("enclosure dome close 1", "dome/close", guarded=False)
    refused = await robot.asks("Bob", "dome/goto", azimuth=10.0, over=closing.id)
    assert refused.phase is CommandPhase.REFUSED
    assert "the gateway itself is acting on Dome: Close" in refused.message
    assert refused.blocked_by == ""
    assert (await robot.asks("Bob", "dome/stop")).phase is CommandPhase.RUNNING


async def test_the_gateways_safety_steps_and_following_domes_are_in_nobodys_way(
    robot: Robot,
) -> None:
    await robot.asks("Ada", "dome/open")
    closing = await robot.asks("enclosure dome close 1", "dome/close", guarded=False)
    assert closing.phase is CommandPhase.RUNNING


async def test_a_dome_that_follows_its_telescope_holds_nobody_up(robot: Robot) -> None:
    await robot.asks("follow dome", "dome/goto", guarded=False, azimuth=10.0)
    assert (await robot.asks("Bob", "dome/open")).phase is CommandPhase.RUNNING


async def test_a_command_that_has_ended_holds_nothing(robot: Robot) -> None:
    await robot.asks("Ada", "roof/close")
    await robot.asks("Ada", "dome/goto", azimuth=999.0)
    assert (await robot.asks("Bob", "dome/open")).phase is CommandPhase.RUNNING


def test_a_hold_of_another_kind_than_a_command_counts_as_well_until_it_is_released() -> None:
    holders = DeviceHolders()
    night = DeviceHolder("night-1", "dome", "Dome: observes M 31", "tonight's plan", 0)
    holders.add_holder(night)
    assert holders.holder_against("dome", "Ada") == night
    assert holders.holder_against("dome", "tonight's plan") is None
    assert holders.holder_against("camera", "Ada") is None
    holders.release_holder("night-1")
    assert holders.holder_against("dome", "Ada") is None


async def test_who_drives_a_device_is_gone_over_by_no_command_but_one_that_makes_safe(
    robot: Robot,
) -> None:
    robot.commanding.holders.lease_holder = {"dome": "Ada"}.get  # type: ignore[assignment]
    # Whoever acts as well is only in between.
    closing = await robot.asks("Ada", "dome/close")
    refused = await robot.asks("Bob", "dome/open", over=closing.id)
    assert (refused.message, refused.blocked_by) == ("Ada drives it", "")
    assert (await robot.asks("Ada", "dome/open")).phase is CommandPhase.RUNNING
    # A safety sequence asks nobody.
    assert (await robot.asks("rain", "dome/close", guarded=False)).phase is CommandPhase.RUNNING
