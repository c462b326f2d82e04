"""Darks in the rain and flats at dawn, on one simulated clock; the camera's files judge them."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.imaging.frame_tasks import measure_level
from talaia.model.observing.requests import (
    Configuration,
    ImageType,
    Request,
    RequestGroup,
    Window,
)
from talaia.model.observing.states import ObservationState

from .judge import judge_morning, judge_roof
from .made_nights import clock_at, dawn_of, site_at
from .night_world import NightWorld, live_through

pytest.importorskip("scipy")
S = ObservationState


def test_darks_are_taken_in_the_rain_and_flats_at_dawn_and_each_is_what_it_says(
    tmp_path: Path,
) -> None:
    site = site_at(42.0)
    assert site.place is not None
    began = dawn_of(site.place, 3, 10, sun=-12.0) - 1200.0
    live_through(
        lambda: NightWorld(site=site, clock=clock_at(began), data=tmp_path, seed=5), live_morning
    )


def asked_frames(name: str, now: float, *configurations: Configuration) -> RequestGroup:
    return RequestGroup(
        id=f"g-{name}",
        proposal="school",
        requests=(
            Request(
                id=name,
                configurations=configurations,
                windows=(Window(start=now - 60.0, end=now + 86_400.0),),
            ),
        ),
    )


async def live_morning(world: NightWorld) -> None:
    world.robot.bring_about("weather", "rain")
    world.start_gateway()
    dark = Configuration(type=ImageType.DARK, exposure=20.0, count=3, binning=2)
    bias = Configuration(type=ImageType.BIAS, exposure=0.0, count=2)
    flats = Configuration(type=ImageType.SKY_FLAT, exposure=5.0, count=4, filter="R")
    world.ask(
        [asked_frames("darks", world.unix, dark, bias), asked_frames("flats", world.unix, flats)]
    )
    world.arm()
    await world.until(lambda: "darks" in completed(world), 1200.0, "darks")
    assert {one.roof for one in world.truths} == {"closed"}
    # Of a chip that is cooled for them.
    assert world.truths[-1].cooling
    world.robot.bring_about("weather", "clear")
    await world.until(lambda: "flats" in completed(world), 3600.0, "flats")
    # It opened for them alone, and not before the sky was bright enough.
    opened = [one.sun for one in world.truths if one.roof == "open"]
    assert opened
    assert min(opened) > -12.5
    await world.until(lambda: world.sun > 1.0, 7200.0, "day")
    assert [*judge_roof(world.truths, ()), *judge_morning(world)] == []
    # Each picture is in the archive, once.
    assert len(set(world.archived())) == len(world.robot.pictures)
    files = {kind: [data for name, data in world.robot.pictures if f"-{kind}-" in name]
             for kind in ("dark", "bias", "flat")}  # fmt: skip
    assert (len(files["bias"]), len(files["dark"]) >= 3) == (2, True)
    right = [level for data in files["flat"] if (level := measure_level(data)) is not None]
    night = world.site.night
    assert night is not None
    assert night.flats is not None
    assert sum(night.flats.least <= level <= night.flats.most for level in right) == 4
    # Few were of no use.
    assert len(right) <= 8


def completed(world: NightWorld) -> set[str]:
    updates = world.hub.updates.values()
    return {one.request for one in updates if one.state is S.COMPLETED}
