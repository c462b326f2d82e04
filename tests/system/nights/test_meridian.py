"""The simulated mount turns over at the meridian in the middle of a block, which goes on."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import pytest
from msgspec.structs import replace

from talaia.gateway.night.target_place import hour_angle_of
from talaia.model.observing.plan import PauseKind
from talaia.model.observing.requests import Guiding
from talaia.model.observing.states import ObservationState

from .judge import judge_morning, judge_pictures, judge_roof
from .made_nights import asked, clock_at, dawn_of, site_at
from .night_world import NightWorld, live_through
from .sky_robot import Truth
from .trials import SeededGuider

pytest.importorskip("scipy")
S = ObservationState
EXPOSURE_S = 200.0


class Exposing(NamedTuple):
    """A second in which the shutter was open.

    Attributes:
        past: so far past the meridian the target stood (s).
        looks_east: the mount is on the side of its first half.
        telescope: its state.
        unix: when (s since the epoch).

    """

    past: float
    looks_east: bool
    telescope: str
    unix: float


EXPOSING: list[Exposing] = []


def exposes_sky(one: Truth) -> bool:
    return one.camera == "exposing" and one.roof == "open"


class CountingGuider(SeededGuider):
    """Knows when it was asked for a star."""

    def __init__(self) -> None:
        super().__init__()
        self.begun = 0

    async def begin_guiding(self):
        self.begun += 1
        return await super().begin_guiding()


@pytest.mark.parametrize("flip_after", [0.0, 300.0])
def test_a_mount_that_turns_over_does_so_between_two_frames_and_the_block_goes_on(
    flip_after: float, tmp_path: Path
) -> None:
    site = site_at(48.0)
    assert site.place is not None
    assert site.night is not None
    night = replace(
        site.night,
        times=replace(site.night.times, meridian_flip=60.0),
        flip_after=flip_after,
    )
    site = replace(site, night=night)
    began = dawn_of(site.place, 3, 10, sun=-12.0) - 3600.0
    guider = CountingGuider()
    world = live_through(
        lambda: NightWorld(site=site, clock=clock_at(began), data=tmp_path, seed=3, guider=guider),
        live_flip,
    )
    # A star was held on both sides.
    assert guider.begun == 2
    assert [*judge_roof(world.truths, ()), *judge_morning(world), *judge_pictures(world)] == []
    # Each frame was begun, and exposed, by a mount that followed the sky.
    assert {one.telescope for one in EXPOSING} == {"tracking"}
    assert len(EXPOSING) >= 6 * EXPOSURE_S - 12
    # Of the frames on the first side none ended behind what the mount may track; it was used.
    last_east = max(one.past for one in EXPOSING if one.looks_east)
    first_west = min(one.past for one in EXPOSING if not one.looks_east)
    assert last_east <= flip_after + 5.0
    assert last_east > flip_after - EXPOSURE_S - 60.0
    assert first_west >= 0.0
    # The plan of the evening knew of it: when frames would stop for it, and go on behind it.
    (flip,) = next(told.plan.blocks[0].pauses for told in world.hub.plans if told.plan.blocks)
    assert flip.kind is PauseKind.FLIP
    # Whether one frame more fits before it goes by seconds, so it may be off by one.
    off = EXPOSURE_S + 15.0
    assert flip.start == pytest.approx(max(one.unix for one in EXPOSING if one.looks_east), abs=off)
    assert flip.end == pytest.approx(
        min(one.unix for one in EXPOSING if not one.looks_east), abs=off
    )


async def live_flip(world: NightWorld) -> None:
    EXPOSING.clear()
    place = world.site.place
    assert place is not None
    world.robot.bring_about("weather", "clear")
    world.robot.bring_about("telescope", "german")
    world.start_gateway()
    group = asked("m31", world.unix, place, frames=6, seconds=EXPOSURE_S, hours_east=0.25)
    (part,) = group.requests[0].configurations
    guided = replace(
        group.requests[0],
        configurations=(replace(part, guiding=Guiding.ON),),
    )
    world.ask([replace(group, requests=(guided,))])
    world.arm()
    telescope = world.robot.servers["telescope"].model  # type: ignore[attr-defined]

    def is_done() -> bool:
        if world.truths and exposes_sky(world.truths[-1]):
            where = telescope.target
            past = hour_angle_of(where, place, world.unix) * 3600.0 if where else math.nan
            EXPOSING.append(Exposing(past, telescope.looks_east, telescope.state, world.unix))
        return any(one.state is S.COMPLETED for one in world.hub.updates.values())

    await world.until(is_done, 3600.0, "six frames")
    assert {one.state for one in world.hub.updates.values()} == {S.IN_PROGRESS, S.COMPLETED}
    assert len(world.robot.lights) == 6
    assert not telescope.looks_east
    await world.until(lambda: world.sun > -7.5, 4 * 3600.0, "dawn")
    await world.pass_time(120.0)
