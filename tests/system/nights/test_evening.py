"""An evening on one simulated clock: armed, observed, rain, again, dawn. The hardware judges."""

from __future__ import annotations

from pathlib import Path

import pytest

from talaia.model.observing.states import ObservationState, SuspensionCause
from talaia.wire.frames import NightPhase

from .made_nights import asked, clock_at, dawn_of, site_at
from .night_world import NightWorld, live_through

pytest.importorskip("scipy")
S = ObservationState


def test_an_evening_with_rain_ends_observed_parked_closed_and_warm(tmp_path: Path) -> None:
    # The last hour that is dark enough: what nothing happens in is not lived through.
    site = site_at(48.0)
    assert site.place is not None
    began = dawn_of(site.place, 3, 10, sun=-12.0) - 3300.0
    live_through(
        lambda: NightWorld(site=site, clock=clock_at(began), data=tmp_path, seed=3), live_evening
    )


async def live_evening(world: NightWorld) -> None:
    place = world.site.place
    assert place is not None
    world.robot.bring_about("weather", "clear")
    world.start_gateway()
    high = world.unix + 1800.0
    world.ask([asked(f"r{n}", high, place, hours_east=n - 1.0, frames=2) for n in range(3)])
    # Nobody has armed it: nothing moves.
    await world.pass_time(120.0)
    assert {one.roof for one in world.truths} == {"closed"}
    world.arm()
    await world.until(lambda: len(world.robot.lights) >= 3, 3 * 3600.0, "three pictures")
    world.robot.bring_about("weather", "rain")
    await world.until(lambda: world.truths[-1].roof == "closed", 90.0, "closed by rain")
    rained = len(world.truths)
    await world.pass_time(300.0)
    assert {one.roof for one in world.truths[rained:]} == {"closed"}
    suspended = [one for one in world.hub.updates.values() if one.state is S.SUSPENDED]
    assert [one.cause for one in suspended] == [SuspensionCause.WEATHER]
    world.robot.bring_about("weather", "clear")
    await world.until(lambda: len(completed(world)) == 3, 2 * 3600.0, "all observed")
    await world.until(lambda: world.sun > -7.8, 4 * 3600.0, "dawn")
    last = world.truths[-1]
    assert (last.roof, last.telescope, last.camera) == ("closed", "parked", "idle")
    # Let warm.
    assert not last.cooling, last
    assert world.phase is NightPhase.WAITING
    # Each picture that was asked for is in the archive, once.
    assert len(world.robot.lights) == 6
    assert len(world.archived()) == len(world.robot.pictures)
    assert {u.state for u in world.hub.updates.values()} == {
        S.IN_PROGRESS,
        S.SUSPENDED,
        S.COMPLETED,
    }


def completed(world: NightWorld) -> set[str]:
    updates = world.hub.updates.values()
    return {one.request for one in updates if one.state is S.COMPLETED}
