"""Twilight flats: exposed so that their level is right, and given up in words."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, strategies as st
from night_observatory import EVENING, PureObservatory, example_site, request

from talaia.gateway.night.frames.flat_block import flat_field_place, next_exposure
from talaia.gateway.night.target_place import altitude_of, arcseconds_between
from talaia.model.night_frames import FrameCommand, NightFlats
from talaia.model.observing.requests import Guiding, ImageType
from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.model.units import astronomy
from talaia.wire.frames import NightPhase

pytestmark = pytest.mark.pure
S, P = ObservationState, NightPhase
# In the morning, when the Sun comes nearer (s after the evening).
MORNING = 36_000.0
FLATS = NightFlats(command=FrameCommand(command="camera/flat"), pedestal=100.0)


def twilight(*, morning: bool = False, frames: int = 4, **changes: Any) -> PureObservatory:
    """Give an armed observatory with a request of flats; the Sun stands where flats are taken."""
    world = PureObservatory(flats=FLATS)
    world.now, world.sun = MORNING if morning else 0.0, -10.0
    world.ask(
        request(
            "flats",
            frames=frames,
            seconds=changes.pop("seconds", 5.0),
            type=ImageType.SKY_FLAT,
            guiding=Guiding.OFF,
            **changes,
        )
    )
    world.arm()
    return world


def exposures(world: PureObservatory) -> list[float]:
    named = zip(world.ledger, world.args, strict=True)
    return [float(args["seconds"]) for (_, name, _), args in named if name == "camera/flat"]


def ended(world: PureObservatory) -> bool:
    return any(one.state in {S.COMPLETED, S.FAILED, S.SUSPENDED} for one in world.changes)


def test_flats_are_exposed_until_their_level_is_right_and_those_alone_count() -> None:
    world = twilight(filter="R")
    # The sky darkens while they are taken.
    world.skylight = lambda: 900.0 * 0.998**world.now
    world.until(lambda: ended(world), 1800.0)
    assert world.changes[-1].state is S.COMPLETED
    taken = exposures(world)
    # The first, of 5 s, is too dark; those behind it are right, each longer than the one before.
    assert len(taken) == 5
    assert taken[0] == 5.0
    assert taken[1:] == sorted(taken[1:])
    assert world.asked("wheel/select")[0] < world.asked("camera/flat")[0]
    # No planner was needed, and no two frames are of the same stars.
    assert world.events == []
    sent = [(args["ra"], args["dec"]) for args in world.args if "ra" in args]
    assert len(set(sent)) == len(taken)
    assert all(arcseconds_between(where, sent[0]) < 260.0 for where in sent)  # type: ignore[arg-type]


def test_flats_are_taken_at_dusk_and_dawn_alone_and_only_while_it_may_be_open() -> None:
    for sun in (-7.5, -12.5, -30.0):
        world = twilight()
        world.sun = sun
        world.pass_time(300.0)
        assert world.asked("camera/flat") == []
        assert world.asked("dome/open") == []
    world = twilight()
    world.closing = "Rain: wet"
    world.pass_time(300.0)
    assert world.asked("dome/open") == []
    world.closing = ""
    world.until(lambda: bool(world.asked("camera/flat")))
    world.closing = "Rain: wet"
    world.pass_time(3.0)
    assert world.changes[-1].state is S.SUSPENDED
    assert world.changes[-1].cause is SuspensionCause.WEATHER
    assert world.shutter == "closed"


def test_the_roof_closes_for_the_sun_whatever_flats_are_under_way() -> None:
    world = twilight(morning=True, frames=100)
    world.until(lambda: len(world.asked("camera/flat")) > 2)
    world.sun = -7.9
    world.until(lambda: world.shutter == "closed" and world.executor.phase is P.WAITING)
    assert world.changes[-1].why == "the Sun rises"


def test_at_dusk_a_sky_that_is_too_bright_is_waited_for() -> None:
    world = twilight()
    # Far too bright even for the shortest, and after three minutes right.
    world.skylight = lambda: 300_000.0 if world.now < 180.0 else 15_000.0
    world.until(lambda: ended(world), 1800.0)
    assert world.changes[-1].state is S.COMPLETED
    assert sum(at < 180.0 for at in world.asked("camera/flat")) < 10


@pytest.mark.parametrize(
    ("morning", "light", "words"), [(True, 300_000.0, "too bright"), (False, 20.0, "too dark")]
)
def test_a_sky_that_only_gets_worse_ends_the_flats_in_words_and_counts_no_failure(
    *, morning: bool, light: float, words: str
) -> None:
    world = twilight(morning=morning)
    world.skylight = lambda: light
    world.until(lambda: ended(world), 1800.0)
    last = world.changes[-1]
    assert (last.state, last.cause) == (S.SUSPENDED, SuspensionCause.WEATHER)
    assert last.why == f"the sky is {words} for more flats"
    taken = len(world.asked("camera/flat"))
    world.pass_time(1200.0)
    assert len(world.asked("camera/flat")) == taken


def test_flats_that_never_come_out_right_fail_after_their_tries() -> None:
    world = twilight()
    # Light that jumps about: clouds, a lamp.
    world.skylight = lambda: 400.0 if len(world.asked("camera/flat")) % 2 else 60_000.0
    world.until(lambda: ended(world), 3600.0)
    assert world.changes[-1].state is S.FAILED
    assert world.changes[-1].why.startswith(f"{FLATS.tries} flats and none of a right level")
    assert len(world.asked("camera/flat")) == FLATS.tries


def test_flats_that_nobody_measures_are_not_taken_for_right() -> None:
    world = twilight()
    world.skylight = None
    world.until(lambda: ended(world))
    assert world.changes[-1].state is S.FAILED
    assert "measure" in world.changes[-1].why


def test_the_telescope_looks_away_from_the_sun() -> None:
    place = example_site().place
    assert place is not None
    where = flat_field_place(place, EVENING, 75.0)
    assert altitude_of(where, place, EVENING) == pytest.approx(75.0, abs=0.1)
    here = astronomy.Observer(place.latitude, place.longitude, place.elevation)
    jd = astronomy.julian_day(EVENING)
    sun = astronomy.equatorial_to_horizontal(*astronomy.sun_position(jd), here, jd)
    there = astronomy.equatorial_to_horizontal(*where, here, jd)
    assert (there.az - sun.az) % 360.0 == pytest.approx(180.0, abs=0.1)


@given(st.floats(0.5, 60_000.0), st.floats(0.5, 60.0))
def test_a_steady_sky_is_met_within_a_few_frames(light: float, exposure: float) -> None:
    for _ in range(8):
        level = min(65_535.0, FLATS.pedestal + light * exposure)
        exposure = next_exposure(FLATS, exposure, level)
    assert FLATS.pedestal + light * exposure == pytest.approx(FLATS.level, rel=0.2)
