"""A proposal gets no more than its time, though no hub tells the gateway what was used."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from talaia.model.observing.plan import VetoCause
from talaia.model.observing.requests import Configuration, ImageType, Proposal
from talaia.model.observing.states import ObservationState

from .made_nights import asked, clock_at, dawn_of, site_at
from .night_world import NightWorld, live_through

pytest.importorskip("scipy")
S = ObservationState
# Fourteen minutes of block time, and what leads to the blocks.
SCHOOL = Proposal(id="school", share=0.5, hours_allocated=14.5 / 60.0)
CLUB = Proposal(id="club", share=0.5, hours_allocated=2.0 / 60.0)


def test_a_night_without_its_hub_charges_what_it_does_itself(tmp_path: Path) -> None:
    site = site_at(48.0)
    assert site.place is not None
    began = dawn_of(site.place, 3, 10, sun=-12.0) - 3600.0
    world = live_through(
        lambda: NightWorld(site=site, clock=clock_at(began), data=tmp_path, seed=3), live_night
    )
    spent: dict[str, float] = {}
    tries = {one.id: one for one in world.hub.updates.values()}
    for one in tries.values():
        owner = "club" if one.request.startswith("dark") else "school"
        spent[owner] = spent.get(owner, 0.0) + one.block_s
    # By no more than what leads to one block.
    assert spent["school"] <= SCHOOL.hours_allocated * 3600.0 + 60.0
    # It was not left lying either: another block would not have fitted.
    assert spent["school"] >= SCHOOL.hours_allocated * 3600.0 - 260.0
    assert spent["club"] <= CLUB.hours_allocated * 3600.0 + 10.0


async def live_night(world: NightWorld) -> None:
    place = world.site.place
    assert place is not None
    world.robot.bring_about("weather", "clear")
    world.start_gateway()
    high = world.unix + 1800.0
    groups = [asked(f"r{n}", high, place, hours_east=0.4 * n - 0.5) for n in range(6)]
    world.ask([*groups, *darks(world.unix)], proposals=(SCHOOL, CLUB))
    await world.pass_time(1.0)
    world.hub_away()
    world.arm()
    # Rain and a gateway that is killed: neither makes time come back.
    await world.until(lambda: len(world.robot.lights) >= 2, 1800.0, "two pictures")
    world.robot.bring_about("weather", "rain")
    await world.pass_time(120.0)
    world.robot.bring_about("weather", "clear")
    await world.until(lambda: len(world.robot.lights) >= 4, 1800.0, "four pictures")
    await world.kill_gateway()
    world.start_gateway()
    await world.until(lambda: world.sun > -7.5, 6 * 3600.0, "dawn")
    await world.pass_time(120.0)
    world.hub_back()
    await world.pass_time(10.0)
    done = {one.request for one in world.hub.updates.values() if one.state is S.COMPLETED}
    assert 2 <= len(done & {f"r{n}" for n in range(6)}) < 6
    # Of the club's darks the first were paid.
    assert len([name for name in done if name.startswith("dark")]) == 1
    causes = {one.request: one.cause for plan in world.hub.plans for one in plan.why_not}
    assert VetoCause.ALLOCATION in causes.values()


def darks(now: float) -> list:
    """Ask for darks of 80 s, twice, in the name of the club."""
    from .test_calibrations import asked_frames

    part = Configuration(type=ImageType.DARK, exposure=35.0, count=2)
    return [replace(asked_frames(f"dark{n}", now, part), proposal="club") for n in range(2)]
