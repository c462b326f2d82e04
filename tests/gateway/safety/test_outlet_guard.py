"""Power that a safe state still needs is cut by nobody."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from talaia.clock import HandClock
from talaia.gateway.commands.command_guard import InterlockGuard
from talaia.gateway.commands.command_journal import CommandJournal
from talaia.gateway.commands.command_service import CommandService
from talaia.gateway.commands.journal_writer import JournalWriter
from talaia.gateway.ports import ChannelReading, CommandOutcome
from talaia.gateway.safety.interlocks import Interlocks
from talaia.model.checks.site_checks import check_site
from talaia.model.interlocks.outlet import Outlet, OutletCommand
from talaia.model.roles import CommandRole
from talaia.model.yaml_text.load import dump_site, load_site, read_site
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.model.site import Site

EXAMPLE = read_site(Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml")
DOME = EXAMPLE.devices["dome"].signals["shutter"].states.index
MOUNT = EXAMPLE.devices["telescope"].signals["state"].states.index
SAFE = {
    "dome/closed": 1.0,
    "dome/shutter": DOME("closed"),
    "dome/position": 0.0,
    "telescope/state": MOUNT("parked"),
}
OPENED = {"dome/shutter": DOME("opened"), "dome/closed": 0.0, "dome/position": 100.0}
OPENING = {"dome/shutter": DOME("opening"), "dome/closed": 0.0, "dome/position": 40.0}


class Robot:
    """Sensors that say what a test wants, and commands that succeed at once."""

    def __init__(self, site: Site, folder: Path) -> None:  # noqa: D107
        self.clock = HandClock()
        self.values: dict[str, float | None] = dict(SAFE)
        self.old_s = 0.0
        self.did: list[str] = []
        self.said: list[CommandState] = []
        self.interlocks = Interlocks(
            site=site,
            readings=self,
            output=self,
            run=lambda _label, _steps: None,
            now_ns=self.clock.monotonic_ns(),
        )
        self.commanding = CommandService(
            site=site,
            clock=self.clock,
            target=self,
            guard=InterlockGuard(self.interlocks, self.clock),
            writer=JournalWriter(CommandJournal(folder / "c.jsonl"), self.on_disk),
            send=self.said.append,
        )

    def latest(self, address: str) -> ChannelReading | None:
        value = self.values.get(address)
        at_ns = self.clock.monotonic_ns() - round(self.old_s * 1e9)
        return None if value is None else ChannelReading(value, at_ns)

    def act(
        self, device: str, command: str, fields: dict, done: Callable[[CommandOutcome], None]
    ) -> None:
        self.did.append(f"{device}/{command}")
        done(CommandOutcome(CommandPhase.SUCCEEDED))

    async def on_disk(self, work: Callable[[], None]) -> None:
        work()

    async def does(self, command: str, *, guarded: bool = True, **args: object) -> CommandState:
        count = str(len(self.said))
        ask = CommandRequest(
            id=count, device="power", command=command, args=args, ttl_ms=5e3, who="Ada"
        )
        await self.commanding.handle_request(ask, guarded=guarded)
        while self.said[-1].phase in (CommandPhase.ACCEPTED, CommandPhase.RUNNING):  # noqa: ASYNC110
            await asyncio.sleep(0)
        return self.said[-1]


@pytest.mark.parametrize(
    ("command", "args", "wrong", "says"),
    [
        ("outlet1", {"active": False}, OPENED, "Dome is not closed"),
        ("outlet1", {"active": False}, {"dome/shutter": DOME("opened")}, "Dome is not closed"),
        ("outlet1", {"active": False}, {"dome/closed": 0.0}, "Dome is not closed"),
        ("outlet1", {"active": False}, {"dome/closed": None}, "Dome is not known to be closed"),
        ("outlet1", {"active": False}, {"dome/shutter": 99.0}, "Dome is not known to be closed"),
        ("reboot", {"outlet": 1}, OPENING, "Dome is not closed"),
        ("outlet2", {"active": False}, {"telescope/state": MOUNT("tracking")}, "it is not parked"),
        ("outlet2", {"active": False}, {"telescope/state": None}, "it is not known to be parked"),
        ("reboot", {"outlet": 2}, {"telescope/state": MOUNT("parking")}, "it is not parked"),
    ],
)
@pytest.mark.parametrize("guarded", [True, False])
async def test_power_of_an_open_dome_or_a_mount_that_is_not_parked_is_cut_by_nobody(
    tmp_path: Path, command: str, args: dict, wrong: dict, says: str, *, guarded: bool
) -> None:
    robot = Robot(EXAMPLE, tmp_path)
    robot.values |= wrong
    state = await robot.does(command, guarded=guarded, **args)
    assert state.phase is CommandPhase.REFUSED
    assert f"needs its power: {says}" in state.message
    assert robot.did == []


@pytest.mark.parametrize(
    ("command", "args", "wrong"),
    [
        ("outlet1", {"active": False}, {}),
        ("reboot", {"outlet": 1}, {"telescope/state": MOUNT("tracking")}),
        ("outlet2", {"active": False}, {"dome/shutter": DOME("opened")}),
        ("outlet1", {"active": True}, {"dome/shutter": DOME("opened")}),
        ("outlet1", {}, {"dome/shutter": DOME("opened")}),
        ("outlet3", {"active": False}, {"dome/shutter": DOME("opened")}),
        ("reboot", {"outlet": 8}, {"dome/shutter": None, "telescope/state": None}),
    ],
)
async def test_what_a_safe_state_does_not_need_may_be_switched_off_and_all_may_be_switched_on(
    tmp_path: Path, command: str, args: dict, wrong: dict
) -> None:
    robot = Robot(EXAMPLE, tmp_path)
    robot.values |= wrong
    state = await robot.does(command, **args)
    assert state.phase is CommandPhase.SUCCEEDED, state.message
    assert robot.did == [f"power/{command}"]


async def test_a_sensor_that_has_grown_silent_counts_as_open(tmp_path: Path) -> None:
    robot = Robot(EXAMPLE, tmp_path)
    robot.old_s = 2.5
    state = await robot.does("outlet1", active=False)
    assert "not known to be closed" in state.message


async def test_a_dome_that_no_enclosure_watches_keeps_its_power_and_the_reason_says_why(
    tmp_path: Path,
) -> None:
    robot = Robot(replace(EXAMPLE, enclosures={}), tmp_path)
    state = await robot.does("outlet1", active=False)
    assert state.phase is CommandPhase.REFUSED
    assert "describe an enclosure that names it" in state.message


def powered(**outlets: Outlet) -> Site:
    power = replace(EXAMPLE.devices["power"], outlets=outlets)
    return replace(EXAMPLE, devices={**EXAMPLE.devices, "power": power})


@pytest.mark.parametrize(
    ("outlets", "where", "says"),
    [
        ({"outlet1": Outlet(feeds=("doome",))}, "outlet1.feeds[0]", "device 'doome'"),
        ({"outlet1": Outlet(feeds=())}, "outlet1.feeds", "it feeds nothing"),
        ({"left": Outlet(feeds=("dome",))}, "left.cut_by", "no command of power is known"),
        (
            {"o": Outlet(feeds=("dome",), cut_by=(OutletCommand(command="off"),))},
            "o.cut_by[0].command", "command 'off'",
        ),
        (
            {"o": Outlet(feeds=("dome",), cut_by=(
                OutletCommand(command="reboot", args={"n": 1}),))},
            "o.cut_by[0].args.n", "argument 'n'",
        ),
        (
            {"o": Outlet(feeds=("dome",), cut_by=(
                OutletCommand(command="reboot", args={"outlet": 99}),))},
            "o.cut_by[0].args", "99 is above 8",
        ),
    ],
)  # fmt: skip
def test_outlets_that_do_not_fit_are_told_with_their_place(
    outlets: dict, where: str, says: str
) -> None:
    found = check_site(powered(**outlets))
    assert [each.where for each in found] == [f"$.devices.power.outlets.{where}"]
    assert says in found[0].problem


async def test_a_command_with_off_behind_the_outlets_name_cuts_its_power(tmp_path: Path) -> None:
    power = EXAMPLE.devices["power"]
    off = replace(
        power.commands["outlet1"], arguments={}, fixed={"data": False}, role=CommandRole.AUTO
    )
    power = replace(power, commands={"plug_off": off}, outlets={"plug": Outlet(feeds=("dome",))})
    site = replace(EXAMPLE, devices={**EXAMPLE.devices, "power": power})
    assert check_site(site) == []
    assert load_site(dump_site(site)) == site
    robot = Robot(site, tmp_path)
    assert (await robot.does("plug_off")).phase is CommandPhase.SUCCEEDED
    robot.values["dome/closed"] = 0.0
    assert (await robot.does("plug_off")).phase is CommandPhase.REFUSED
